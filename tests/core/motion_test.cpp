// The facade: movements in time, re-planning, stopping, refusals, state; docs/equations.md, T1-T4.
#include "glenoid/motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "path_probe.hpp"
#include "support/allocation_guard.hpp"
#include "support/matchers.hpp"

namespace glenoid::test {
namespace {

constexpr double kDuration = 1.5;
const Vec3 kTarget(0.20, 0.42, 0.25);

MotionCommand go_to(const Vec3& target) {
  MotionCommand command;
  command.target = target;
  return command;
}

MotionCommand halt(const Vec3& target) {
  MotionCommand command = go_to(target);
  command.stop = true;
  return command;
}

MotionSample sample_at(const MotionGenerator& motion, double time_s) {
  MotionSample out;
  EXPECT_EQ(motion.sample(time_s, out), Status::Ok);
  return out;
}

/// All numbers of a sample, for comparisons bit for bit.
std::vector<double> numbers(const MotionSample& s) {
  std::vector<double> out;
  const auto add = [&out](const auto& m) { out.insert(out.end(), m.data(), m.data() + m.size()); };
  add(s.q), add(s.dq), add(s.ddq), add(s.posture.R_TU), add(s.shoulder), add(s.elbow), add(s.wrist), add(s.girdle);
  add(s.exo_q), add(s.exo_dq), add(s.exo_ddq);
  out.insert(out.end(), {s.posture.phi, s.swivel, s.progress, s.energy, s.misalignment, s.exo_residual,
                         static_cast<double>(s.status)});
  return out;
}

bool all_finite(const MotionSample& s) {
  const std::vector<double> values = numbers(s);
  return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

double rest_error(const MotionSample& s) { return s.dq.norm() + s.ddq.norm(); }

TEST(Motion, IsIdleAtTheStartPostureUntilCommanded) {
  const MotionSettings settings;
  const MotionGenerator motion(settings, 3.0);
  for (const double time : {3.0, 4.0, 1e6}) {
    const MotionSample s = sample_at(motion, time);
    EXPECT_TRUE(near(s.q, settings.start_q, 1e-12));
    EXPECT_EQ(rest_error(s), 0.0);
    EXPECT_EQ(s.status, MotionStatus::Idle);
    EXPECT_EQ(s.progress, 0.0);
    EXPECT_EQ(s.misalignment, 0.0);
  }
  EXPECT_EQ(motion.path().order, 0);
  EXPECT_STREQ(motion.message(), "");
}

TEST(Motion, BeginsAndEndsAtRestAtTheTarget) {
  const MotionSettings settings;
  MotionGenerator motion(settings, 3.0);
  ASSERT_EQ(motion.command(3.0, go_to(kTarget)), Status::Ok);
  const MotionSample first = sample_at(motion, 3.0), last = sample_at(motion, 3.0 + kDuration);
  EXPECT_TRUE(near(first.q, settings.start_q, 1e-9));
  EXPECT_LT(rest_error(first), 1e-9);
  EXPECT_TRUE(near(last.wrist, kTarget, 1e-9));
  EXPECT_LT(rest_error(last), 1e-9);
  EXPECT_EQ(sample_at(motion, 3.0 + 0.5 * kDuration).status, MotionStatus::Moving);
  EXPECT_EQ(last.status, MotionStatus::Arrived);
  EXPECT_EQ(last.progress, 1.0);
  EXPECT_EQ(numbers(sample_at(motion, 1e5)), numbers(last));
}

class EachTimingLaw : public testing::TestWithParam<TimingLaw> {
 protected:
  EachTimingLaw() : motion_(settings()) { EXPECT_EQ(motion_.command(0.0, go_to(kTarget)), Status::Ok); }
  static MotionSettings settings() {
    MotionSettings out;
    out.timing = GetParam();
    return out;
  }
  MotionGenerator motion_;
};
INSTANTIATE_TEST_SUITE_P(Laws, EachTimingLaw,
                         testing::Values(TimingLaw::MinimumJerkRiemannian, TimingLaw::MinimumJerkHand));

TEST_P(EachTimingLaw, RatesAndAccelerationsAreDerivatives) {
  constexpr double h = 1e-5;  // truncation h^2 q''''/6 with q'''' about 1e3 rad/s^4: 2e-8; rounding 1e-15/h: 1e-10
  for (double t = 0.05; t < 1.45; t += 0.1) {
    const MotionSample low = sample_at(motion_, t - h), s = sample_at(motion_, t), high = sample_at(motion_, t + h);
    EXPECT_TRUE(near((high.q - low.q) / (2.0 * h), s.dq, 1e-6)) << t;
    EXPECT_TRUE(near((high.dq - low.dq) / (2.0 * h), s.ddq, 1e-5)) << t;
    EXPECT_TRUE(near((high.exo_q - low.exo_q) / (2.0 * h), s.exo_dq, 1e-6)) << t;
    EXPECT_TRUE(near((high.exo_dq - low.exo_dq) / (2.0 * h), s.exo_ddq, 1e-5)) << t;
  }
}

TEST_P(EachTimingLaw, PointsAreThoseOfTheAngles) {
  for (double t = 0.0; t <= 1.6; t += 0.2) {
    const MotionSample s = sample_at(motion_, t);
    EXPECT_LT(posture_distance(posture_from_angles(s.q), s.posture), 1e-9) << t;
    const ArmPoints points = forward_kinematics(motion_.arm(), s.posture);
    EXPECT_TRUE(near(points.shoulder, s.shoulder, 1e-12));
    EXPECT_TRUE(near(points.elbow, s.elbow, 1e-12));
    EXPECT_TRUE(near(points.wrist, s.wrist, 1e-12));
    EXPECT_TRUE(near(girdle_centre(s.girdle), s.shoulder, 1e-12));
    EXPECT_NEAR(s.misalignment, (s.shoulder - sample_at(motion_, 0.0).shoulder).norm(), 1e-12);
    EXPECT_NEAR(s.swivel, swivel_angle(points), 1e-12);
    EXPECT_EQ(s.energy, motion_.path().energy);
  }
}

TEST(Motion, KineticEnergyFollowsTheMinimumJerkOfTheArcLength) {
  MotionGenerator motion{MotionSettings{}};
  ASSERT_EQ(motion.command(0.0, go_to(kTarget)), Status::Ok);
  for (double t = 0.1; t < 1.5; t += 0.2) {
    const MotionSample s = sample_at(motion, t);
    const double u = t / kDuration;
    const double lambda = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u),
                 rate = 30.0 * u * u * (1.0 - u) * (1.0 - u) / kDuration;
    EXPECT_NEAR(s.progress, lambda, 1e-14);
    const double energy = 0.5 * s.dq.dot(mass_matrix(motion.arm(), s.q) * s.dq);
    EXPECT_NEAR(energy, s.energy * rate * rate, 1e-6 * s.energy * rate * rate);  // the path's tail of 1e-6
  }
}

TEST(Motion, HandFollowsTheMinimumJerkOfItsArcLength) {
  MotionSettings settings;
  settings.timing = TimingLaw::MinimumJerkHand;
  MotionGenerator motion(settings);
  ASSERT_EQ(motion.command(0.0, go_to(kTarget)), Status::Ok);
  // Length of the hand's path by the chords of a fine sampling: relative error of the chords h^2 kappa^2/24, below 1e-7 here.
  constexpr int kSamples = 6000;
  std::vector<double> length(kSamples + 1, 0.0);
  Vec3 before = sample_at(motion, 0.0).wrist;
  for (int i = 1; i <= kSamples; ++i) {
    const Vec3 now = sample_at(motion, kDuration * i / kSamples).wrist;
    length[static_cast<std::size_t>(i)] = length[static_cast<std::size_t>(i - 1)] + (now - before).norm();
    before = now;
  }
  for (const double u : {0.1, 0.25, 0.5, 0.7, 0.9}) {
    const double law = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
    EXPECT_NEAR(length[static_cast<std::size_t>(std::lround(u * kSamples))] / length.back(), law, 1e-5) << u;
  }
}

class ReplanTime : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Times, ReplanTime, testing::Values(0.0, 0.001, 0.3, 0.75, 1.2, 1.499));

TEST_P(ReplanTime, IsContinuousInPositionRateAndAcceleration) {
  MotionGenerator motion{MotionSettings{}};
  ASSERT_EQ(motion.command(0.0, go_to(kTarget)), Status::Ok);
  const MotionSample before = sample_at(motion, GetParam());
  const Vec3 target(0.35, 0.25, 0.05);
  ASSERT_EQ(motion.command(GetParam(), go_to(target)), Status::Ok);
  const MotionSample after = sample_at(motion, GetParam());
  EXPECT_TRUE(near(before.q, after.q, 1e-9));
  EXPECT_TRUE(near(before.dq, after.dq, 1e-8));
  EXPECT_TRUE(near(before.ddq, after.ddq, 1e-6));
  EXPECT_TRUE(near(before.exo_q, after.exo_q, 1e-9));
  EXPECT_TRUE(near(before.exo_dq, after.exo_dq, 1e-7));
  EXPECT_TRUE(near(before.exo_ddq, after.exo_ddq, 1e-5));
  EXPECT_EQ(after.status, MotionStatus::Moving);
  const MotionSample end = sample_at(motion, GetParam() + kDuration);
  EXPECT_TRUE(near(end.wrist, target, 1e-9));
  EXPECT_LT(rest_error(end), 1e-9);
  EXPECT_EQ(end.status, MotionStatus::Arrived);
  constexpr double h = 1e-5;  // the jerk jumps where the earlier motion has faded out, at 1.5 s: not sampled there
  for (double t = GetParam() + 0.0537; t < GetParam() + kDuration - 0.05; t += 0.1) {
    const MotionSample low = sample_at(motion, t - h), s = sample_at(motion, t), high = sample_at(motion, t + h);
    EXPECT_TRUE(near((high.q - low.q) / (2.0 * h), s.dq, 1e-6)) << t;
    EXPECT_TRUE(near((high.dq - low.dq) / (2.0 * h), s.ddq, 1e-5)) << t;
  }
}

TEST(Motion, ReplannedAtEveryStepStaysSmoothAndConverges) {
  MotionGenerator motion{MotionSettings{}};
  constexpr double h = 0.005;
  constexpr int kSteps = 600;
  MotionSample before = sample_at(motion, 0.0);
  for (int i = 0; i < kSteps; ++i) {
    const double t = i * h;
    const double a = 4.0 * t;
    const Vec3 target = kTarget + Vec3(0.05 * std::cos(a), 0.05 * std::sin(a), 0.03 * std::sin(2.0 * a));
    ASSERT_EQ(motion.command(t, go_to(target)), Status::Ok);
    const MotionSample s = sample_at(motion, t);
    ASSERT_TRUE(all_finite(s)) << t;
    ASSERT_NE(s.status, MotionStatus::SolverFailed) << t;
    if (i > 0) {
      // Taylor with continuous acceleration: the remainder is h^3/6 times the jerk, here below 1e3 rad/s^3 per joint angle.
      ASSERT_TRUE(near(s.q, Vec4(before.q + h * before.dq + 0.5 * h * h * before.ddq), 1e-4)) << t;
      ASSERT_TRUE(near(s.dq, Vec4(before.dq + h * before.ddq), 2e-2)) << t;
    }
    ASSERT_LT(s.ddq.cwiseAbs().maxCoeff(), 60.0) << t;
    before = s;
  }
  ASSERT_EQ(motion.command(kSteps * h, go_to(kTarget)), Status::Ok);
  const MotionSample end = sample_at(motion, kSteps * h + kDuration);
  EXPECT_TRUE(near(end.wrist, kTarget, 1e-9));
  EXPECT_LT(rest_error(end), 1e-9);
  EXPECT_EQ(end.status, MotionStatus::Arrived);
}

double distance_to_path(const GeodesicPath& path, const Posture& posture) {
  double best = 1e300, where = 0.0;
  for (int i = 0; i <= 400; ++i) {
    const double d = posture_distance(path_posture(path, i / 400.0), posture);
    if (d < best) best = d, where = i / 400.0;
  }
  for (double width = 1.0 / 400.0; width > 1e-11; width *= 0.5) {
    for (const double lambda : {where - width, where + width}) {
      const double d = posture_distance(path_posture(path, lambda), posture);
      if (d < best) best = d, where = lambda;
    }
  }
  return best;
}

class StopTime : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Times, StopTime, testing::Values(0.1, 0.5, 0.75, 1.2, 1.45));

