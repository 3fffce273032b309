// The choice of the final posture; docs/equations.md, S1-S4. The reference is a sweep over the swivel angle that knows nothing of
// arcs, candidates or slopes.
#include "glenoid/swivel.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <thread>
#include <vector>

#include "path_probe.hpp"
#include "reference.hpp"
#include "support/allocation_guard.hpp"

namespace glenoid::test {
namespace {

/// Direction of the self-motion in body coordinates: the null vector of the wrist's Jacobian, which is taken by differences.
Vec4 self_motion(const ArmModel& arm, const Posture& posture) {
  constexpr double h = 1e-5;
  Eigen::Matrix<double, 3, 4> J;
  for (int k = 0; k < 4; ++k) {
    J.col(k) = (forward_kinematics(arm, displaced(posture, h * Vec4::Unit(k))).wrist -
                forward_kinematics(arm, displaced(posture, -h * Vec4::Unit(k))).wrist) /
               (2.0 * h);
  }
  Vec4 null;
  for (int k = 0; k < 4; ++k) {
    Mat3 minor;
    for (int c = 0, to = 0; c < 4; ++c) {
      if (c != k) minor.col(to++) = J.col(c);
    }
    null[k] = (k % 2 ? -1.0 : 1.0) * minor.determinant();
  }
  return null.normalized();
}

/// |cos| between momentum and self-motion in the metric at the end of a path.
double transversality(const ArmModel& arm, const GeodesicPath& path) {
  const Vec4 tau = self_motion(arm, path_end(path));
  const Vec4 p = momentum_at(arm, path, 1.0);
  const Mat4 M = body_mass_matrix(arm, path_end(path));
  return std::abs(p.dot(tau)) / std::sqrt(tau.dot(M * tau) * 2.0 * path.energy);
}

/// Task whose target is the wrist of a posture inside the limits.
ReachTask feasible_task(std::uint64_t index) {
  ReachTask task = random_task(test_seed(), index);
  task.target = forward_kinematics(task.arm, task.known_end).wrist;
  task.kind = TargetKind::Posture;
  return task;
}

class RandomReach : public testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    task_ = feasible_task(static_cast<std::uint64_t>(GetParam()));
    ASSERT_EQ(planner_.plan_minimum_energy(task_.arm, task_.start, task_.target, plan_), Status::Ok);
  }

  testing::ScopedTrace trace_{__FILE__, __LINE__, replay(static_cast<std::uint64_t>(GetParam()))};
  ReachTask task_;
  ReachPlanner planner_;
  ReachPlan plan_;
};

INSTANTIATE_TEST_SUITE_P(Tasks, RandomReach, testing::Range(0, std::min(test_count(30), 200)));

TEST_P(RandomReach, BeginsAtTheStartAndEndsAtTheTargetInsideTheLimits) {
  EXPECT_LT(posture_distance(plan_.path.nodes[0], task_.start), 1e-13);
  const ArmPoints points = forward_kinematics(task_.arm, path_end(plan_.path));
  EXPECT_LT((points.wrist - task_.target).norm(), 1e-10);
  EXPECT_NEAR(plan_.certificate.hand_error_m, (points.wrist - task_.target).norm(), 1e-12);
  EXPECT_GT(limit_margin(task_.arm.limits, path_end(plan_.path)).margin_rad, -1e-9);
  EXPECT_NEAR(std::remainder(plan_.swivel_rad - swivel_angle(points), 2.0 * kPi), 0.0, 1e-9);
}

TEST_P(RandomReach, IsCheaperThanEveryFeasiblePostureOfAFineSweep) {
  GeodesicSolver solver;
  const Reference reference = sweep_swivel(task_.arm, task_.start, task_.target, 1440, solver);
  if (reference.feasible) {
    EXPECT_LT(plan_.path.energy, reference.energy * (1.0 + 1e-7) + 1e-12)
        << "swivel " << plan_.swivel_rad / kDegree << " deg, reference " << reference.swivel_rad / kDegree << " deg";
  }
  EXPECT_LT(plan_.path.energy, converged_energy(task_.arm, task_.start, task_.known_end, solver) * (1.0 + 1e-7) + 1e-12);
}

