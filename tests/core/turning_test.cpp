// Laws of the turning cost in the metric (docs/equations.md, M6); derivatives and geodesics from independent means.
#include "turning.hpp"

#include <gtest/gtest.h>

#include "glenoid/geodesic_ivp.hpp"
#include "numeric_derivative.hpp"
#include "path_probe.hpp"
#include "support/matchers.hpp"
#include "support/random.hpp"

namespace glenoid::test {
namespace {

// The shortest length of the feature is its width, 0.1 rad, as that of the rhythm's smoothing: see derivative_at_zero.
constexpr double kNumeric = 1e-9;

ArmModel turning_arm(double factor) {
  ScaledArm scaled = scale_subject(Subject());
  apply_axial_factor(scaled, factor);
  return make_arm_model(scaled, Rhythm(RhythmSettings(), scaled.shoulder_distance_m), JointLimits(), true);
}

/// Postures anywhere, every fourth one hanging or nearly so.
Posture some_posture(Random& random, int k) {
  Vec4 q = random_angles(random, {0.0, 2.5, 0.1, 2.2});
  if (k % 4 == 0) q[kTheta] = k % 8 == 0 ? 0.0 : 0.05;
  return posture_from_angles(q);
}

TEST(Turning, RatesAreTheDerivatives) {
  Random random(1);
  for (int k = 0; k < test_count(60); ++k) {
    const Mat3 R = some_posture(random, k).R_TU;
    const Vec3 w = random.vector(1.0);
    const TurningFeature feature = turning_feature(R);
    const auto along = [&](double s) { return turning_feature(R * rotation(Vec3(s * w))); };
    EXPECT_TRUE(near(feature.t_rate * w, derivative_at_zero([&](double s) { return along(s).t; }), kNumeric));
    const auto rate = [&](double s) { return Vec2(along(s).t_rate * w); };
    const Vec2 bend = derivative_at_zero(rate);
    EXPECT_TRUE(near(turning_bend(feature, w), bend, 100.0 * kNumeric));  // a length more: tenfold terms
    const Vec2 force(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    EXPECT_NEAR(w.dot(turning_curvature(feature, force) * w), force.dot(bend), 100.0 * kNumeric);
  }
}

TEST(Turning, IsTheAxialRotationAwayFromTheVertical) {
  // t = (sin zeta, cos zeta) sin theta / sqrt(sin^2 theta + width^2): turning the plane of elevation does not change it
  Random random(2);
  for (int k = 0; k < test_count(50); ++k) {
    const Vec4 q = random_angles(random, {0.0, 2.5, 0.1, 2.2});
    const double share = std::sin(q[kTheta]) / std::hypot(std::sin(q[kTheta]), kTurningWidth);
    const Vec2 expected(share * std::sin(q[kZeta]), share * std::cos(q[kZeta]));
    EXPECT_TRUE(near(turning_feature(posture_from_angles(q).R_TU).t, expected, 1e-14));
  }
}

TEST(Turning, AddsItsSquareToTheMetric) {
  Random random(3);
  const ArmModel arm = turning_arm(4.0);
  ArmModel without = arm;
  without.turning_kg_m2 = 0.0;
  EXPECT_GT(arm.turning_kg_m2, 0.01);
  for (int k = 0; k < test_count(50); ++k) {
    const Posture p = some_posture(random, k);
    const PostureRates v{random.vector(1.0), random.uniform(-1.0, 1.0)};
    Vec4 rates;
    rates << v.w_TU_U, v.phi;
    const Mat4 more = body_mass_matrix(arm, p) - body_mass_matrix(without, p);
    const Vec2 rate = turning_feature(p.R_TU).t_rate * v.w_TU_U;
    EXPECT_NEAR(rates.dot(more * rates), arm.turning_kg_m2 * rate.squaredNorm(), 1e-14);
  }
}

TEST(Turning, CostsNothingAtFactorOne) {
  const ArmModel plain = default_arm(), one = turning_arm(1.0);
  EXPECT_EQ(one.turning_kg_m2, 0.0);
  EXPECT_EQ(one.mass, plain.mass);
}

TEST(Turning, GeodesicIsThatOfTheInitialValueProblem) {
  Random random(4);
  GeodesicSolver solver;
  GeodesicPath path;
  Certificate certificate;
  for (int k = 0; k < test_count(24); ++k) {
    const ArmModel arm = turning_arm(k % 2 == 0 ? 2.0 : 4.0);
    const Posture start = some_posture(random, k), end = displaced(start, random.vector4(0.5));
    ASSERT_EQ(solve_tightly(solver, arm, start, end, path, certificate), Status::Ok) << "case " << k;
    // first derivatives carry the tail times N^2, the end of the initial-value problem some times that
    const double rate_error = path.order * path.order * (certificate.spectral_tail + 1e-15 * path.order);
    EXPECT_NEAR(energy_at(arm, path, 0.3) / path.energy, 1.0, 1e-9 + 100.0 * rate_error) << "case " << k;
    PostureJet jet;
    evaluate_path(path, 0.0, jet);
    FollowResult followed;
    ASSERT_EQ(follow_geodesic(arm, start, as_rates(body_rates(jet)), FollowOptions(), followed), Status::Ok);
    EXPECT_LT(posture_distance(followed.postures.back(), end), 1e-7 + 100.0 * rate_error) << "case " << k;
  }
}

TEST(Turning, IsPaidForByTheOtherJoints) {
  // A dearer term is used no more: along the path the mean square of the turning rate falls as its weight grows
  Random random(5);
  GeodesicSolver solver;
  GeodesicPath path;
  Certificate certificate;
  for (int k = 0; k < test_count(12); ++k) {
    const Posture start = some_posture(random, k), end = displaced(start, random.vector4(0.5));
    double before = 1e300;
    for (const double weight : {0.0, 0.01, 0.03}) {
      ArmModel arm = default_arm();
      arm.turning_kg_m2 = weight;
      ASSERT_EQ(solve_tightly(solver, arm, start, end, path, certificate), Status::Ok) << "case " << k;
      double sum = 0.0;
      for (int i = 0; i < 100; ++i) {
        const auto t = [&path](double lambda) { return turning_feature(path_posture(path, lambda).R_TU).t; };
        sum += (t((i + 1) / 100.0) - t(i / 100.0)).squaredNorm();
      }
      EXPECT_LE(sum, before * (1.0 + 1e-3) + 1e-9) << "case " << k;
      before = sum;
    }
  }
}

}  // namespace
}  // namespace glenoid::test