TEST_P(StopTime, ComesToRestAlongThePath) {
  MotionGenerator motion{MotionSettings{}};
  ASSERT_EQ(motion.command(0.0, go_to(kTarget)), Status::Ok);
  const GeodesicPath path = motion.path();
  const MotionSample before = sample_at(motion, GetParam());
  ASSERT_EQ(motion.command(GetParam(), halt(kTarget)), Status::Ok);
  const MotionSample after = sample_at(motion, GetParam());
  EXPECT_TRUE(near(before.q, after.q, 1e-12));
  EXPECT_TRUE(near(before.dq, after.dq, 1e-10));
  EXPECT_TRUE(near(before.ddq, after.ddq, 1e-8));
  double progress = after.progress;
  for (double t = GetParam(); t < GetParam() + kDuration; t += 0.02) {
    const MotionSample s = sample_at(motion, t);
    EXPECT_LT(distance_to_path(path, s.posture), 1e-7) << t;
    EXPECT_GE(s.progress, progress) << "goes back at " << t;
    progress = s.progress;
  }
  const MotionSample rest = sample_at(motion, GetParam() + kDuration);
  EXPECT_EQ(rest.status, MotionStatus::Stopped);
  EXPECT_EQ(rest_error(rest), 0.0);
  EXPECT_EQ(numbers(sample_at(motion, GetParam() + 100.0)), numbers(rest));
  if (GetParam() < 0.7) {
    EXPECT_LT(rest.progress, 1.0);
  }
}