TEST_P(RandomReach, IsTransversalInsideTheLimitsAndPushedAgainstThemOtherwise) {
  const Vec4 tau = self_motion(task_.arm, path_end(plan_.path));
  const auto margin_beside = [&](double step) {
    return limit_margin(task_.arm.limits, displaced(path_end(plan_.path), step * tau)).margin_rad;
  };
  // The margin may jump at an edge: the limit on eta begins to apply at theta = 5 deg.
  EXPECT_EQ(plan_.certificate.swivel_at_limit, margin_beside(1e-5) < 0.0 || margin_beside(-1e-5) < 0.0);
  if (!plan_.certificate.swivel_at_limit) {
    // The finite-difference null vector is good to h^2 = 1e-10; the path's final rates to its tail times N^2.
    const double rates = plan_.path.order * plan_.path.order * plan_.certificate.spectral_tail;
    EXPECT_LT(transversality(task_.arm, plan_.path), std::max(1e-8, 10.0 * rates));
    EXPECT_LT(plan_.certificate.transversality, 1e-8);
    return;
  }
  // At a limit the energy must rise along the self-motion into the feasible side.
  constexpr double step = 1e-4;
  GeodesicSolver solver;
  for (const double side : {-step, step}) {
    GeodesicPath path;
    Certificate certificate;
    const Posture beside = displaced(path_end(plan_.path), side * tau);
    if (limit_margin(task_.arm.limits, beside).margin_rad < 0.0) continue;
    ASSERT_EQ(solve_tightly(solver, task_.arm, task_.start, beside, path, certificate), Status::Ok);
    EXPECT_GT(path.energy, plan_.path.energy * (1.0 - 1e-7));
  }
}

TEST_P(RandomReach, HasTheEnergyOfTheGeodesicToItsOwnEnd) {
  GeodesicSolver solver;
  GeodesicPath path;
  Certificate certificate;
  ASSERT_EQ(solve_tightly(solver, task_.arm, task_.start, path_end(plan_.path), path, certificate), Status::Ok);
  if (certificate.long_way != plan_.certificate.long_way) GTEST_SKIP() << "two classes";
  EXPECT_NEAR(plan_.path.energy, path.energy, 1e-8 * path.energy + 1e-15);
}

TEST_P(RandomReach, IsTheSameBitForBitWhateverWasPlannedBefore) {
  ReachPlanner fresh;
  ReachPlan again;
  const ReachTask other = feasible_task(static_cast<std::uint64_t>(GetParam()) + 5000);
  (void)fresh.plan_minimum_energy(other.arm, other.start, other.target, again);
  ASSERT_EQ(fresh.plan_minimum_energy(task_.arm, task_.start, task_.target, again), Status::Ok);
  ASSERT_EQ(again.path.order, plan_.path.order);
  EXPECT_EQ(std::memcmp(again.path.nodes.data(), plan_.path.nodes.data(),
                        sizeof(Posture) * static_cast<std::size_t>(plan_.path.order + 1)),
            0);
  EXPECT_EQ(again.swivel_rad, plan_.swivel_rad);
  EXPECT_EQ(again.path.energy, plan_.path.energy);
}

TEST_P(RandomReach, AllocatesNothing) {
  ReachPlan again;
  const AllocationGuard guard;
  const Status status = planner_.plan_minimum_energy(task_.arm, task_.start, task_.target, again);
  const long allocations = guard.allocations();
  EXPECT_EQ(allocations, 0);
  EXPECT_EQ(status, Status::Ok);
}

TEST_P(RandomReach, PrescribedSwivelIsMetWithTheCheapestPosture) {
  if (plan_.certificate.swivel_at_limit) GTEST_SKIP() << "feasible only within rounding";
  const double swivel = plan_.swivel_rad;  // known to be feasible
  ReachPlan prescribed;
  ASSERT_EQ(planner_.plan_prescribed(task_.arm, task_.start, task_.target, swivel, prescribed), Status::Ok);
  const ArmPoints points = forward_kinematics(task_.arm, path_end(prescribed.path));
  EXPECT_LT((points.wrist - task_.target).norm(), 1e-9);
  EXPECT_NEAR(std::remainder(swivel_angle(points) - swivel, 2.0 * kPi), 0.0, 1e-8);
  EXPECT_NEAR(prescribed.path.energy, plan_.path.energy, 1e-6 * plan_.path.energy + 1e-12);
  IkSolutions solutions;
  GeodesicSolver solver;
  ASSERT_EQ(inverse_kinematics(task_.arm, task_.target, swivel, solutions), Status::Ok);
  for (int k = 0; k < solutions.count; ++k) {
    const Posture& end = solutions.postures[static_cast<std::size_t>(k)];
    if (limit_margin(task_.arm.limits, end).margin_rad < 0.0) continue;
    EXPECT_LT(prescribed.path.energy, converged_energy(task_.arm, task_.start, end, solver) * (1.0 + 1e-6) + 1e-12) << k;
  }
}

