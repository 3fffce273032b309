// The homing time course (docs/equations.md, T5) and the axial factor of the metric (M5).
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "glenoid/mass_matrix.hpp"
#include "glenoid/motion.hpp"
#include "numeric_derivative.hpp"
#include "support/arms.hpp"
#include "support/environment.hpp"
#include "support/matchers.hpp"
#include "support/random.hpp"

namespace glenoid::test {
namespace {

TEST(HomingMinimumJerk, RestsAtBothEndsAndNeverTurnsBack) {
  for (const double T : {0.3, 1.0, 1.5, 3.0, 20.0}) {
    for (const double end : {0.0, T}) {
      const ScalarJet s = homing_minimum_jerk(2.0 + end, 2.0, T);
      EXPECT_NEAR(s.value, end == 0.0 ? 0.0 : 1.0, 1e-15);
      EXPECT_NEAR(s.d1, 0.0, 1e-12);
      EXPECT_NEAR(s.d2, 0.0, 1e-12);
    }
    for (int k = 1; k < 200; ++k) EXPECT_GT(homing_minimum_jerk(T * k / 200.0, 0.0, T).d1, 0.0) << T << ' ' << k;
  }
}

TEST(HomingMinimumJerk, IsMinimumJerkForMovementsOfASecondAndBelow) {
  for (const double T : {0.2, 0.9, 1.0}) {
    for (const double share : {0.1, 0.5, 0.8}) {
      const ScalarJet a = homing_minimum_jerk(share * T, 0.0, T), b = minimum_jerk(share * T, 0.0, T);
      EXPECT_NEAR(a.value, b.value, 1e-15);
      EXPECT_NEAR(a.d1, b.d1, 1e-12 / T);
      EXPECT_NEAR(a.d2, b.d2, 1e-11 / (T * T));
    }
  }
}

TEST(HomingMinimumJerk, PeaksTheEarlierTheSlowerTheMovement) {
  const auto middle = [](double T) { return homing_minimum_jerk(0.5 * T, 0.0, T).value; };
  EXPECT_GT(middle(1.5), middle(1.0));
  EXPECT_GT(middle(3.0), middle(1.5));
  EXPECT_DOUBLE_EQ(middle(30.0), middle(60.0)) << "the tail is bounded";
}

TEST(HomingMinimumJerk, DerivativesAreThoseOfTheValue) {
  constexpr double T = 2.0, h = 1e-4;
  for (const double t : {0.2, 0.7, 1.3, 1.9}) {
    const auto at = [](double x) { return homing_minimum_jerk(x, 0.0, T); };
    // central differences: h^2 / 6 times the third (fourth) derivative, below 100 (1000), and rounding eps / h
    EXPECT_NEAR((at(t + h).value - at(t - h).value) / (2.0 * h), at(t).d1, 100.0 * h * h / 6.0 + 1e-11);
    EXPECT_NEAR((at(t + h).d1 - at(t - h).d1) / (2.0 * h), at(t).d2, 1000.0 * h * h / 6.0 + 1e-11);
  }
}

/// Rate of the direction of the vertical in the upper arm's cross-section, as M6 has it, per body rate; by differences.
Eigen::Matrix<double, 2, 3> turning_rate(const Mat3& R) {
  Eigen::Matrix<double, 2, 3> out;
  for (Eigen::Index k = 0; k < 3; ++k) {
    out.col(k) = derivative_at_zero([&](double s) {
      const Mat3 turned = R * Eigen::AngleAxisd(s, Vec3::Unit(k)).toRotationMatrix();
      const Eigen::Vector2d v(turned(2, 0), turned(2, 1));
      return Eigen::Vector2d(v / std::sqrt(v.squaredNorm() + 0.01));
    });
  }
  return out;
}

TEST(AxialFactor, AddsTheAxialInertiaAndTurning) {
  MotionSettings plain, heavy;
  heavy.axial_factor = 3.0;
  const MotionGenerator a(plain, 0.0), b(heavy, 0.0);
  const double added = 2.0 * (a.scaled_arm().upper_arm.inertia_kg_m2.z() + a.scaled_arm().forearm.inertia_kg_m2.z());
  Random random(6);
  for (int i = 0; i < test_count(50); ++i) {
    Vec4 q = random_angles(random);
    q[kPhi] = 0.0;  // straight: both segments turn about the same axis
    const Posture p = posture_from_angles(q);
    const Mat4 more = body_mass_matrix(b.arm(), p) - body_mass_matrix(a.arm(), p);
    Mat4 expected = Mat4::Zero();
    expected(2, 2) = added;
    const Eigen::Matrix<double, 2, 3> turning = turning_rate(p.R_TU);
    expected.topLeftCorner<3, 3>() += added * turning.transpose() * turning;  // M6: as much again against the vertical
    EXPECT_TRUE(near(more, expected, 1e-10));                                 // error of the numeric rate
  }
}

TEST(AxialFactor, ThatIsNotGivenIsOneExceptWithTheHumanPrior) {
  EXPECT_EQ(effective_axial_factor(0.0, SwivelMode::MinimumEnergy), 1.0);
  EXPECT_EQ(effective_axial_factor(0.0, SwivelMode::HumanPrior), kHumanAxialFactor);
  EXPECT_EQ(effective_axial_factor(1.0, SwivelMode::HumanPrior), 1.0);
  MotionSettings settings;
  settings.swivel_mode = SwivelMode::HumanPrior;
  double energy[2] = {};
  for (const double factor : {0.0, kHumanAxialFactor}) {
    settings.axial_factor = factor;
    MotionGenerator generator(settings, 0.0);
    ASSERT_EQ(generator.command(0.0, {Vec3(0.20, 0.42, 0.25)}), Status::Ok);
    energy[factor == 0.0 ? 0 : 1] = generator.state().path.energy;
  }
  EXPECT_GT(energy[0], 0.0);
  EXPECT_EQ(energy[0], energy[1]);
}

TEST(AxialFactor, IsRefusedOutsideItsRange) {
  MotionSettings settings;
  for (const double factor : {-1.0, 0.99, 5.01, std::nan("")}) {
    settings.axial_factor = factor;
    EXPECT_TRUE(contains(refusal([&] { const MotionGenerator g(settings, 0.0); }), "metric.axialFactor")) << factor;
  }
}

}  // namespace
}  // namespace glenoid::test