TEST(Motion, StoppedWhileAnEarlierMotionFadesStaysSmoothAndRests) {
  MotionGenerator motion{MotionSettings{}};
  ASSERT_EQ(motion.command(0.0, go_to(kTarget)), Status::Ok);
  ASSERT_EQ(motion.command(0.6, go_to(Vec3(0.35, 0.25, 0.05))), Status::Ok);
  ASSERT_EQ(motion.command(0.8, halt(Vec3(0.35, 0.25, 0.05))), Status::Ok);
  constexpr double h = 1e-5;
  for (double t = 0.82; t < 2.5; t += 0.05) {
    const MotionSample low = sample_at(motion, t - h), s = sample_at(motion, t), high = sample_at(motion, t + h);
    EXPECT_TRUE(near((high.q - low.q) / (2.0 * h), s.dq, 1e-5)) << t;
    EXPECT_TRUE(near((high.dq - low.dq) / (2.0 * h), s.ddq, 1e-3)) << t;
  }
  const MotionSample rest = sample_at(motion, 3.0);
  EXPECT_EQ(rest.status, MotionStatus::Stopped);
  EXPECT_LT(rest_error(rest), 1e-12);
}

TEST(Motion, MovesAgainAfterAStopToANewTarget) {
  MotionGenerator motion{MotionSettings{}};
  ASSERT_EQ(motion.command(0.0, go_to(kTarget)), Status::Ok);
  ASSERT_EQ(motion.command(0.7, halt(kTarget)), Status::Ok);
  const MotionSample rest = sample_at(motion, 5.0);
  const Vec3 target(0.3, 0.3, 0.0);
  ASSERT_EQ(motion.command(5.0, go_to(target)), Status::Ok);
  EXPECT_TRUE(near(sample_at(motion, 5.0).q, rest.q, 1e-9));
  const MotionSample end = sample_at(motion, 5.0 + kDuration);
  EXPECT_EQ(end.status, MotionStatus::Arrived);
  EXPECT_TRUE(near(end.wrist, target, 1e-9));
}