TEST_P(RandomReach, FamilyMembersReachTheTargetAndBoundTheMinimum) {
  Family family;
  ASSERT_EQ(planner_.sample_family(task_.arm, task_.start, task_.target, 90, family), Status::Ok);
  ASSERT_GT(family.count, 0);
  ASSERT_LE(family.count, 90);
  for (int k = 0; k < family.count; ++k) {
    const FamilyMember& member = family.members[static_cast<std::size_t>(k)];
    const ArmPoints points = forward_kinematics(task_.arm, member.end);
    EXPECT_LT((points.wrist - task_.target).norm(), 1e-9) << k;
    EXPECT_NEAR(std::remainder(member.swivel_rad - swivel_angle(points), 2.0 * kPi), 0.0, 1e-7) << k;
    EXPECT_NEAR(member.margin.margin_rad, limit_margin(task_.arm.limits, member.end).margin_rad, 1e-9) << k;
    if (k > 0) {
      EXPECT_GE(member.swivel_rad, family.members[static_cast<std::size_t>(k - 1)].swivel_rad);
    }
    if (member.margin.margin_rad >= 0.0 && std::isfinite(member.energy)) {
      EXPECT_GT(member.energy, plan_.path.energy * (1.0 - 1e-2) - 1e-9) << k;  // coarse energies
    }
  }
}

/// A geodesic between two random postures, described by its certificate.
class RandomBetween : public testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    task_ = feasible_task(static_cast<std::uint64_t>(GetParam()) + 300);
    ASSERT_EQ(planner_.plan_between(task_.arm, task_.start, task_.known_end, plan_), Status::Ok);
  }

  testing::ScopedTrace trace_{__FILE__, __LINE__, replay(static_cast<std::uint64_t>(GetParam()) + 300)};
  ReachTask task_;
  ReachPlanner planner_;
  ReachPlan plan_;
};

INSTANTIATE_TEST_SUITE_P(Pairs, RandomBetween, testing::Range(0, std::min(test_count(60), 400)));

TEST_P(RandomBetween, ReportsItsSpeedVariationTruthfully) {
  double least = 1e300, most = 0.0;
  for (int i = 0; i <= 500; ++i) {
    const double energy = energy_at(task_.arm, plan_.path, i / 500.0);
    least = std::min(least, energy);
    most = std::max(most, energy);
  }
  // The reported figure is taken at some points of the path, here it is at many.
  EXPECT_GE(plan_.certificate.speed_variation * 10.0 + 1e-9, (most - least) / plan_.path.energy);
}

TEST_P(RandomBetween, ReportsLimitViolationsAsDenseSamplingFindsThem) {
  double worst = 1e300, where = 0.0;
  for (int i = 0; i <= 2000; ++i) {
    const double margin = limit_margin(task_.arm.limits, path_posture(plan_.path, i / 2000.0)).margin_rad;
    if (margin < worst) worst = margin, where = i / 2000.0;
  }
  const LimitViolation& reported = plan_.certificate.limits;
  // A true margin of the path, and at most half a degree, the size that a user can see, or 3 % of it from the worst one.
  EXPECT_NEAR(reported.worst.margin_rad,
              limit_margin(task_.arm.limits, path_posture(plan_.path, reported.lambda)).margin_rad, 1e-9);
  EXPECT_LT(reported.worst.margin_rad - worst, std::max(0.5 * kDegree, -0.03 * worst))
      << "worst " << worst / kDegree << " deg at lambda " << where << ", reported "
      << reported.worst.margin_rad / kDegree << " at " << reported.lambda;
  EXPECT_EQ(reported.any, reported.worst.margin_rad < -1e-6);  // less is the rounding of an end on a limit
  if (worst < -0.5 * kDegree) {
    EXPECT_TRUE(reported.any);
  }
}

