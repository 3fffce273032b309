#include "judge.hpp"

#include <algorithm>
#include <cmath>

#include "glenoid/kinematics.hpp"

namespace glenoid::test {
namespace {

bool all_finite(const Posture& posture) { return posture.R_TU.allFinite() && std::isfinite(posture.phi); }

bool all_finite(const ReachPlan& plan) {
  bool finite = std::isfinite(plan.path.energy) && std::isfinite(plan.swivel_rad) &&
                std::isfinite(plan.reach_margin_m) && std::isfinite(plan.best_margin.margin_rad) &&
                std::isfinite(plan.certificate.spectral_tail) && std::isfinite(plan.certificate.speed_variation) &&
                std::isfinite(plan.certificate.transversality) && std::isfinite(plan.certificate.gradient) &&
                std::isfinite(plan.certificate.hand_error_m);
  for (int k = 0; k <= plan.path.order; ++k)
    finite = finite && all_finite(plan.path.nodes[static_cast<std::size_t>(k)]);
  PostureJet jet;
  for (const double lambda : {0.0, 0.3, 1.0}) {
    evaluate_path(plan.path, lambda, jet);
    finite = finite && jet.x.allFinite() && jet.ddx.allFinite() && jet.ddz.allFinite() && std::isfinite(jet.ddphi);
  }
  return finite;
}

/// What is wrong with a plan that claims to be good; empty if nothing.
std::string flaw(const ReachTask& task, const ReachPlan& plan, double own_energy) {
  const Posture& first = plan.path.nodes[0];
  const Posture& last = plan.path.nodes[static_cast<std::size_t>(plan.path.order)];
  if ((first.R_TU - task.start.R_TU).norm() + std::abs(first.phi - task.start.phi) > 1e-9)
    return "does not begin at the start";
  if ((last.R_TU.transpose() * last.R_TU - Mat3::Identity()).norm() > 1e-9) return "end is not a rotation";
  const double hand_error = (forward_kinematics(task.arm, last).wrist - task.target).norm();
  if (hand_error > 1e-8) return "hand misses by " + std::to_string(hand_error) + " m";
  const double margin = limit_margin(task.arm.limits, last).margin_rad;
  if (margin < -1e-7) return "end is outside the limits by " + std::to_string(-margin) + " rad";
  const double difference = plan.path.energy - own_energy;
  if (!(std::abs(difference) <= kMissTolerance * std::max(own_energy, kSmallEnergy))) {
    return "energy differs from that of its own converged path by " + std::to_string(difference / own_energy);
  }
  return "";
}

/// The reference, improved by what is known about the task.
Reference make_reference(const ReachTask& task, int count, GeodesicSolver& solver) {
  Reference reference = sweep_swivel(task.arm, task.start, task.target, count, solver);
  if (!known_feasible(task) || limit_margin(task.arm.limits, task.known_end).margin_rad < 0.0) return reference;
  reference.reachable = reference.feasible = true;
  reference.energy = std::min(reference.energy, converged_energy(task.arm, task.start, task.known_end, solver));
  return reference;
}

Verdict judge_refusal(const Reference& reference, Status status) {
  if (status == Status::NoConvergence) return Verdict::NoConvergence;
  if (!reference.feasible) {
    const bool named = reference.reachable ? status == Status::LimitsInfeasible
                                           : status == Status::TargetUnreachable || status == Status::LimitsInfeasible;
    return named ? Verdict::InfeasibleNamed : Verdict::FalseInfeasible;
  }
  return reference.widest_arc >= 2 ? Verdict::FalseInfeasible : Verdict::NarrowRefused;
}

}  // namespace

const char* to_string(Verdict verdict) noexcept {
  constexpr const char* names[kVerdicts] = {"solved",           "infeasible named",   "MISS",
                                            "FALSE INFEASIBLE", "narrow arc refused", "FALSE FEASIBLE",
                                            "NOT FINITE",       "NO CONVERGENCE"};
  return names[static_cast<int>(verdict)];
}

Judgement judge(const ReachTask& task, int count, ReachPlanner& planner, GeodesicSolver& solver) {
  Judgement out;
  ReachPlan plan;
  out.reference = make_reference(task, count, solver);
  out.status = planner.plan_minimum_energy(task.arm, task.start, task.target, plan);
  if (out.status != Status::Ok) {
    out.verdict = judge_refusal(out.reference, out.status);
    return out;
  }
  if (!all_finite(plan)) {
    out.verdict = Verdict::NotFinite;
    return out;
  }
  const Posture& last = plan.path.nodes[static_cast<std::size_t>(plan.path.order)];
  out.leaves_limits = plan.certificate.limits.any;
  out.remark = flaw(task, plan, converged_energy(task.arm, task.start, last, solver, &plan.path));
  if (!out.remark.empty()) {
    out.verdict = Verdict::FalseFeasible;
    return out;
  }
  if (!std::isfinite(out.reference.energy)) return out;  // an answer where the reference has none
  out.excess = (plan.path.energy - out.reference.energy) / std::max(out.reference.energy, kSmallEnergy);
  if (out.excess > kMissTolerance) out.verdict = Verdict::Miss;
  return out;
}

}  // namespace glenoid::test