TEST(Motion, ReleasedInTheMiddleOfAStopStaysContinuous) {
  MotionGenerator motion{MotionSettings{}};
  ASSERT_EQ(motion.command(0.0, go_to(kTarget)), Status::Ok);
  ASSERT_EQ(motion.command(0.7, halt(kTarget)), Status::Ok);
  const MotionSample before = sample_at(motion, 0.8);
  const Vec3 target(0.3, 0.3, 0.0);
  ASSERT_EQ(motion.command(0.8, go_to(target)), Status::Ok);
  const MotionSample after = sample_at(motion, 0.8);
  EXPECT_TRUE(near(before.q, after.q, 1e-9));
  EXPECT_TRUE(near(before.dq, after.dq, 1e-8));
  EXPECT_TRUE(near(before.ddq, after.ddq, 1e-6));
  EXPECT_TRUE(near(sample_at(motion, 0.8 + 2.0 * kDuration).wrist, target, 1e-9));
}

struct Refusal {
  const char* name;
  Vec3 target;
  MotionStatus status;
};

MotionSettings narrow_settings() {
  MotionSettings settings;
  settings.limits.upper[kLimitTheta] = 60.0 * kDegree;
  return settings;
}

class Refusals : public testing::TestWithParam<Refusal> {};
INSTANTIATE_TEST_SUITE_P(Reasons, Refusals,
                         testing::Values(Refusal{"unreachable", Vec3(0.2, 1.5, 0.2), MotionStatus::TargetUnreachable},
                                         Refusal{"limits", Vec3(0.25, 0.30, 0.40), MotionStatus::LimitsInfeasible}),
                         [](const auto& c) { return std::string(c.param.name); });

TEST_P(Refusals, LeaveARestingArmWhereItIsAndSayWhy) {
  MotionGenerator motion(narrow_settings());
  ASSERT_EQ(motion.command(0.0, go_to(GetParam().target)), Status::Ok);
  EXPECT_FALSE(std::string(motion.message()).empty());
  for (const double t : {0.0, 0.5, 10.0}) {
    const MotionSample s = sample_at(motion, t);
    EXPECT_EQ(s.status, GetParam().status);
    EXPECT_TRUE(near(s.q, motion.settings().start_q, 1e-12));
    EXPECT_EQ(rest_error(s), 0.0);
    EXPECT_TRUE(all_finite(s));
  }
}