// Limits drawn tightly around one posture leave an arc of about that width: it must be found.
class NarrowArc : public testing::TestWithParam<std::tuple<int, double>> {};
INSTANTIATE_TEST_SUITE_P(Widths, NarrowArc,
                         testing::Combine(testing::Range(0, 10), testing::Values(5.0, 1.0, 0.3, 0.1)));

TEST_P(NarrowArc, IsFound) {
  const auto [index, width_deg] = GetParam();
  SCOPED_TRACE(replay(static_cast<std::uint64_t>(index)));
  TaskRandom random(test_seed() + 7, static_cast<std::uint64_t>(index));
  const ScaledArm scaled = scale_subject(Subject{});
  const Posture end = random_posture(JointLimits{}, random, 20.0 * kDegree);
  const Vec4 middle = limited_angles(end);
  JointLimits limits;
  limits.lower = (middle.array() - width_deg * kDegree).max(limits.lower.array());
  limits.upper = (middle.array() + width_deg * kDegree).min(limits.upper.array());
  const ArmModel arm = make_arm_model(scaled, Rhythm({}, scaled.shoulder_distance_m), limits, true);
  const Posture start = posture_deg(0.0, 0.0, 10.0, 30.0);
  ReachPlanner planner;
  ReachPlan plan;
  ASSERT_EQ(planner.plan_minimum_energy(arm, start, forward_kinematics(arm, end).wrist, plan), Status::Ok);
  EXPECT_GT(limit_margin(limits, path_end(plan.path)).margin_rad, -1e-9);
}

TEST(MinimumEnergy, OfATargetAtTheHandIsToStay) {
  ReachPlanner planner;
  ReachPlan plan;
  const ArmModel arm = default_arm();
  const Posture start = posture_deg(40.0, -20.0, 30.0, 70.0);
  ASSERT_EQ(planner.plan_minimum_energy(arm, start, forward_kinematics(arm, start).wrist, plan), Status::Ok);
  EXPECT_LT(plan.path.energy, 1e-18);
  EXPECT_LT(posture_distance(path_end(plan.path), start), 1e-8);
}

TEST(MinimumEnergy, FromTheHangingArmDoesNotDependOnItsUndefinedPlane) {
  ReachPlanner planner;
  ReachPlan first, other;
  const ArmModel arm = default_arm();
  const Vec3 target(0.25, 0.35, 0.15);
  ASSERT_EQ(planner.plan_minimum_energy(arm, posture_deg(0.0, 0.0, 5.0, 30.0), target, first), Status::Ok);
  for (const double eta : {-120.0, 20.0, 170.0}) {
    ASSERT_EQ(planner.plan_minimum_energy(arm, posture_deg(0.0, eta, 5.0 - eta, 30.0), target, other), Status::Ok);
    EXPECT_NEAR(other.path.energy, first.path.energy, 1e-10 * first.path.energy);
    EXPECT_LT(posture_distance(path_end(other.path), path_end(first.path)), 1e-7);
  }
}

TEST(MinimumEnergy, NamesAnUnreachableTargetWithItsDistance) {
  ReachPlanner planner;
  ReachPlan plan;
  RhythmSettings settings;
  settings.model = RhythmModel::Fixed;
  const ArmModel arm = default_arm(settings);
  const Posture start = posture_deg(10.0, 0.0, 0.0, 30.0);
  const Vec3 shoulder = forward_kinematics(arm, start).shoulder;
  const double reach = arm.upper_arm.length_m + arm.forearm.length_m;
  for (const double beyond : {1e-6, 1e-3, 0.5}) {
    const Vec3 target = shoulder + (reach + beyond) * Vec3(0.6, 0.64, 0.48);
    EXPECT_EQ(planner.plan_minimum_energy(arm, start, target, plan), Status::TargetUnreachable);
    EXPECT_NEAR(plan.reach_margin_m, -beyond, 1e-9);
  }
  // So far that its square is no number, from rest and in mid-motion.
  ReachPlan earlier;
  ASSERT_EQ(planner.plan_minimum_energy(arm, start, shoulder + 0.4 * Vec3::UnitY(), earlier), Status::Ok);
  const Vec3 far(1e300, -1e300, 0.0);
  EXPECT_EQ(planner.plan_minimum_energy(arm, start, far, plan), Status::TargetUnreachable);
  EXPECT_EQ(planner.replan_minimum_energy(arm, start, far, earlier.path, 0.0, plan), Status::TargetUnreachable);
  // Too near: closer than the difference of the segments.
  const double hole = std::abs(arm.upper_arm.length_m - arm.forearm.length_m);
  EXPECT_EQ(planner.plan_minimum_energy(arm, start, shoulder + 0.5 * hole * Vec3::UnitY(), plan),
            Status::TargetUnreachable);
  EXPECT_LT(plan.reach_margin_m, 0.0);
}

