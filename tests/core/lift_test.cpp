// Laws of paths that are bent upward (docs/equations.md, G7) and of how much they are (P3).
#include <gtest/gtest.h>

#include <limits>

#include "glenoid/geodesic_ivp.hpp"
#include "glenoid/motion.hpp"
#include "glenoid/posture_prior.hpp"
#include "glenoid/swivel.hpp"
#include "numeric_derivative.hpp"
#include "path_probe.hpp"
#include "support/matchers.hpp"
#include "support/random.hpp"

namespace glenoid::test {
namespace {

constexpr double kLift = 0.2;  // m; of a level reach over 0.32 m

ArmModel human_arm(double mass_scale = 1.0) {
  ScaledArm scaled = scale_subject(Subject());
  for (Segment* s : {&scaled.upper_arm, &scaled.forearm}) s->mass_kg *= mass_scale, s->inertia_kg_m2 *= mass_scale;
  apply_axial_factor(scaled, kHumanAxialFactor);
  return make_arm_model(scaled, Rhythm(RhythmSettings(), scaled.shoulder_distance_m), JointLimits(), true);
}

struct Pair {
  Posture start, end;
};

Pair random_pair(Random& random) {
  const Posture start = posture_from_angles(random_angles(random, {0.0, 1.6, 0.3, 2.2}));
  return {start, displaced(start, random.vector4(0.5))};
}

GeodesicPath lifted_path(const ArmModel& arm, const Pair& pair, double lift_m, Certificate& certificate) {
  GeodesicSolver solver;
  GeodesicOptions options;
  options.tail_tolerance = 1e-10;
  options.lift_m = lift_m;
  GeodesicPath path;
  EXPECT_EQ(solver.solve(arm, pair.start, pair.end, options, nullptr, path, certificate), Status::Ok);
  return path;
}

double mean_height(const ArmModel& arm, const GeodesicPath& path) {
  constexpr int kPoints = 200;
  double sum = 0.0;
  for (int i = 0; i < kPoints; ++i) sum += mass_height(arm, path_posture(path, (i + 0.5) / kPoints));
  return sum / kPoints;
}

TEST(Lift, HeightIsThatOfTheSegmentsMasses) {
  Random random(1);
  const ArmModel arm = default_arm();
  for (int k = 0; k < test_count(50); ++k) {
    const Posture p = posture_from_angles(random_angles(random));
    const ArmPoints points = forward_kinematics(arm, p);
    const Segment &u = arm.upper_arm, &f = arm.forearm;
    const Vec3 upper = points.shoulder + u.com_m / u.length_m * (points.elbow - points.shoulder);
    const Vec3 fore = points.elbow + f.com_m / f.length_m * (points.wrist - points.elbow);
    const double expected = u.mass_kg * (upper - points.shoulder).z() + f.mass_kg * (fore - points.shoulder).z();
    EXPECT_NEAR(mass_height(arm, p), expected, 1e-14);
  }
}

TEST(Lift, AcceleratesDownTheGradientOfTheHeight) {
  Random random(2);
  const ArmModel arm = human_arm();
  for (int k = 0; k < test_count(50); ++k) {
    const Posture p = posture_from_angles(random_angles(random));
    const PostureRates v{random.vector(1.0), random.uniform(-1.0, 1.0)};
    const PostureRates plain = geodesic_acceleration(arm, p, v), bent = geodesic_acceleration(arm, p, v, kLift);
    Vec4 more;
    more << bent.w_TU_U - plain.w_TU_U, bent.phi - plain.phi;
    const Vec4 direction = random.vector4(1.0);
    const auto along = [&](double s) { return Vec3(mass_height(arm, displaced(p, s * direction)), 0.0, 0.0); };
    const double slope = derivative_at_zero(along).x();
    EXPECT_NEAR(direction.dot(body_mass_matrix(arm, p) * more), -kLift * slope, 1e-10);
  }
}

TEST(Lift, PathIsThatOfTheInitialValueProblem) {
  Random random(3);
  for (int k = 0; k < test_count(24); ++k) {
    const ArmModel arm = human_arm();
    const Pair pair = random_pair(random);
    Certificate certificate;
    const GeodesicPath path = lifted_path(arm, pair, kLift, certificate);
    EXPECT_EQ(path.lift_m, kLift);
    EXPECT_TRUE(certificate.hessian_positive) << "case " << k;
    const double rate_error = path.order * path.order * (certificate.spectral_tail + 1e-15 * path.order);
    PostureJet jet;
    evaluate_path(path, 0.0, jet);
    FollowOptions options;
    options.lift_m = kLift;
    FollowResult followed;
    ASSERT_EQ(follow_geodesic(arm, pair.start, as_rates(body_rates(jet)), options, followed), Status::Ok);
    EXPECT_LT(posture_distance(followed.postures.back(), pair.end), 1e-7 + 100.0 * rate_error) << "case " << k;
    EXPECT_LT(followed.energy_drift, 1e-8);
  }
}

TEST(Lift, ConservesEnergyAndHeightTogetherAndSaysSo) {
  Random random(4);
  const ArmModel arm = human_arm();
  for (int k = 0; k < test_count(24); ++k) {
    Certificate certificate;
    const GeodesicPath path = lifted_path(arm, random_pair(random), kLift, certificate);
    const auto conserved = [&](double lambda) {
      return energy_at(arm, path, lambda) + kLift * mass_height(arm, path_posture(path, lambda));
    };
    const double rate_error = path.order * path.order * (certificate.spectral_tail + 1e-15 * path.order);
    EXPECT_NEAR(conserved(0.3), conserved(0.8), path.energy * (1e-9 + 100.0 * rate_error)) << "case " << k;
    EXPECT_LT(certificate.speed_variation, 1e-9 + 100.0 * rate_error) << "case " << k;
    EXPECT_GT(std::abs(energy_at(arm, path, 0.0) - energy_at(arm, path, 0.5)), 1e-6 * path.energy) << "case " << k;
  }
}

TEST(Lift, RaisesTheWayAndNotItsEnds) {
  Random random(5);
  const ArmModel arm = human_arm();
  for (int k = 0; k < test_count(24); ++k) {
    const Pair pair = random_pair(random);
    double before = -std::numeric_limits<double>::infinity();
    for (const double lift : {0.0, 0.1, 0.3}) {
      Certificate certificate;
      const GeodesicPath path = lifted_path(arm, pair, lift, certificate);
      const double height = mean_height(arm, path);
      EXPECT_GT(height, before) << "case " << k;
      before = height;
      EXPECT_LT(posture_distance(path_posture(path, 0.0), pair.start), 1e-12);
      EXPECT_LT(posture_distance(path_posture(path, 1.0), pair.end), 1e-12);
    }
  }
}

TEST(Lift, DoesNotDependOnHowHeavyTheArmIs) {
  Random random(6);
  for (int k = 0; k < test_count(12); ++k) {
    const Pair pair = random_pair(random);
    Certificate certificate;
    const GeodesicPath one = lifted_path(human_arm(), pair, kLift, certificate);
    const GeodesicPath two = lifted_path(human_arm(2.0), pair, kLift, certificate);
    EXPECT_LT(posture_distance(path_posture(one, 0.5), path_posture(two, 0.5)), 1e-8) << "case " << k;
  }
}

TEST(Lift, OfPeopleGrowsWithTheSquareOfTheLevelWayAndIsBounded) {
  const PosturePrior prior({}, default_arm(), posture_deg(15, -30, 30, 60));
  const double k = PosturePriorCoefficients{}.lift_per_m;
  const Vec3 from(0.1, 0.2, -0.2);
  EXPECT_EQ(prior.lift(from, from + 0.5 * Vec3::UnitZ()), 0.0);
  EXPECT_NEAR(prior.lift(from, from + Vec3(0.12, -0.16, 0.3)), k * 0.04, 1e-15);
  EXPECT_NEAR(prior.lift(from, from + 9.0 * Vec3::UnitX()), k * kMostLevel * kMostLevel, 1e-15);
}

TEST(Lift, PlanOfPeopleHasItAndTheOthersHaveNone) {
  const ArmModel arm = human_arm();
  const Posture start = posture_deg(25, -40, 40, 95);
  const Vec3 wrist = forward_kinematics(arm, start).wrist, target = wrist + Vec3(0.10, 0.12, 0.0);
  PosturePriorCoefficients none;
  none.lift_per_m = 0.0;
  const PosturePrior prior({}, arm, start);
  ReachPlanner planner;
  ReachPlan lifted, plain, least;
  ASSERT_EQ(planner.plan_human_prior(arm, start, target, prior, lifted), Status::Ok);
  ASSERT_EQ(planner.plan_human_prior(arm, start, target, PosturePrior(none, arm, start), plain), Status::Ok);
  ASSERT_EQ(planner.plan_minimum_energy(arm, start, target, least), Status::Ok);
  EXPECT_EQ(lifted.path.lift_m, prior.lift(wrist, target));
  EXPECT_EQ(plain.path.lift_m, 0.0);
  EXPECT_EQ(least.path.lift_m, 0.0);
  const auto middle = [&arm](const ReachPlan& plan) {
    return forward_kinematics(arm, path_posture(plan.path, 0.5)).wrist.z();
  };
  EXPECT_GT(middle(lifted) - middle(plain), 0.3 * lifted.path.lift_m / 8.0) << "a free mass rises by an eighth of it";
  EXPECT_LT(lifted.certificate.speed_variation, 1e-4);
}

}  // namespace
}  // namespace glenoid::test