TEST_P(Refusals, BringAMovingArmToRestOnItsPath) {
  MotionGenerator motion(narrow_settings());
  const Vec3 first(0.25, 0.35, -0.15);
  ASSERT_EQ(motion.command(0.0, go_to(first)), Status::Ok);
  ASSERT_EQ(sample_at(motion, 0.5).status, MotionStatus::Moving) << motion.message();
  const GeodesicPath path = motion.path();
  const MotionSample before = sample_at(motion, 0.5);
  ASSERT_EQ(motion.command(0.5, go_to(GetParam().target)), Status::Ok);
  const MotionSample after = sample_at(motion, 0.5);
  EXPECT_TRUE(near(before.q, after.q, 1e-12));
  EXPECT_TRUE(near(before.dq, after.dq, 1e-10));
  EXPECT_TRUE(near(before.ddq, after.ddq, 1e-8));
  const MotionSample rest = sample_at(motion, 3.0);
  EXPECT_EQ(rest.status, GetParam().status);
  EXPECT_EQ(rest_error(rest), 0.0);
  EXPECT_LT(distance_to_path(path, rest.posture), 1e-7);
  // and afterwards it can move again
  ASSERT_EQ(motion.command(4.0, go_to(first)), Status::Ok);
  EXPECT_TRUE(near(sample_at(motion, 4.0 + kDuration).wrist, first, 1e-9));
}

TEST(Motion, RefusesAPathThatTheDeviceCannotFollow) {
  MotionSettings settings;
  settings.exo.upper[kElbow] = 61.0 * kDegree;  // start at 60
  settings.exo.lower[kElbow] = 59.0 * kDegree;
  MotionGenerator motion(settings);
  ASSERT_EQ(motion.command(0.0, go_to(kTarget)), Status::Ok);
  const MotionSample s = sample_at(motion, 1.0);
  EXPECT_EQ(s.status, MotionStatus::ExoInfeasible);
  EXPECT_TRUE(near(s.q, settings.start_q, 1e-12));
  EXPECT_FALSE(std::string(motion.message()).empty());
}

TEST(Motion, RestoredStateContinuesBitForBit) {
  MotionGenerator motion{MotionSettings{}}, other{MotionSettings{}};
  ASSERT_EQ(other.command(0.0, go_to(Vec3(0.1, 0.3, -0.2))), Status::Ok);  // anything else before
  ASSERT_EQ(motion.command(0.0, go_to(kTarget)), Status::Ok);
  ASSERT_EQ(motion.command(0.4, go_to(Vec3(0.35, 0.25, 0.05))), Status::Ok);
  const MotionState saved = motion.state();
  const auto run = [](MotionGenerator& m) {
    std::vector<double> out;
    for (int i = 40; i < 300; ++i) {
      const double t = 0.01 * i;
      const MotionCommand command = i < 90 ? go_to(Vec3(0.35, 0.25, 0.05)) : i < 150 ? go_to(kTarget) : halt(kTarget);
      EXPECT_EQ(m.command(t, command), Status::Ok);
      const std::vector<double> now = numbers(sample_at(m, t));
      out.insert(out.end(), now.begin(), now.end());
    }
    return out;
  };
  const std::vector<double> straight = run(motion);
  ASSERT_EQ(other.restore(saved), Status::Ok);
  EXPECT_EQ(run(other), straight);
  ASSERT_EQ(motion.restore(saved), Status::Ok);
  EXPECT_EQ(run(motion), straight);
}

TEST(Motion, RefusesAStateThatIsNone) {
  MotionGenerator motion{MotionSettings{}};
  ASSERT_EQ(motion.command(0.0, go_to(kTarget)), Status::Ok);
  const std::vector<double> before = numbers(sample_at(motion, 0.5));
  const auto broken = [&](auto change) {
    MotionState state = motion.state();
    change(state);
    EXPECT_EQ(motion.restore(state), Status::OutOfRange);
    EXPECT_EQ(numbers(sample_at(motion, 0.5)), before);
  };
  broken([](MotionState& s) { s.path.order = kMaxPathOrder + 1; });
  broken([](MotionState& s) { s.path.order = -1; });
  broken([](MotionState& s) { s.path.nodes[1].R_TU(0, 0) = std::nan(""); });
  broken([](MotionState& s) { s.path.legendre[2][3] = HUGE_VAL; });
  broken([](MotionState& s) { s.target.x() = std::nan(""); });
  broken([](MotionState& s) { s.duration_s = -1.0; });
  broken([](MotionState& s) { s.next_duration_s = std::nan(""); });
  broken([](MotionState& s) { s.fade_w.z() = std::nan(""); });
  broken([](MotionState& s) { s.rest_status = 77; });
  broken([](MotionState& s) { s.move_time_s = HUGE_VAL; });
  broken([](MotionState& s) { s.guide_q[3][1] = std::nan(""); });
}

