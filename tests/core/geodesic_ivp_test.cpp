#include "glenoid/geodesic_ivp.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "glenoid/kinematics.hpp"
#include "glenoid/mass_matrix.hpp"
#include "support/arms.hpp"
#include "support/environment.hpp"
#include "support/matchers.hpp"
#include "support/random.hpp"

namespace glenoid::test {
namespace {

struct Launch {
  Posture start;
  PostureRates rates;
};

/// A start anywhere, also with the arm hanging, and rates as of a reach over [0, 1] (some rad).
Launch random_launch(Random& random, int k) {
  Vec4 q = random_angles(random, {0.0, 2.0, 0.1, 2.2});
  if (k % 4 == 0) q[kTheta] = 0.0;
  return {posture_from_angles(q), {random.vector(1.0), random.uniform(-1.0, 1.0)}};
}

FollowResult follow(const ArmModel& arm, const Launch& launch, const FollowOptions& options = {}) {
  FollowResult out;
  EXPECT_EQ(follow_geodesic(arm, launch.start, launch.rates, options, out), Status::Ok);
  return out;
}

double distance(const Posture& a, const Posture& b) {
  return std::max((a.R_TU - b.R_TU).norm(), std::abs(a.phi - b.phi));
}

PostureRates scaled(const PostureRates& rates, double factor) { return {factor * rates.w_TU_U, factor * rates.phi}; }

double energy(const ArmModel& arm, const Posture& posture, const PostureRates& rates) {
  Vec4 v;
  v << rates.w_TU_U, rates.phi;
  return 0.5 * v.dot(body_mass_matrix(arm, posture) * v);
}

class Integrator : public testing::TestWithParam<bool> {
 protected:
  // Global error of CVODE: a small multiple of the local tolerance per step; 100 to 1000 steps (BDF) of 1e-11.
  static constexpr double kGlobalError = 1e-8;
  static constexpr int kLaunches = 40;
  [[nodiscard]] static FollowOptions options() {
    FollowOptions out;
    out.stiff = GetParam();
    return out;
  }
};

TEST_P(Integrator, KeepsTheEnergy) {
  Random random(1);
  const ArmModel arm = default_arm();
  for (int k = 0; k < kLaunches; ++k) {
    const Launch launch = random_launch(random, k);
    const FollowResult result = follow(arm, launch, options());
    EXPECT_LE(result.energy_drift, kGlobalError);
    const double before = energy(arm, launch.start, launch.rates);
    EXPECT_NEAR(energy(arm, result.postures.back(), result.end_rates) / before, 1.0, kGlobalError)
        << "and reports it truly";
    EXPECT_GT(result.steps, 10);
    ASSERT_EQ(result.postures.size(), 101u);
    EXPECT_LE(distance(result.postures.front(), launch.start), 1e-15);
  }
}

TEST_P(Integrator, ReversedRatesLeadBack) {
  Random random(2);
  const ArmModel arm = default_arm();
  for (int k = 0; k < kLaunches; ++k) {
    const Launch launch = random_launch(random, k);
    const FollowResult there = follow(arm, launch, options());
    const FollowResult back = follow(arm, {there.postures.back(), scaled(there.end_rates, -1.0)}, options());
    for (std::size_t i = 0; i < back.postures.size(); ++i) {
      EXPECT_LE(distance(back.postures[i], there.postures[there.postures.size() - 1 - i]), kGlobalError);
    }
  }
}

TEST_P(Integrator, TwiceTheRatesIsTwiceAsFarAlongTheSamePath) {
  Random random(3);
  const ArmModel arm = default_arm();
  for (int k = 0; k < kLaunches; ++k) {
    const Launch launch = random_launch(random, k);
    const FollowResult once = follow(arm, launch, options());
    const FollowResult half = follow(arm, {launch.start, scaled(launch.rates, 0.5)}, options());
    EXPECT_LE(distance(half.postures.back(), once.postures[50]), kGlobalError);
    EXPECT_LE(distance(half.postures[50], once.postures[25]), kGlobalError);
  }
}

TEST_P(Integrator, SetsOutWithTheGivenRates) {
  // Taylor: after a short while the arm is where its first rates and accelerations put it.
  Random random(4);
  const ArmModel arm = default_arm();
  FollowOptions fine = options();
  fine.samples = 10001;
  const double h = 1.0 / 10000.0;
  for (int k = 0; k < 5; ++k) {
    const Launch launch = random_launch(random, k);
    const FollowResult result = follow(arm, launch, fine);
    const PostureRates a = geodesic_acceleration(arm, launch.start, launch.rates);
    const Vec3 turn = h * launch.rates.w_TU_U + 0.5 * h * h * a.w_TU_U;
    const Mat3 expected = launch.start.R_TU * Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    // Left over: h^3 times third derivatives of size 100 at most, and the integrator.
    EXPECT_TRUE(near(result.postures[1].R_TU, expected, 100.0 * h * h * h + 1e-10));
    EXPECT_NEAR(result.postures[1].phi, launch.start.phi + h * launch.rates.phi + 0.5 * h * h * a.phi,
                100.0 * h * h * h + 1e-10);
  }
}

TEST_P(Integrator, AFixedShoulderConservesTheSpatialAngularMomentum) {
  Random random(5);
  const ArmModel arm = default_arm({}, false);
  const auto momentum = [&arm](const Posture& posture, const PostureRates& rates) -> Vec3 {
    Vec4 v;
    v << rates.w_TU_U, rates.phi;
    return posture.R_TU * (body_mass_matrix(arm, posture) * v).head<3>();
  };
  for (int k = 0; k < kLaunches; ++k) {
    const Launch launch = random_launch(random, k);
    const FollowResult result = follow(arm, launch, options());
    EXPECT_TRUE(
        near(momentum(result.postures.back(), result.end_rates), momentum(launch.start, launch.rates), kGlobalError));
  }
}

TEST_P(Integrator, AStraightArmTurnsAboutItselfForEver) {
  // Pure axial rotation of the straight, axisymmetric arm is a geodesic, whatever the shoulder does.
  for (const bool moving : {false, true}) {
    const Launch launch{posture_from_angles(Vec4(1.0, 0.3, -0.2, 0.0)), {Vec3(0.0, 0.0, 2.0), 0.0}};
    const FollowResult result = follow(default_arm({}, moving), launch, options());
    const Mat3 expected = launch.start.R_TU * Eigen::AngleAxisd(2.0, Vec3::UnitZ()).toRotationMatrix();
    EXPECT_TRUE(near(result.postures.back().R_TU, expected, kGlobalError));
    EXPECT_NEAR(result.postures.back().phi, 0.0, kGlobalError);
  }
}

TEST_P(Integrator, ErrorFollowsTheTolerance) {
  Random random(6);
  const ArmModel arm = default_arm();
  const Launch launch = random_launch(random, 1);
  FollowOptions tight;
  tight.relative_tolerance = 1e-13;
  tight.absolute_tolerance = 1e-14;
  const Posture truth = follow(arm, launch, tight).postures.back();
  double before = 1.0;
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
    FollowOptions loose = options();
    loose.relative_tolerance = tolerance;
    loose.absolute_tolerance = 0.1 * tolerance;
    const double error = distance(follow(arm, launch, loose).postures.back(), truth);
    EXPECT_LE(error, 1e3 * tolerance);
    EXPECT_LT(error, 0.3 * before) << "a hundredth of the tolerance must help";
    before = error;
  }
}

TEST_P(Integrator, RestStaysAtRest) {
  const Launch launch{posture_from_angles(Vec4(0.0, 0.0, 0.3, 0.4)), {}};
  const FollowResult result = follow(default_arm(), launch, options());
  EXPECT_EQ(distance(result.postures.back(), result.postures.front()), 0.0);
  EXPECT_EQ(result.energy_drift, 0.0);
}

INSTANTIATE_TEST_SUITE_P(Method, Integrator, testing::Bool(),
                         [](const auto& method) { return method.param ? "Bdf" : "Adams"; });

TEST(FollowGeodesic, AdamsAndBdfAgree) {
  Random random(7);
  const ArmModel arm = default_arm();
  FollowOptions bdf;
  bdf.stiff = true;
  for (int k = 0; k < 20; ++k) {
    const Launch launch = random_launch(random, k);
    const FollowResult a = follow(arm, launch), b = follow(arm, launch, bdf);
    for (std::size_t i = 0; i < a.postures.size(); ++i) EXPECT_LE(distance(a.postures[i], b.postures[i]), 1e-8);
  }
}

TEST(FollowGeodesic, TheHangingArmHasNoPreferredEta) {
  const ArmModel arm = default_arm();
  const PostureRates rates{Vec3(1.0, -0.5, 0.4), 0.8};
  const Posture truth = follow(arm, {posture_from_angles(Vec4(0.0, 0.0, 0.3, 0.5)), rates}).postures.back();
  for (const double eta : {-2.0, 1.0}) {
    const Launch same{posture_from_angles(Vec4(0.0, eta, 0.3 - eta, 0.5)), rates};
    EXPECT_LE(distance(follow(arm, same).postures.back(), truth), 1e-9);
  }
}

TEST(FollowGeodesic, RefusesBadInputAndLeavesTheOutputAlone) {
  const ArmModel arm = default_arm();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  FollowResult out;
  out.steps = 42;
  Posture bad_posture;
  bad_posture.phi = nan;
  EXPECT_EQ(follow_geodesic(arm, bad_posture, {}, {}, out), Status::NotFinite);
  EXPECT_EQ(follow_geodesic(arm, {}, {Vec3(nan, 0.0, 0.0), 0.0}, {}, out), Status::NotFinite);
  EXPECT_EQ(follow_geodesic(arm, {}, {}, {nan, 1e-9, false, 11}, out), Status::NotFinite);
  EXPECT_EQ(follow_geodesic(arm, {}, {}, {1e-9, 1e-9, false, 1}, out), Status::OutOfRange);
  EXPECT_EQ(follow_geodesic(arm, {}, {}, {0.0, 1e-9, false, 11}, out), Status::OutOfRange);
  EXPECT_EQ(follow_geodesic(arm, {}, {}, {1e-9, -1.0, false, 11}, out), Status::OutOfRange);
  EXPECT_EQ(out.steps, 42);
  EXPECT_TRUE(out.postures.empty());
}

TEST(FollowGeodesic, SaysWhenTheIntegratorCannotGoOn) {
  // 1e6 turns within the unit interval need more steps than are allowed: a status, no hang, nothing printed.
  FollowResult out;
  testing::internal::CaptureStderr();
  const Status status = follow_geodesic(default_arm(), posture_from_angles(Vec4(1.0, 0.0, 0.0, 1.0)),
                                        {Vec3(1e7, 2e6, 0.0), 0.0}, {}, out);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(status, Status::NoConvergence);
  EXPECT_TRUE(out.postures.empty());
}

}  // namespace
}  // namespace glenoid::test
