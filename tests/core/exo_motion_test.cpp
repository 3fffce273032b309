#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "exo_probe.hpp"
#include "glenoid/geodesic.hpp"
#include "glenoid/kinematics.hpp"
#include "support/allocation_guard.hpp"
#include "support/arms.hpp"
#include "support/environment.hpp"
#include "support/matchers.hpp"

namespace glenoid::test {
namespace {

const Vec3 kCentre(0.17, -0.02, 0.01);

ExoSample sample_at(const ExoModel& model, const JetSource& motion, const ExoGuide& guide, double s) {
  PostureJet posture;
  PointJet centre;
  motion.evaluate(motion.context, s, posture, centre);
  ExoSample out;
  const Status status = map_to_exo(model, guide.branch, posture, centre, guide_angles(guide, s), out);
  EXPECT_TRUE(status == Status::Ok || status == Status::ExoInfeasible) << to_string(status);
  return out;
}

ExoSample sample_at(const ExoModel& model, const SmoothMotion& motion, const ExoGuide& guide, double s) {
  return sample_at(model, motion.source(), guide, s);
}

ExoStart start_of(const ExoModel& model, const SmoothMotion& motion, ExoBranch branch = ExoBranch::First) {
  ExoStart start;
  start.branch = branch;
  PostureJet posture;
  PointJet centre;
  motion.evaluate(0.0, posture, centre);
  ExoSample out;
  const Status status = map_to_exo(model, branch, posture, centre, Vec3::Zero(), out);
  EXPECT_TRUE(status == Status::Ok || status == Status::ExoInfeasible) << to_string(status);
  start.shoulder_q = out.q.segment<3>(kShoulder1);
  return start;
}

/// Largest change of the shoulder joints over a fine grid that their rates do not account for (Simpson's rule).
double largest_jump(const ExoModel& model, const JetSource& motion, const ExoGuide& guide, int steps) {
  double worst = 0.0;
  ExoSample a = sample_at(model, motion, guide, 0.0);
  for (int k = 0; k < steps; ++k) {
    const ExoSample m = sample_at(model, motion, guide, (k + 0.5) / steps);
    const ExoSample b = sample_at(model, motion, guide, (k + 1.0) / steps);
    const Vec6 change = b.q - a.q - (a.dq + 4.0 * m.dq + b.dq) / (6.0 * steps);
    worst = std::max(worst, change.cwiseAbs().maxCoeff());
    a = b;
  }
  return worst;
}

TEST(ExoMotion, JointsAreContinuousAlongEveryAcceptedMotionInBothBranches) {
  Random random(21);
  const int count = test_count(10'000);
  int accepted = 0, refused = 0, wound = 0;
  for (int k = 0; k < count; ++k) {
    ExoSettings device = random_device(random, 0.3);
    device.min_singularity_rad = 0.1;
    const ExoModel model(device, kCentre);
    const SmoothMotion motion = SmoothMotion::random(random, 2.5);
    ExoPathCheck check;
    const Status status = check_motion(
        model, motion.source(), start_of(model, motion, k % 2 ? ExoBranch::First : ExoBranch::Second), false, check);
    ASSERT_TRUE(status == Status::Ok || status == Status::ExoInfeasible);
    (status == Status::Ok ? accepted : refused) += 1;
    if (status != Status::Ok) continue;
    ASSERT_EQ(check.start_step_rad, 0.0);
    // the least jump is a change of branch, 2 * 0.1 rad; Simpson's error at 0.1 rad from the singular set stays far below
    ASSERT_LE(largest_jump(model, motion.source(), check.guide, 200), 0.05) << "case " << k;
    const Vec3 travel = guide_angles(check.guide, 1.0) - guide_angles(check.guide, 0.0);
    wound += travel.cwiseAbs().maxCoeff() > kPi ? 1 : 0;
  }
  EXPECT_GT(accepted, count / 10);
  EXPECT_GT(refused, count / 10);
  EXPECT_GT(wound, count / 1000);  // turns of more than pi, which a fixed reference could not unwrap, do occur
}

/// A geodesic with the shoulder's rhythm, evaluated without the help of check_path.
struct GeodesicMotion {
  GeodesicPath path;
  Rhythm rhythm;

  [[nodiscard]] JetSource source() const {
    return {[](const void* self, double s, PostureJet& posture, PointJet& centre) noexcept {
              const auto& motion = *static_cast<const GeodesicMotion*>(self);
              evaluate_path(motion.path, s, posture);
              shoulder_centre_jet(motion.rhythm, posture, centre);
            },
            this};
  }
};

Posture random_posture_within_limits(Random& random) {
  const JointLimits limits;
  Vec4 q;
  for (int i = 0; i < 4; ++i) q[i] = random.uniform(limits.lower[i], limits.upper[i]);
  q[kZeta] -= q[kEta];  // drawn as tau
  return posture_from_angles(q);
}

TEST(ExoMotion, JointsAreContinuousAndGeodesicsReversibleForEveryAcceptedPath) {
  Random random(29);
  const ArmModel arm = default_arm();
  GeodesicSolver solver;
  Certificate certificate;
  const int count = test_count(10'000);
  int accepted = 0;
  for (int k = 0; k < count; ++k) {
    ExoSettings device = random_device(random, 0.6);
    device.min_singularity_rad = 0.1;
    const Posture from = random_posture_within_limits(random), to = random_posture_within_limits(random);
    GeodesicMotion motion{{}, arm.rhythm};
    if (solver.solve(arm, from, to, GeodesicOptions(), nullptr, motion.path, certificate) != Status::Ok)
      continue;  // the solver has tests of its own
    const ExoModel model(device, arm.rhythm.position(from.R_TU.col(2)));
    ExoStart start;
    if (choose_branch(model, from, arm.rhythm.position(from.R_TU.col(2)), std::nullopt, start) != Status::Ok) continue;
    if (k % 2 == 1) start.branch = start.branch == ExoBranch::First ? ExoBranch::Second : ExoBranch::First;
    ExoPathCheck check;
    const Status status = check_path(model, motion.path, arm.rhythm, start, false, check);
    ASSERT_TRUE(status == Status::Ok || status == Status::ExoInfeasible) << to_string(status);
    if (status != Status::Ok) continue;
    ++accepted;
    ASSERT_LE(largest_jump(model, motion.source(), check.guide, 100), 0.05) << "case " << k;

    GeodesicMotion back{{}, arm.rhythm};
    back.path = motion.path;
    const auto order = static_cast<std::size_t>(back.path.order);
    for (std::size_t i = 0; i <= order; ++i) back.path.nodes[i] = motion.path.nodes[order - i];
    finish_path(back.path);
    ExoPathCheck again;
    const ExoStart end{check.guide.branch, guide_angles(check.guide, 1.0), 0.0};
    ASSERT_EQ(check_path(model, back.path, arm.rhythm, end, false, again), Status::Ok) << "case " << k;
    const double s = random.uniform(0.0, 1.0);
    const ExoSample a = sample_at(model, motion.source(), check.guide, s),
                    b = sample_at(model, back.source(), again.guide, 1.0 - s);
    // interpolation rounds to about order * eps; within 0.1 rad of the singular set T magnifies it by less than 1000
    ASSERT_LE(max_difference(a.q, b.q), 1e-10) << "case " << k;
    ASSERT_LE(max_difference(a.dq, -b.dq), 1e-7 * (1.0 + a.dq.norm())) << "case " << k;
  }
  EXPECT_GT(accepted, count / 5);
}

TEST(ExoMotion, ReversingAMotionReversesTheJoints) {
  Random random(22);
  int used = 0;
  for (int k = 0; used < test_count(1000); ++k) {
    ExoSettings device = random_device(random, 0.3);
    device.min_singularity_rad = 0.1;
    const ExoModel model(device, kCentre);
    const SmoothMotion motion = SmoothMotion::random(random);
    SmoothMotion back = motion;
    back.reversed = true;
    ExoPathCheck there, again;
    if (check_motion(model, motion.source(), start_of(model, motion), false, there) != Status::Ok) continue;
    ++used;
    const ExoStart end{there.guide.branch, guide_angles(there.guide, 1.0), 0.0};
    ASSERT_EQ(check_motion(model, back.source(), end, false, again), Status::Ok);
    ASSERT_NEAR(again.singularity_rad, there.singularity_rad, 1e-4);
    for (const double s : {0.0, 0.11, 0.5, 0.93, 1.0}) {
      const ExoSample a = sample_at(model, motion, there.guide, s), b = sample_at(model, back, again.guide, 1.0 - s);
      // s and 1 - (1 - s) differ by eps, times the rates
      const double tolerance = 1e-12 * (1.0 + a.dq.cwiseAbs().maxCoeff() + a.ddq.cwiseAbs().maxCoeff());
      ASSERT_LE(max_difference(a.q, b.q), tolerance) << "case " << k << ", s " << s;
      ASSERT_LE(max_difference(a.dq, -b.dq), 1e3 * tolerance) << "case " << k << ", s " << s;
      ASSERT_LE(max_difference(a.ddq, b.ddq), 1e6 * tolerance) << "case " << k << ", s " << s;
    }
  }
}

/// Extremes by brute force on a grid 40 times finer than the guide's.
struct Extremes {
  double margin = HUGE_VAL, singularity = HUGE_VAL;
  Vec6 lowest = Vec6::Constant(HUGE_VAL), highest = Vec6::Constant(-HUGE_VAL);
  Vec6 highest_at = Vec6::Zero();
};

Extremes brute_force(const ExoModel& model, const SmoothMotion& motion, const ExoGuide& guide) {
  Extremes out;
  constexpr int kSteps = 40 * ExoGuide::kIntervals;
  for (int k = 0; k <= kSteps; ++k) {
    const double s = static_cast<double>(k) / kSteps;
    const ExoSample sample = sample_at(model, motion, guide, s);
    out.margin = std::min(out.margin, sample.margin_rad);
    out.singularity = std::min(out.singularity, sample.singularity_rad);
    out.lowest = out.lowest.cwiseMin(sample.q);
    for (int i = 0; i < 6; ++i) {
      if (sample.q[i] > out.highest[i]) out.highest[i] = sample.q[i], out.highest_at[i] = s;
    }
  }
  return out;
}

TEST(ExoMotion, WorstDistancesAreFoundBetweenTheSamples) {
  Random random(23);
  int infeasible = 0;
  for (int k = 0; k < test_count(500); ++k) {
    const ExoModel model(random_device(random, 0.3), kCentre);
    const SmoothMotion motion = SmoothMotion::random(random, 2.0);
    ExoPathCheck check;
    const Status status = check_motion(model, motion.source(), start_of(model, motion), false, check);
    infeasible += status == Status::ExoInfeasible ? 1 : 0;
    const Extremes truth = brute_force(model, motion, check.guide);
    // the check may find lower than the grid of 1/1280 does, by (1/1280)^2/8 of a curvature of 100 rad, not higher
    ASSERT_LE(check.margin_rad, truth.margin + 2e-5) << "case " << k;
    ASSERT_GE(check.margin_rad, truth.margin - 2e-3) << "case " << k;
    ASSERT_EQ(status, check.margin_rad < -1e-12 ? Status::ExoInfeasible : Status::Ok) << "case " << k;
    ASSERT_EQ(check.refusal, status == Status::Ok ? ExoRefusal::None : ExoRefusal::OutOfReach) << "case " << k;
    PostureJet posture;
    PointJet centre;
    motion.evaluate(check.margin_at, posture, centre);
    ExoSample worst;
    static_cast<void>(map_to_exo(model, ExoBranch::First, posture, centre, Vec3::Zero(), worst));
    ASSERT_EQ(worst.margin_rad, check.margin_rad) << "case " << k;
  }
  EXPECT_GT(infeasible, 10);
}

TEST(ExoMotion, PlantedLimitBetweenTheSamplesIsFound) {
  Random random(24);
  int used = 0;
  for (int k = 0; used < test_count(500); ++k) {
    ExoSettings device = random_device(random, 0.3);
    device.min_singularity_rad = 0.1;
    const SmoothMotion motion = SmoothMotion::random(random, 2.0);
    ExoPathCheck check;
    const ExoModel free(device, kCentre);
    if (check_motion(free, motion.source(), start_of(free, motion), false, check) != Status::Ok) continue;
    ASSERT_EQ(check.limit_margin_rad, kNoExoLimit);
    const Extremes truth = brute_force(free, motion, check.guide);
    for (int joint = 0; joint < 6; ++joint) {
      if (truth.highest_at[joint] == 0.0 || truth.highest_at[joint] == 1.0)
        continue;  // only turning points lie between
      ++used;
      for (const double beyond : {1e-3, 1e-4, -1e-3}) {
        ExoSettings limited = device;
        limited.upper[joint] = truth.highest[joint] - beyond;
        limited.lower[joint] = truth.lowest[joint] - 1.0;
        const ExoModel model(limited, kCentre);
        const Status status = check_motion(model, motion.source(), start_of(free, motion), false, check);
        ASSERT_EQ(status, beyond > 0.0 ? Status::ExoInfeasible : Status::Ok) << "case " << k << ", joint " << joint;
        ASSERT_EQ(check.limit_joint, joint);
        ASSERT_TRUE(check.limit_at_upper);
        ASSERT_LE(check.limit_margin_rad, -beyond + 2e-5) << "case " << k << ", joint " << joint;
        ASSERT_GE(check.limit_margin_rad, -beyond - 2e-3) << "case " << k << ", joint " << joint;
      }
    }
  }
}

TEST(ExoMotion, OtherBranchAnswersWhereItMayAndTheLimitsAllowIt) {
  Random random(25);
  int used = 0;
  for (int k = 0; used < test_count(200); ++k) {
    ExoSettings device = random_device(random, 0.3);
    device.min_singularity_rad = 0.2;
    const SmoothMotion motion = SmoothMotion::random(random, 0.8);
    const ExoModel free(device, kCentre);
    const ExoStart first = start_of(free, motion), second = start_of(free, motion, ExoBranch::Second);
    ExoPathCheck check;
    if (check_motion(free, motion.source(), second, false, check) != Status::Ok) continue;
    const Extremes truth = brute_force(free, motion, check.guide);
    device.lower.segment<3>(kShoulder1) = truth.lowest.segment<3>(kShoulder1) - Vec3::Constant(0.01);
    device.upper.segment<3>(kShoulder1) = truth.highest.segment<3>(kShoulder1) + Vec3::Constant(0.01);
    const ExoModel model(device, kCentre);
    if (check_motion(model, motion.source(), first, false, check) == Status::Ok) continue;
    ++used;
    EXPECT_LT(check.limit_margin_rad, 0.0);
    EXPECT_EQ(check.refusal, ExoRefusal::JointLimit);
    EXPECT_EQ(check.guide.branch, ExoBranch::First);
    ASSERT_EQ(check_motion(model, motion.source(), first, true, check), Status::Ok) << "case " << k;
    EXPECT_EQ(check.guide.branch, ExoBranch::Second);
    EXPECT_TRUE(check.other_branch);
    EXPECT_GT(check.start_step_rad, 0.2);
    EXPECT_GE(check.limit_margin_rad, 0.0);
    // and the choice at the start, without knowledge of the device, is the same
    PostureJet posture;
    PointJet centre;
    motion.evaluate(0.0, posture, centre);
    ExoStart chosen;
    ASSERT_EQ(choose_branch(model, posture_of(posture), centre.p, std::nullopt, chosen), Status::Ok);
    EXPECT_EQ(chosen.branch, ExoBranch::Second);
    ASSERT_EQ(choose_branch(model, posture_of(posture), centre.p, first.shoulder_q, chosen), Status::Ok);
    EXPECT_EQ(chosen.branch, ExoBranch::First);
    EXPECT_LE(max_difference(chosen.shoulder_q, first.shoulder_q), 1e-12);
  }
}

TEST(ExoMotion, NearerToTheSingularSetThanAllowedIsRefusedWithThePlace) {
  // identity device, arm swung through the hanging posture at a distance of 0.05 rad, half way
  ExoSettings device;
  SmoothMotion motion;
  motion.u1 = Vec3::UnitX(), motion.u2 = Vec3::UnitY(), motion.p0 = kCentre, motion.p1 = Vec3::Zero();
  motion.R0 = turn(Vec3::UnitX(), -0.7) * turn(Vec3::UnitY(), 0.05);
  motion.f1 = {1.4, 0.0, 0.0};
  motion.f2 = motion.elbow = motion.travel = {0.0, 0.0, 0.0};
  for (const double least : {0.04, 0.06}) {
    device.min_singularity_rad = least;
    const ExoModel model(device, kCentre);
    ExoPathCheck check;
    EXPECT_EQ(check_motion(model, motion.source(), start_of(model, motion), false, check),
              least < 0.05 ? Status::Ok : Status::ExoInfeasible);
    EXPECT_NEAR(check.singularity_rad, 0.05, 1e-5);
    EXPECT_NEAR(check.singularity_at, 0.5, 1e-2);
    EXPECT_EQ(check.refusal, least < 0.05 ? ExoRefusal::None : ExoRefusal::Singular);
  }
}

class FastTurn : public testing::TestWithParam<double> {};

TEST_P(FastTurn, OfMoreThanHalfATurnWithinOneIntervalIsUnwrapped) {
  // Past the hanging posture at 1 mrad, in the middle of an interval of the guide, while the arm turns about the vertical:
  // joint 1 turns by nearly pi in 1/32 of the motion, plus what the arm turns.
  constexpr double kMiddle = 16.5 / ExoGuide::kIntervals;
  SmoothMotion motion;
  motion.u1 = Vec3::UnitZ(), motion.u2 = Vec3::UnitX(), motion.p0 = kCentre, motion.p1 = Vec3::Zero();
  motion.R0 = turn(Vec3::UnitX(), -1.4 * kMiddle) * turn(Vec3::UnitY(), 1e-3);
  motion.f1 = {GetParam(), 0.0, 0.0}, motion.f2 = {1.4, 0.0, 0.0}, motion.elbow = motion.travel = {0.0, 0.0, 0.0};
  const ExoModel model(ExoSettings(), kCentre);
  ExoPathCheck check;
  ASSERT_EQ(check_motion(model, motion.source(), start_of(model, motion), false, check), Status::Ok);
  ExoGuide step = check.guide;  // a sample at a time, each near the one before
  double joint1 = 0.0;
  for (int k = 0; k <= 20'000; ++k) {
    const ExoSample sample = sample_at(model, motion, step, k / 20'000.0);
    joint1 = sample.q[kShoulder1];
    step.shoulder_q.fill({joint1, sample.q[kShoulder2], sample.q[kShoulder3]});
  }
  EXPECT_NEAR(guide_angles(check.guide, 1.0)[0], joint1, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(BothWays, FastTurn, testing::Values(-6.0, 6.0));

TEST(ExoMotion, WithoutLimitsTheBranchWithAPositiveSecondJointIsTaken) {
  const Posture posture = posture_from_angles(degrees(60, -30, 20, 70));
  ExoSettings device;
  for (const double sign : {1.0, -1.0}) {
    device.axes[2] = sign * Vec3::UnitZ();
    ExoStart start;
    ASSERT_EQ(choose_branch(ExoModel(device, kCentre), posture, kCentre, std::nullopt, start), Status::Ok);
    EXPECT_EQ(start.branch, sign > 0.0 ? ExoBranch::First : ExoBranch::Second);
    EXPECT_GE(start.shoulder_q[1], 0.0);
    EXPECT_LT(start.shoulder_q[1], kPi);
  }
}

TEST(ExoMotion, HangingArmIsServedByTheIdentityDeviceUnlessADistanceIsAsked) {
  SmoothMotion motion;
  motion.u1 = Vec3(1.0, 0.5, 0.0).normalized(), motion.u2 = Vec3::UnitZ(), motion.p0 = kCentre, motion.p1 = Vec3::Zero();
  motion.R0 = Mat3::Identity();
  motion.f1 = {1.2, 0.0, 0.0}, motion.f2 = {0.3, 0.0, 0.0}, motion.elbow = motion.f2, motion.travel = {0.0, 0.0, 0.0};
  const ExoModel model(ExoSettings(), kCentre);
  ExoPathCheck check;
  ASSERT_EQ(check_motion(model, motion.source(), {}, false, check), Status::Ok);
  EXPECT_EQ(check.margin_rad, 0.0);
  EXPECT_EQ(check.singularity_at, 0.0);
  for (int k = 0; k <= 1000; ++k) {
    PostureJet posture;
    PointJet centre;
    motion.evaluate(k / 1000.0, posture, centre);
    const ExoSample out = sample_at(model, motion, check.guide, k / 1000.0);
    ASSERT_LE(max_difference(device_pose(ExoSettings(), out.q), rotation_of(posture)), 1e-12) << k;
  }
  ExoSettings cautious;
  cautious.min_singularity_rad = 1e-3;
  EXPECT_EQ(check_motion(ExoModel(cautious, kCentre), motion.source(), {}, false, check), Status::ExoInfeasible);
}

TEST(ExoMotion, PathAndItsRhythmAreFollowed) {
  const Rhythm rhythm(RhythmSettings(), 0.17);
  const ExoModel model(ExoSettings(), rhythm.position(Vec3::UnitZ()));
  GeodesicPath path;
  const Posture posture = posture_from_angles(degrees(60, -30, 20, 70));
  make_constant_path(posture, path);
  ExoStart start;
  const Vec3 centre = rhythm.position(posture.R_TU.col(2));
  ASSERT_EQ(choose_branch(model, posture, centre, std::nullopt, start), Status::Ok);
  ExoPathCheck check;
  ASSERT_EQ(check_path(model, path, rhythm, start, false, check), Status::Ok);
  EXPECT_LE(max_difference(guide_angles(check.guide, 0.3), start.shoulder_q), 1e-14);
  EXPECT_EQ(check.residual_m, 0.0);
}

TEST(ExoMotion, CentreJetIsTheDerivativeOfTheRhythm) {
  Random random(26);
  const Rhythm rhythm(RhythmSettings(), 0.17);
  for (int k = 0; k < test_count(500); ++k) {
    const SmoothMotion motion = SmoothMotion::random(random, 1.0);
    const double s = random.uniform(0.1, 0.9), h = 1e-5;
    const auto at = [&](double where) {
      PostureJet posture;
      PointJet ignored, out;
      motion.evaluate(where, posture, ignored);
      shoulder_centre_jet(rhythm, posture, out);
      return out;
    };
    PostureJet posture;
    PointJet ignored;
    motion.evaluate(s, posture, ignored);
    if (posture.z.z() < -0.9) continue;  // straight up the rhythm has a kink
    const PointJet m2 = at(s - 2 * h), m = at(s - h), o = at(s), p = at(s + h), p2 = at(s + 2 * h);
    const Vec3 d = (p.p - m.p) / (2 * h), dd = (p.dp - m.dp) / (2 * h);
    const Vec3 d2 = (p2.p - m2.p) / (4 * h), dd2 = (p2.dp - m2.dp) / (4 * h);
    // twice the step triples the error: their difference bounds it; rounding eps/h of 0.2 m and of the rates
    ASSERT_LE((o.dp - d).cwiseAbs().maxCoeff(), (d2 - d).cwiseAbs().maxCoeff() + 1e-16 / h * 10.0) << "case " << k;
    ASSERT_LE((o.ddp - dd).cwiseAbs().maxCoeff(), (dd2 - dd).cwiseAbs().maxCoeff() + 1e-13 / h) << "case " << k;
  }
}

TEST(ExoMotion, NothingIsAllocated) {
  Random random(27);
  ExoSettings device;
  device.axes[2] = Vec3(0.0, 0.6, 0.8);
  device.lower.setConstant(-3.0);
  device.upper.setConstant(3.0);
  const ExoModel model(device, kCentre);
  const SmoothMotion motion = SmoothMotion::random(random);
  const ExoStart start = start_of(model, motion);
  ExoPathCheck check;
  ExoSample out;
  PostureJet posture;
  PointJet centre;
  motion.evaluate(0.5, posture, centre);
  ExoStart chosen;
  AllocationGuard guard;
  static_cast<void>(choose_branch(model, posture_of(posture), centre.p, std::nullopt, chosen));
  static_cast<void>(check_motion(model, motion.source(), start, true, check));
  static_cast<void>(map_to_exo(model, start.branch, posture, centre, guide_angles(check.guide, 0.5), out));
  EXPECT_EQ(guard.allocations(), 0);
}

TEST(ExoMotion, WhatIsNotFiniteIsRefused) {
  const ExoModel model(ExoSettings(), kCentre);
  Random random(28);
  SmoothMotion motion = SmoothMotion::random(random);
  ExoPathCheck check;
  ExoStart start;
  start.shoulder_q[1] = std::nan("");
  EXPECT_EQ(check_motion(model, motion.source(), start, false, check), Status::NotFinite);
  motion.f1.a = std::nan("");
  EXPECT_EQ(check_motion(model, motion.source(), {}, false, check), Status::NotFinite);
}

}  // namespace
}  // namespace glenoid::test