TEST(Motion, OfALeftArmIsMirrored) {
  MotionSettings left;
  left.subject.left_arm = true;
  MotionGenerator of_right{MotionSettings{}}, of_left(left);
  const Vec3 flip(-1.0, 1.0, 1.0);
  ASSERT_EQ(of_right.command(0.0, go_to(kTarget)), Status::Ok);
  ASSERT_EQ(of_left.command(0.0, go_to(kTarget.cwiseProduct(flip))), Status::Ok);
  for (double t = 0.0; t < 1.6; t += 0.25) {
    const MotionSample r = sample_at(of_right, t), l = sample_at(of_left, t);
    EXPECT_EQ(l.q, r.q) << t;
    EXPECT_EQ(l.dq, r.dq) << t;
    EXPECT_EQ(l.wrist, r.wrist.cwiseProduct(flip)) << t;
    EXPECT_EQ(l.elbow, r.elbow.cwiseProduct(flip)) << t;
    EXPECT_EQ(l.shoulder, r.shoulder.cwiseProduct(flip)) << t;
    EXPECT_EQ(l.girdle, r.girdle) << t;
    EXPECT_EQ(l.swivel, r.swivel) << t;
    EXPECT_EQ(l.status, r.status) << t;
  }
}

TEST(Motion, RefusesWhatIsNotFiniteAndChangesNothing) {
  MotionGenerator motion{MotionSettings{}};
  ASSERT_EQ(motion.command(0.0, go_to(kTarget)), Status::Ok);
  const std::vector<double> before = numbers(sample_at(motion, 0.5));
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    EXPECT_EQ(motion.command(0.5, go_to(Vec3(0.2, bad, 0.2))), Status::NotFinite);
    EXPECT_EQ(motion.command(bad, go_to(Vec3(0.3, 0.3, 0.1))), Status::NotFinite);
    EXPECT_EQ(motion.set_duration(bad), Status::NotFinite);
    MotionSample out = sample_at(motion, 0.5);
    EXPECT_EQ(motion.sample(bad, out), Status::NotFinite);
    EXPECT_EQ(numbers(out), before);
    EXPECT_EQ(numbers(sample_at(motion, 0.5)), before);
  }
}

TEST(Motion, IgnoresATargetThatMovesLessThanAMillimetre) {
  MotionGenerator motion{MotionSettings{}};
  ASSERT_EQ(motion.command(0.0, go_to(kTarget)), Status::Ok);
  const std::vector<double> before = numbers(sample_at(motion, 2.0));
  ASSERT_EQ(motion.command(0.5, go_to(kTarget + Vec3(0.0, 0.0009, 0.0))), Status::Ok);
  EXPECT_EQ(numbers(sample_at(motion, 2.0)), before);
  ASSERT_EQ(motion.command(0.5, go_to(kTarget + Vec3(0.0, 0.0011, 0.0))), Status::Ok);
  EXPECT_NE(numbers(sample_at(motion, 2.0)), before);
}

TEST(Motion, DoesNotCreepPastAMillimetreUnnoticed) {
  MotionGenerator motion{MotionSettings{}};
  for (int i = 0; i < 100; ++i) {  // compared with the last accepted target, not with the last seen one
    ASSERT_EQ(motion.command(0.01 * i, go_to(kTarget + Vec3(0.0, 0.0, -0.0003 * i))), Status::Ok);
  }
  const double error = (sample_at(motion, 10.0).wrist - (kTarget - Vec3(0.0, 0.0, 0.0003 * 99))).norm();
  EXPECT_LE(error, 1.0e-3 + 1e-9);
}

TEST(Motion, WithoutEnableNothingStarts) {
  MotionGenerator motion{MotionSettings{}};
  MotionCommand command = go_to(kTarget);
  command.enable = false;
  ASSERT_EQ(motion.command(0.0, command), Status::Ok);
  EXPECT_EQ(sample_at(motion, 1.0).status, MotionStatus::Idle);
  EXPECT_EQ(rest_error(sample_at(motion, 1.0)), 0.0);
  command.enable = true;
  ASSERT_EQ(motion.command(1.0, command), Status::Ok);
  EXPECT_EQ(sample_at(motion, 1.5).status, MotionStatus::Moving);
  EXPECT_TRUE(near(sample_at(motion, 1.0 + kDuration).wrist, kTarget, 1e-9));
}

