// The equations of the arm as load, against the core's and against elementary mechanics.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

#include "bus/drives_arm.hpp"
#include "glenoid/kinematics.hpp"
#include "glenoid/mass_matrix.hpp"
#include "support/matchers.hpp"

namespace glenoid::test {
namespace {

using load::ArmDynamics;
using load::ArmLoadSettings;
using load::Mat6;

/// First and second derivative at 0 of a smooth curve, of fourth order in the step.
template <class Curve>
void differentiate(const Curve& curve, Vec3& first, Vec3& second) {
  constexpr double h = 1e-3;
  const Vec3 a = curve(-2 * h), b = curve(-h), c = curve(0.0), d = curve(h), e = curve(2 * h);
  first = (a - 8 * b + 8 * d - e) / (12 * h);
  second = (-a + 16 * b - 30 * c + 16 * d - e) / (12 * h * h);
}

PostureJet jet_of(const Vec4& q, const Vec4& v) {
  const auto column = [&](int k) {
    return [&, k](double t) { return Vec3(posture_from_angles(q + t * v).R_TU.col(k)); };
  };
  PostureJet jet;
  jet.x = column(0)(0.0);
  jet.z = column(2)(0.0);
  differentiate(column(0), jet.dx, jet.ddx);
  differentiate(column(2), jet.dz, jet.ddz);
  jet.phi = q[kPhi];
  jet.dphi = v[kPhi];
  jet.ddphi = 0.0;
  return jet;
}

TEST(ArmDynamics, PulledBackThroughTIsTheMassMatrixAndTheCoriolisVectorOfTheArm) {
  Random random(41);
  int seen = 0;
  for (int k = 0; k < 200; ++k) {
    ArmLoadSettings settings = usual();
    settings.exo.base = random.vector(0.5);
    settings.gravity_m_per_s2 = 0.0;
    const Vec4 q = random_angles(random, {0.2, 2.6, 0.1, 2.4}), v = random.vector4(2.0);
    // A shoulder that stands still: then the arm's own coordinates and the device's say the same.
    RhythmSettings fixed;
    fixed.model = RhythmModel::Fixed;
    const ArmModel arm = make_arm_model(scale_subject(Subject()), Rhythm(fixed, settings.girdle_length_m),
                                        JointLimits(), true);
    const Vec3 centre = arm.rhythm.position(Vec3::UnitZ());
    const ExoModel exo(settings.exo, centre);
    const PointJet still{centre, Vec3::Zero(), Vec3::Zero()};
    const auto sampled = [&](const Vec4& rates, ExoSample& out) {
      return map_to_exo(exo, ExoBranch::First, jet_of(q, rates), still, Vec3::Zero(), out);
    };
    ExoSample along;
    if (sampled(v, along) != Status::Ok || along.singularity_rad < 0.2) continue;
    Eigen::Matrix<double, 6, 4> T;
    for (int i = 0; i < 4; ++i) {
      ExoSample one;
      ASSERT_EQ(sampled(Vec4::Unit(i), one), Status::Ok);
      T.col(i) = one.dq;
    }
    Mat6 M;
    Vec6 bias;
    ArmDynamics(settings).evaluate(along.q, along.dq, M, bias);
    // Differences of fourth order: 1e-3^4 / 30 of the fifth derivative, and rounding 2e-16 / 1e-6, over sin(0.2) twice.
    EXPECT_TRUE(near(T.transpose() * M * T, mass_matrix(arm, q), 1e-9));
    EXPECT_TRUE(near(T.transpose() * (M * along.ddq + bias), coriolis_vector(arm, q, v), 1e-6));
    ++seen;
  }
  EXPECT_GT(seen, 50);
}

/// Kinetic energy of the segments from positions a short time before and after, J.
double energy_of_points(const ArmLoadSettings& settings, const Vec6& x, const Vec6& v) {
  const ExoModel exo(settings.exo, Vec3(settings.girdle_length_m, 0.0, 0.0));
  constexpr double h = 1e-4;
  double energy = 0.0;
  const auto place = [&](double t, bool forearm, const Vec3& own) -> Vec3 {
    const Vec6 at = x + t * v;
    const Mat3 R_TU = exo_upper_arm(exo, at);
    const Vec3 centre = exo_centre(exo, at, settings.girdle_length_m);
    if (!forearm) return centre + R_TU * own;
    return centre - settings.upper_arm.length_m * R_TU.col(2) +
           R_TU * (Eigen::AngleAxisd(at[kElbow], Vec3::UnitX()) * own);
  };
  for (const bool forearm : {false, true}) {
    const Segment& s = forearm ? settings.forearm : settings.upper_arm;
    // Six equal points on the principal axes have the moments of the segment: r_x^2 = 3 (I_y + I_z - I_x) / (2 m).
    const Vec3& I = s.inertia_kg_m2;
    const Vec3 square = 1.5 / s.mass_kg * Vec3(I.y() + I.z() - I.x(), I.x() + I.z() - I.y(), I.x() + I.y() - I.z());
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        const Vec3 own = Vec3(0.0, 0.0, -s.com_m) + sign * std::sqrt(square[axis]) * Vec3::Unit(axis);
        const Vec3 speed = (place(h, forearm, own) - place(-h, forearm, own)) / (2.0 * h);
        energy += 0.5 * s.mass_kg / 6.0 * speed.squaredNorm();
      }
    }
  }
  return energy;
}

