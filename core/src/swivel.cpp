#include "glenoid/swivel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lobatto.hpp"
#include "prior_search.hpp"
#include "swivel_search.hpp"

namespace glenoid {
namespace {

constexpr double kMarginTolerance = 1e-9;  // rad; rounding of an end posture that sits on a limit

/// Part of an earlier path from lambda on, as a sketch on the grid that a solution begins with: the start of a re-planned one.
void remaining_path(const GeodesicPath& path, double lambda, int order, GeodesicPath& out) {
  const Lobatto& grid = lobatto(order);
  out.order = order;
  out.energy = path.energy * (1.0 - lambda) * (1.0 - lambda);
  for (int k = 0; k <= order; ++k) {
    const auto i = static_cast<std::size_t>(k);
    out.nodes[i] = path_posture(path, lambda + (1.0 - lambda) * grid.node[i]);
  }
}

}  // namespace

struct ReachPlanner::Workspace {
  SwivelSearch search;
  GeodesicPath remaining;
  IkSolutions solutions;
};

ReachPlanner::ReachPlanner() : workspace_(std::make_unique<Workspace>()) {}
ReachPlanner::~ReachPlanner() = default;
ReachPlanner::ReachPlanner(ReachPlanner&&) noexcept = default;
ReachPlanner& ReachPlanner::operator=(ReachPlanner&&) noexcept = default;

Status ReachPlanner::plan_minimum_energy(const ArmModel& arm, const Posture& start, const Vec3& target,
                                         ReachPlan& out) noexcept {
  const Status prepared = workspace_->search.prepare(arm, start, target, out);
  return prepared == Status::Ok ? workspace_->search.search(arm, start, target, out) : prepared;
}

Status ReachPlanner::replan_minimum_energy(const ArmModel& arm, const Posture& start, const Vec3& target,
                                           const GeodesicPath& previous, double previous_lambda,
                                           ReachPlan& out) noexcept {
  constexpr double kNear = 0.12;  // m; farther targets are planned afresh
  constexpr GeodesicOptions kQuick = [] {
    GeodesicOptions options;
    options.quick = true;  // the search is the other way
    options.first_order = 6;
    return options;
  }();
  constexpr double kRest = 0.95;  // lambda beyond which nothing is left of the earlier path
  if (!target.allFinite() || !std::isfinite(previous_lambda)) return Status::NotFinite;
  const Posture& end = previous.nodes[static_cast<std::size_t>(previous.order)];
  const bool near = previous.order > 0 && previous_lambda < kRest &&
                    (forward_kinematics(arm, end).wrist - target).norm() < kNear;
  if (near) {
    remaining_path(previous, std::max(previous_lambda, 0.0), kQuick.first_order, workspace_->remaining);
    ReachPlan& trial = workspace_->search.trial;
    const double reach_margin = reach_margin_near(arm, target, -end.R_TU.col(2));
    GeodesicSolver& solver = workspace_->search.solver;
    if (reach_margin >= 0.0 && solver.solve_free_end(arm, start, end, target, kQuick, &workspace_->remaining,
                                                     trial.path, trial.certificate) == Status::Ok) {
      const Posture& found = trial.path.nodes[static_cast<std::size_t>(trial.path.order)];
      const LimitMargin margin = limit_margin(arm.limits, found);
      if (trial.certificate.hessian_positive && margin.margin_rad >= -kMarginTolerance) {
        out.path = trial.path;
        out.certificate = trial.certificate;
        out.reach_margin_m = reach_margin;
        out.best_margin = margin;
        describe_reach(arm, target, out);
        return Status::Ok;
      }
    }
  }
  return plan_minimum_energy(arm, start, target, out);
}

Status ReachPlanner::plan_prescribed(const ArmModel& arm, const Posture& start, const Vec3& target, double swivel_rad,
                                     ReachPlan& out) noexcept {
  IkSolutions& solutions = workspace_->solutions;
  const Status status = inverse_kinematics(arm, target, swivel_rad, solutions);
  out.reach_margin_m = solutions.reach_margin_m;
  out.best_margin = LimitMargin{-1e3, 0, false};
  if (status != Status::Ok) return status;
  Status result = Status::LimitsInfeasible;
  double best = std::numeric_limits<double>::infinity();
  ReachPlan& trial = workspace_->search.trial;
  for (int i = 0; i < solutions.count; ++i) {
    const Posture& end = solutions.postures[static_cast<std::size_t>(i)];
    const LimitMargin margin = limit_margin(arm.limits, end);
    if (margin.margin_rad > out.best_margin.margin_rad) out.best_margin = margin;
    if (margin.margin_rad < -kMarginTolerance) continue;
    const Status solved = workspace_->search.solver.solve_cheapest(arm, start, end, {}, trial.path, trial.certificate);
    if (solved != Status::Ok) {
      if (result != Status::Ok) result = solved;
    } else if (trial.path.energy < best) {
      best = trial.path.energy;
      out.path = trial.path;
      out.certificate = trial.certificate;
      result = Status::Ok;
    }
  }
  if (result == Status::Ok) describe_reach(arm, target, out);
  return result;
}

Status ReachPlanner::plan_human_prior(const ArmModel& arm, const Posture& start, const Vec3& target,
                                      const PosturePrior& prior, ReachPlan& out) noexcept {
  SwivelSearch& search = workspace_->search;
  const Status prepared = search.prepare(arm, start, target, out);
  if (prepared != Status::Ok) return prepared;
  Posture end;
  if (!most_likely_posture(arm, target, search.feasible(), prior, end)) return Status::NoConvergence;
  GeodesicOptions options;
  options.lift_m = prior.lift(forward_kinematics(arm, start).wrist, target);
  const Status solved = search.solver.solve_cheapest(arm, start, end, options, out.path, out.certificate);
  if (solved == Status::Ok) describe_reach(arm, target, out);
  return solved;
}

Status ReachPlanner::plan_between(const ArmModel& arm, const Posture& start, const Posture& end, ReachPlan& out,
                                  double lift_m) noexcept {
  GeodesicOptions options;
  options.lift_m = lift_m;
  const Status status = workspace_->search.solver.solve_cheapest(arm, start, end, options, out.path, out.certificate);
  if (status != Status::Ok) return status;
  SelfMotion motion;
  const Vec3 wrist = forward_kinematics(arm, end).wrist;
  find_self_motion(arm, wrist, motion);
  out.reach_margin_m = motion.reach_margin_m;
  out.best_margin = limit_margin(arm.limits, end);
  describe_reach(arm, wrist, out);
  return Status::Ok;
}

Status ReachPlanner::sample_family(const ArmModel& arm, const Posture& start, const Vec3& target, int count,
                                   Family& out) noexcept {
  constexpr GeodesicOptions kSketch{1e-4, 8, 16, 1e-4};
  if (!target.allFinite() || !start.R_TU.allFinite() || !std::isfinite(start.phi)) return Status::NotFinite;
  if (count < 2 || count > kMaxFamily) return Status::OutOfRange;
  out.count = 0;
  SelfMotion motion;
  find_self_motion(arm, target, motion);
  if (motion.count == 0) return Status::TargetUnreachable;
  const int each = count / motion.count;
  ReachPlan& trial = workspace_->search.trial;
  for (int l = 0; l < motion.count; ++l) {
    double opening = 0.0;
    for (int k = 0; k < each; ++k) {
      FamilyMember& m = out.members[static_cast<std::size_t>(out.count)];
      const double psi = 2.0 * kPi * k / each;
      if (!loop_posture(arm, target, motion.loops[static_cast<std::size_t>(l)], psi, opening, m.end)) continue;
      m.swivel_rad = swivel_angle(forward_kinematics(arm, m.end));
      m.margin = limit_margin(arm.limits, m.end);
      const Status solved = workspace_->search.solver.solve(arm, start, m.end, kSketch, nullptr, trial.path,
                                                            trial.certificate);
      m.energy = solved == Status::Ok ? trial.path.energy : std::numeric_limits<double>::quiet_NaN();
      ++out.count;
    }
  }
  std::sort(out.members.begin(), out.members.begin() + out.count,
            [](const FamilyMember& a, const FamilyMember& b) { return a.swivel_rad < b.swivel_rad; });
  return Status::Ok;
}

}  // namespace glenoid