TEST(Motion, DurationHoldsForTheMovementsAcceptedAfterwards) {
  MotionGenerator motion{MotionSettings{}};
  ASSERT_EQ(motion.command(0.0, go_to(kTarget)), Status::Ok);
  ASSERT_EQ(motion.set_duration(0.7), Status::Ok);
  EXPECT_EQ(sample_at(motion, 1.4).status, MotionStatus::Moving);
  ASSERT_EQ(motion.command(2.0, go_to(Vec3(0.3, 0.3, 0.0))), Status::Ok);
  EXPECT_EQ(sample_at(motion, 2.69).status, MotionStatus::Moving);
  EXPECT_EQ(sample_at(motion, 2.7).status, MotionStatus::Arrived);
  EXPECT_EQ(motion.set_duration(0.049), Status::OutOfRange);
  EXPECT_EQ(motion.set_duration(60.1), Status::OutOfRange);
  EXPECT_EQ(motion.set_duration(-1.0), Status::OutOfRange);
}

TEST(Motion, AllocatesNothingWhileItRuns) {
  MotionGenerator motion{MotionSettings{}};
  MotionSample out;
  long failures = 0;
  const AllocationGuard guard;
  for (int i = 0; i < 300; ++i) {
    const double t = 0.01 * i;
    const Vec3 target = i % 40 == 39 ? Vec3(0.2, 2.0, 0.2) : kTarget + Vec3(0.0, 0.0, -0.002 * i);
    MotionCommand command = go_to(target);
    command.stop = i % 50 > 45;
    if (motion.command(t, command) != Status::Ok) ++failures;
    if (motion.sample(t, out) != Status::Ok) ++failures;
    if (motion.message() == nullptr) ++failures;
  }
  if (motion.set_duration(1.0) != Status::Ok) ++failures;
  const MotionState state = motion.state();
  if (motion.restore(state) != Status::Ok) ++failures;
  const long allocations = guard.allocations();
  EXPECT_EQ(allocations, 0);
  EXPECT_EQ(failures, 0);
}

TEST(Motion, DoesNotDependOnHowOftenItIsSampled) {
  MotionGenerator rarely{MotionSettings{}}, often{MotionSettings{}};
  for (int i = 0; i < 200; ++i) {
    const double t = 0.01 * i;
    const MotionCommand command = i < 60 ? go_to(kTarget) : go_to(Vec3(0.35, 0.25, 0.05));
    ASSERT_EQ(often.command(t, command), Status::Ok);
    (void)sample_at(often, t);
    if (i == 0 || i == 60) {
      ASSERT_EQ(rarely.command(t, command), Status::Ok);
    }
  }
  EXPECT_EQ(numbers(sample_at(rarely, 1.99)), numbers(sample_at(often, 1.99)));
}

TEST(Motion, FromTheHangingArmDoesNotDependOnItsUndefinedPlane) {
  MotionSettings first, other;
  first.start_q = Vec4(0.0, 0.0, 10.0, 40.0) * kDegree;
  MotionGenerator motion(first);
  ASSERT_EQ(motion.command(0.0, go_to(kTarget)), Status::Ok);
  for (const double eta : {-100.0, 30.0, 150.0}) {
    other.start_q = Vec4(0.0, eta, 10.0 - eta, 40.0) * kDegree;
    MotionGenerator turned(other);
    ASSERT_EQ(turned.command(0.0, go_to(kTarget)), Status::Ok);
    for (double t = 0.0; t <= 1.5; t += 0.3) {
      const MotionSample a = sample_at(motion, t), b = sample_at(turned, t);
      EXPECT_LT(posture_distance(a.posture, b.posture), 1e-7) << eta << " at " << t;
      EXPECT_TRUE(all_finite(b));
    }
  }
}

// eta and zeta turn fast near the hanging arm, but must not jump by a turn anywhere.
class AnglesAlongRandomMotions : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Tasks, AnglesAlongRandomMotions, testing::Range(0, std::min(test_count(40), 400)));

