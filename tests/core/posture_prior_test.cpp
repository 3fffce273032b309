// The prior of the final posture; docs/equations.md, P1 and P2.
#include "glenoid/posture_prior.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "glenoid/motion.hpp"
#include "support/arms.hpp"
#include "support/environment.hpp"
#include "support/matchers.hpp"
#include "support/random.hpp"

namespace glenoid::test {
namespace {

const Posture kStart = posture_from_angles(degrees(15, -30, 30, 60));

PosturePrior prior_at(const ArmModel& arm, const Posture& anchor, const PosturePriorCoefficients& c = {}) {
  return {c, arm, anchor};
}

TEST(PosturePrior, GivesTheAnchorsOwnSwivelAtItsOwnWrist) {
  Random random(1);
  const ArmModel arm = default_arm();
  for (int i = 0; i < test_count(50); ++i) {
    const Posture anchor = posture_from_angles(random_angles(random));
    const ArmPoints points = forward_kinematics(arm, anchor);
    // With everybody tending to this person's own swivel, how far the anchor is believed plays no part.
    PosturePriorCoefficients c;
    c.common_rad = swivel_angle(points);
    EXPECT_NEAR(prior_at(arm, anchor, c).swivel(points.wrist), c.common_rad, 1e-14);
  }
  const ArmPoints points = forward_kinematics(arm, kStart);
  const double deviation = std::abs(PosturePriorCoefficients{}.common_rad - swivel_angle(points));
  EXPECT_NEAR(prior_at(arm, kStart).swivel(points.wrist), swivel_angle(points), 0.01 * deviation)
      << "a well-conditioned start is believed to a percent";
}

TEST(PosturePrior, RisesWithTheTargetAndFallsOutward) {
  const ArmModel arm = default_arm();
  PosturePriorCoefficients c;
  c.regression = 0.0;
  const PosturePrior prior = prior_at(arm, kStart, c);
  const Vec3 wrist = forward_kinematics(arm, kStart).wrist;
  const double here = prior.swivel(wrist);
  EXPECT_NEAR(prior.swivel(wrist + kPriorSpan * Vec3::UnitZ()) - here, c.height_rad, 1e-14);
  EXPECT_NEAR(prior.swivel(wrist + kPriorSpan * Vec3::UnitX()) - here, c.lateral_rad, 1e-14);
  EXPECT_NEAR(prior.swivel(wrist + kPriorSpan * Vec3::UnitY()) - here, 0.0, 1e-14);
}

TEST(PosturePrior, RegressesToTheCommonSwivelFarFromTheAnchor) {
  const ArmModel arm = default_arm();
  const PosturePriorCoefficients c{0.0, 0.0, 1.0, 0.9};
  const PosturePrior prior = prior_at(arm, kStart, c);
  const Vec3 far = forward_kinematics(arm, kStart).wrist + 1e4 * Vec3::UnitY();
  EXPECT_NEAR(prior.swivel(far), 0.9, 1e-6);
}

TEST(PosturePrior, IsSmoothInTheTarget) {
  Random random(2);
  const ArmModel arm = default_arm();
  const PosturePrior prior = prior_at(arm, posture_from_angles(degrees(40, -80, 60, 90)));
  const Vec3 wrist = forward_kinematics(arm, posture_from_angles(degrees(40, -80, 60, 90))).wrist;
  for (int i = 0; i < test_count(50); ++i) {
    const Vec3 direction = random.unit_vector();
    const auto along = [&](double s) { return prior.swivel(wrist + s * direction); };
    // Second differences shrink with the square of the step, at the anchor too, where |d| has a kink and the prior none.
    const auto bend = [&](double s, double h) { return along(s + h) - 2.0 * along(s) + along(s - h); };
    for (const double s : {0.0, 0.05, 0.3}) {
      EXPECT_NEAR(bend(s, 1e-3), 4.0 * bend(s, 5e-4), 1e-8) << "at " << s << " m";
    }
  }
}

TEST(PosturePrior, BelievesNoAnchorWhoseSwivelIsUndefined) {
  const ArmModel arm = default_arm({RhythmModel::Fixed, 1.0, 0.1});
  const PosturePriorCoefficients c{0.0, 0.0, 0.0, 0.7};
  for (const double small : {0.0, 1e-8, 1e-5, 1e-3}) {  // hanging, nearly straight: the swivel angle is noise
    for (const double eta : {-2.0, 0.0, 1.0}) {
      const PosturePrior prior = prior_at(arm, posture_from_angles(Vec4(small, eta, 0.0, small)), c);
      // both levers are below the angles; 1e-3 squared against 0.03 is 1e-9 of belief
      EXPECT_NEAR(prior.swivel(Vec3(0.2, 0.4, 0.0)), 0.7, 1e-8);
    }
  }
}

TEST(PosturePrior, RefusesCoefficientsByName) {
  const ArmModel arm = default_arm();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(contains(refusal([&] { prior_at(arm, kStart, {nan, 0, 0, 0}); }), "posture_prior.height"));
  EXPECT_TRUE(contains(refusal([&] { prior_at(arm, kStart, {0, 11, 0, 0}); }), "posture_prior.lateral"));
  EXPECT_TRUE(contains(refusal([&] { prior_at(arm, kStart, {0, 0, 1.5, 0}); }), "posture_prior.regression"));
  EXPECT_TRUE(contains(refusal([&] { prior_at(arm, kStart, {0, 0, 0, 0, -1}); }), "posture_prior.effort"));
  EXPECT_TRUE(contains(refusal([&] { prior_at(arm, kStart, {0, 0, 0, 0, 0, -1}); }), "posture_prior.lift"));
}

// --- Planning with it ----------------------------------------------------------------------------------------------

/// A random target that the limits allow.
Vec3 feasible_target(const ArmModel& arm, Random& random) {
  Posture end = posture_from_angles(random_angles(random));
  while (limit_margin(arm.limits, end).margin_rad < 0.05) end = posture_from_angles(random_angles(random));
  return forward_kinematics(arm, end).wrist;
}

TEST(PosturePrior, CostIsZeroForTheAnchorAndCountsSwivelAndRotation) {
  Random random(4);
  const ArmModel arm = default_arm();
  for (int i = 0; i < test_count(50); ++i) {
    const Posture anchor = posture_from_angles(random_angles(random, {0.2, 2.5, 0.2, 2.5}));
    const double own = swivel_angle(forward_kinematics(arm, anchor));
    const PosturePrior prior = prior_at(arm, anchor);
    EXPECT_NEAR(prior.cost(arm, anchor, own), 0.0, 1e-14);
    EXPECT_NEAR(prior.cost(arm, anchor, own + 0.4), std::pow(2.0 * std::sin(0.2), 2), 1e-12);
    EXPECT_NEAR(prior.cost(arm, anchor, own + 2.0 * kPi), 0.0, 1e-14);
    const Posture turned = posture_from_angles(random_angles(random, {0.2, 2.5, 0.2, 2.5}));
    const double angle = Eigen::AngleAxisd(Mat3(anchor.R_TU.transpose() * turned.R_TU)).angle();
    const double swivel = swivel_angle(forward_kinematics(arm, turned));
    EXPECT_NEAR(prior.cost(arm, turned, swivel), PosturePriorCoefficients{}.effort * angle * angle, 1e-9);
  }
}

TEST(PosturePrior, CostOfAStraightArmIsThatOfAHardlyBentOne) {
  Random random(5);
  const ArmModel arm = default_arm();
  const PosturePrior prior = prior_at(arm, kStart);
  for (int i = 0; i < test_count(50); ++i) {
    Vec4 q = random_angles(random, {0.3, 2.0, 0.0, 0.0});
    const double straight = prior.cost(arm, posture_from_angles(q), 0.6);
    q[kPhi] = 1e-6;
    EXPECT_NEAR(prior.cost(arm, posture_from_angles(q), 0.6), straight, 2e-5);  // slope of the cost below 20 per rad
  }
}

TEST(HumanPriorPlan, FindsTheLeastUnlikelyPostureWithinTheLimits) {
  Random random(3);
  ReachPlanner planner;
  ReachPlan plan;
  Family family;
  for (int i = 0; i < test_count(60); ++i) {
    const ArmModel arm = default_arm({RhythmModel::Measured, 1.0, 0.1});
    const Vec3 target = feasible_target(arm, random);
    const PosturePrior prior = prior_at(arm, kStart);
    ASSERT_EQ(planner.plan_human_prior(arm, kStart, target, prior, plan), Status::Ok) << "case " << i;
    EXPECT_LT(plan.certificate.hand_error_m, 1e-8);
    const Posture& found = plan.path.nodes[static_cast<std::size_t>(plan.path.order)];
    EXPECT_GE(limit_margin(arm.limits, found).margin_rad, -1e-6);
    const double least = prior.cost(arm, found, prior.swivel(target));
    ASSERT_EQ(planner.sample_family(arm, kStart, target, 180, family), Status::Ok);
    for (int k = 0; k < family.count; ++k) {
      const FamilyMember& m = family.members[static_cast<std::size_t>(k)];
      if (m.margin.margin_rad >= 0.0) {
        EXPECT_LE(least, prior.cost(arm, m.end, prior.swivel(target)) + 1e-9) << "case " << i;
      }
    }
  }
}

TEST(HumanPriorPlan, HasTheExpectedSwivelWhereNothingIsInItsWay) {
  const ArmModel arm = default_arm({RhythmModel::Measured, 1.0, 0.1});
  PosturePriorCoefficients c;
  c.effort = 0.0;
  const PosturePrior prior = prior_at(arm, kStart, c);
  ReachPlanner planner;
  ReachPlan plan;
  for (const Vec3& target : {Vec3(0.20, 0.36, 0.15), Vec3(0.30, 0.30, -0.10), Vec3(0.10, 0.25, 0.10)}) {
    ASSERT_EQ(planner.plan_human_prior(arm, kStart, target, prior, plan), Status::Ok);
    EXPECT_NEAR(plan.swivel_rad, prior.swivel(target), 1e-6);
  }
}

TEST(HumanPriorPlan, RefusesAsTheOtherChoicesDo) {
  const ArmModel arm = default_arm();
  ReachPlanner planner;
  ReachPlan plan;
  const PosturePrior prior = prior_at(arm, kStart);
  EXPECT_EQ(planner.plan_human_prior(arm, kStart, Vec3(2.0, 0.0, 0.0), prior, plan), Status::TargetUnreachable);
  EXPECT_LT(plan.reach_margin_m, 0.0);
  EXPECT_EQ(planner.plan_human_prior(arm, kStart, Vec3::Constant(NAN), prior, plan), Status::NotFinite);
}

TEST(HumanPriorMotion, DoesNotDependOnTheWayToTheTarget) {
  MotionSettings settings;
  settings.swivel_mode = SwivelMode::HumanPrior;
  settings.rhythm.model = RhythmModel::Measured;
  MotionGenerator straight(settings, 0.0), detour(settings, 0.0);
  const Vec3 target(0.20, 0.42, 0.25);
  MotionCommand command;
  command.target = target;
  ASSERT_EQ(straight.command(0.0, command), Status::Ok);
  command.target = Vec3(0.30, 0.30, -0.10);
  ASSERT_EQ(detour.command(0.0, command), Status::Ok);
  command.target = target;
  ASSERT_EQ(detour.command(0.6, command), Status::Ok);
  MotionSample a, b;
  ASSERT_EQ(straight.sample(5.0, a), Status::Ok);
  ASSERT_EQ(detour.sample(5.0, b), Status::Ok);
  EXPECT_EQ(a.status, MotionStatus::Arrived);
  EXPECT_EQ(b.status, MotionStatus::Arrived);
  EXPECT_TRUE(near(a.posture.R_TU, b.posture.R_TU, 1e-7));
  EXPECT_NEAR(a.swivel, b.swivel, 1e-7);
}

TEST(HumanPriorMotion, RetargetsWithoutAJump) {
  MotionSettings settings;
  settings.swivel_mode = SwivelMode::HumanPrior;
  settings.timing = TimingLaw::MinimumJerkHoming;
  MotionGenerator motion(settings, 0.0);
  MotionCommand command;
  ASSERT_EQ(motion.command(0.0, command), Status::Ok);
  MotionSample before, after;
  ASSERT_EQ(motion.sample(0.5, before), Status::Ok);
  command.target = Vec3(0.25, 0.40, 0.10);
  ASSERT_EQ(motion.command(0.5, command), Status::Ok);
  ASSERT_EQ(motion.sample(0.5, after), Status::Ok);
  EXPECT_TRUE(near(after.q, before.q, 1e-9));
  EXPECT_TRUE(near(after.dq, before.dq, 1e-7));
  EXPECT_TRUE(near(after.ddq, before.ddq, 1e-5));
}

}  // namespace
}  // namespace glenoid::test