TEST(MinimumEnergy, NamesLimitsThatForbidEveryPostureWithTheBestMargin) {
  JointLimits limits;
  limits.upper[kLimitTheta] = 30.0 * kDegree;
  const ScaledArm scaled = scale_subject(Subject{});
  const ArmModel arm = make_arm_model(scaled, Rhythm({}, scaled.shoulder_distance_m), limits, true);
  const ArmModel free = default_arm();
  const Posture high = posture_deg(110.0, -20.0, 10.0, 10.0);
  ReachPlanner planner;
  ReachPlan plan;
  const Posture start = posture_deg(10.0, 0.0, 0.0, 30.0);
  const Vec3 target = forward_kinematics(free, high).wrist;
  EXPECT_EQ(planner.plan_minimum_energy(arm, start, target, plan), Status::LimitsInfeasible);
  EXPECT_LT(plan.best_margin.margin_rad, -10.0 * kDegree);
  EXPECT_EQ(plan.best_margin.angle, kLimitTheta);
  EXPECT_TRUE(plan.best_margin.at_upper);
  EXPECT_GT(plan.reach_margin_m, 0.0);
}

TEST(MinimumEnergy, RefusesWhatIsNotFinite) {
  ReachPlanner planner;
  ReachPlan plan;
  const ArmModel arm = default_arm();
  Posture start = posture_deg(10.0, 0.0, 0.0, 30.0);
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    EXPECT_EQ(planner.plan_minimum_energy(arm, start, Vec3(bad, 0.3, 0.1), plan), Status::NotFinite);
    EXPECT_EQ(planner.plan_prescribed(arm, start, Vec3(0.2, 0.3, 0.1), bad, plan), Status::NotFinite);
    Posture broken = start;
    broken.phi = bad;
    EXPECT_EQ(planner.plan_minimum_energy(arm, broken, Vec3(0.2, 0.3, 0.1), plan), Status::NotFinite);
    EXPECT_EQ(planner.plan_between(arm, start, broken, plan), Status::NotFinite);
  }
}

TEST(PlanBetween, EndsInTheGivenPosture) {
  ReachPlanner planner;
  ReachPlan plan;
  const ArmModel arm = default_arm();
  const Posture start = posture_deg(10.0, 0.0, 0.0, 30.0), end = posture_deg(80.0, -50.0, 40.0, 70.0);
  ASSERT_EQ(planner.plan_between(arm, start, end, plan), Status::Ok);
  EXPECT_LT(posture_distance(path_end(plan.path), end), 1e-13);
  EXPECT_NEAR(plan.swivel_rad, swivel_angle(forward_kinematics(arm, end)), 1e-12);
}

TEST(ReachPlanner, GivesTheSameInSeveralThreadsWithSeparateInstances) {
  constexpr int kTasks = 12;
  const auto plan_all = [](std::vector<double>& energies) {
    ReachPlanner planner;
    ReachPlan plan;
    for (int i = 0; i < kTasks; ++i) {
      const ReachTask task = feasible_task(static_cast<std::uint64_t>(i));
      const Status status = planner.plan_minimum_energy(task.arm, task.start, task.target, plan);
      energies.push_back(status == Status::Ok ? plan.path.energy : -1.0);
    }
  };
  std::vector<double> first, second;
  std::thread one([&] { plan_all(first); }), two([&] { plan_all(second); });
  one.join();
  two.join();
  EXPECT_EQ(first, second);
}

}  // namespace
}  // namespace glenoid::test