TEST_P(AnglesAlongRandomMotions, NeverJumpByATurn) {
  TaskRandom random(test_seed() + 11, static_cast<std::uint64_t>(GetParam()));
  MotionSettings settings;
  const double theta = random.uniform(0.0, 3.0) * kDegree;
  settings.start_q = Vec4(theta, random.uniform(-2.3, 0.7), 0.0, random.uniform(0.1, 1.5));
  settings.start_q[kZeta] = random.uniform(-1.0, 1.0) - settings.start_q[kEta];
  MotionGenerator motion(settings);
  const Posture end = random_posture(settings.limits, random, 2.0 * kDegree);
  ASSERT_EQ(motion.command(0.0, go_to(forward_kinematics(motion.arm(), end).wrist)), Status::Ok);
  Vec4 before = sample_at(motion, 0.0).q;
  for (int i = 1; i <= 6000; ++i) {
    const MotionSample s = sample_at(motion, kDuration * i / 6000.0);
    ASSERT_TRUE(all_finite(s));
    ASSERT_LT((s.q - before).cwiseAbs().maxCoeff(), kPi) << "at " << kDuration * i / 6000.0;
    ASSERT_LT(posture_distance(posture_from_angles(s.q), s.posture), 1e-7);
    before = s.q;
  }
}

TEST(Motion, PrescribedSwivelIsReached) {
  MotionSettings settings;
  settings.swivel_mode = SwivelMode::Prescribed;
  settings.swivel_prescribed_rad = 0.45;
  MotionGenerator motion(settings);
  ASSERT_EQ(motion.command(0.0, go_to(kTarget)), Status::Ok);
  const MotionSample end = sample_at(motion, kDuration);
  EXPECT_EQ(end.status, MotionStatus::Arrived) << motion.message();
  EXPECT_NEAR(end.swivel, 0.45, 1e-7);
  EXPECT_TRUE(near(end.wrist, kTarget, 1e-9));
}

TEST(Motion, IsAnchoredAtAMeasuredShoulder) {
  MotionSettings settings;
  settings.shoulder_start_m = Vec3(0.15, -0.05, -0.01);
  const MotionGenerator motion(settings);
  EXPECT_TRUE(near(sample_at(motion, 0.0).shoulder, *settings.shoulder_start_m, 1e-12));
}

struct BadSettings {
  const char* name;
  void (*change)(MotionSettings&);
  const char* named;  ///< what the message must contain
};

class BadInput : public testing::TestWithParam<BadSettings> {};
INSTANTIATE_TEST_SUITE_P(
    Fields, BadInput,
    testing::Values(BadSettings{"duration", [](MotionSettings& s) { s.duration_s = 0.0; }, "duration"},
                    BadSettings{"duration_nan", [](MotionSettings& s) { s.duration_s = std::nan(""); }, "duration"},
                    BadSettings{"start_nan", [](MotionSettings& s) { s.start_q[2] = std::nan(""); }, "start"},
                    BadSettings{"start_outside", [](MotionSettings& s) { s.start_q[kPhi] = 3.0; }, "start"},
                    BadSettings{"prescribed", [](MotionSettings& s) { s.swivel_prescribed_rad = HUGE_VAL; }, "swivel"},
                    BadSettings{"gain", [](MotionSettings& s) { s.rhythm.gain = 2.0; }, "gain"},
                    BadSettings{"limits", [](MotionSettings& s) { s.limits.lower[1] = 2.0; }, "limits"},
                    BadSettings{"length", [](MotionSettings& s) { s.subject.forearm_length_m = -0.2; }, "forearm"},
                    BadSettings{"shoulder", [](MotionSettings& s) { s.shoulder_start_m = Vec3(0.1, std::nan(""), 0.0); },
                                "shoulder"},
                    BadSettings{"mode", [](MotionSettings& s) { s.swivel_mode = static_cast<SwivelMode>(9); }, "swivel"},
                    BadSettings{"timing", [](MotionSettings& s) { s.timing = static_cast<TimingLaw>(9); }, "timing"}),
    [](const auto& c) { return std::string(c.param.name); });

TEST_P(BadInput, IsNamedWithItsValueAndRule) {
  MotionSettings settings;
  GetParam().change(settings);
  const std::string text = refusal([&] { MotionGenerator motion(settings); });
  EXPECT_TRUE(contains(text, GetParam().named)) << "message: '" << text << "'";
}

TEST(Motion, GivesTheSameInSeveralThreadsWithSeparateInstances) {
  const auto run = [](std::vector<double>& out) {
    MotionGenerator motion{MotionSettings{}};
    for (int i = 0; i < 40; ++i) {
      const double t = 0.05 * i;
      EXPECT_EQ(motion.command(t, go_to(kTarget + Vec3(0.0, 0.0, -0.004 * i))), Status::Ok);
      const std::vector<double> now = numbers(sample_at(motion, t));
      out.insert(out.end(), now.begin(), now.end());
    }
  };
  std::vector<double> first, second;
  std::thread one([&] { run(first); }), two([&] { run(second); });
  one.join();
  two.join();
  EXPECT_EQ(first, second);
}

}  // namespace
}  // namespace glenoid::test