TEST(ArmDynamics, EnergyIsThatOfPointMassesOnTheDevicesForwardKinematics) {
  Random random(42);
  for (int k = 0; k < 100; ++k) {
    const ArmLoadSettings settings = random_device(random);
    const Vec6 x = random6(random, 1.5), v = random6(random, 1.0);
    Mat6 M;
    Vec6 bias;
    ArmDynamics(settings).evaluate(x, v, M, bias);
    const double energy = 0.5 * v.dot(M * v);
    // Central differences: h^2 / 6 of a third derivative below 6^3 (six joints at 1 rad/s), relative.
    EXPECT_NEAR(energy, energy_of_points(settings, x, v), 1e-8 / 6.0 * 216.0 * (1.0 + energy));
    EXPECT_TRUE(near(M, M.transpose(), 0.0));
  }
}

TEST(ArmDynamics, WeightIsTheGradientOfThePotential) {
  Random random(43);
  for (int k = 0; k < 100; ++k) {
    const ArmLoadSettings settings = random_device(random);
    const ArmDynamics dynamics(settings);
    const Vec6 x = random6(random, 1.5);
    Mat6 M;
    Vec6 weight;
    dynamics.evaluate(x, Vec6::Zero(), M, weight);
    constexpr double h = 1e-5;
    for (int i = 0; i < 6; ++i) {
      const Vec6 step = h * Vec6::Unit(i);
      const double slope = (dynamics.potential_J(x + step) - dynamics.potential_J(x - step)) / (2.0 * h);
      EXPECT_NEAR(weight[i], slope, 1e-8);  // h^2 / 6 of 20 J, and rounding 1e-15 * 20 J / h
    }
  }
}

/// Acceleration of the unpowered mechanism with a rotor of J at every joint.
Vec6 free_acceleration(const ArmDynamics& dynamics, const Vec6& x, const Vec6& v, double J) {
  Mat6 M;
  Vec6 bias;
  dynamics.evaluate(x, v, M, bias);
  return (M + J * Mat6::Identity()).llt().solve(-bias);
}

TEST(ArmDynamics, FreeMotionUnderGravityKeepsItsEnergy) {
  Random random(44);
  constexpr double J = 0.15;
  for (int k = 0; k < 10; ++k) {
    const ArmDynamics dynamics(random_device(random));
    Vec6 x = random6(random, 1.0), v = random6(random, 1.0);
    const double before = total_energy(dynamics, x, v, J);
    constexpr double h = 1e-3;
    for (int n = 0; n < 1000; ++n) {  // Runge and Kutta's fourth order
      const Vec6 a1 = free_acceleration(dynamics, x, v, J), v2 = v + 0.5 * h * a1;
      const Vec6 a2 = free_acceleration(dynamics, x + 0.5 * h * v, v2, J), v3 = v + 0.5 * h * a2;
      const Vec6 a3 = free_acceleration(dynamics, x + 0.5 * h * v2, v3, J), v4 = v + h * a3;
      const Vec6 a4 = free_acceleration(dynamics, x + h * v3, v4, J);
      x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
      v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
    // h^4 over 1 s at rates of some rad/s: (h w)^4 w with w = 10 rad/s, of 10 J.
    EXPECT_NEAR(total_energy(dynamics, x, v, J), before, 1e-6);
  }
}

}  // namespace
}  // namespace glenoid::test
