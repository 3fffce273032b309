#include "swivel_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "embedding.hpp"

namespace glenoid {
namespace {

constexpr double kCellWidth = 25.0 * kPi / 180.0;   // rad of psi between coarse energies
constexpr double kRival = 0.02;                      // relative energy within which a second candidate is examined
constexpr double kWideTurn = 2.0;                    // rad; beyond it two geodesics may compete, both starts are tried
constexpr double kTangentStep = 1e-5;                // rad of psi
constexpr double kMarginTolerance = 1e-9;            // rad; rounding of an end posture that sits on a limit
constexpr GeodesicOptions kCoarse{std::numeric_limits<double>::infinity(), 6, 6, 2e-2};
constexpr GeodesicOptions kFine{};


bool finite(const Posture& p) { return p.R_TU.allFinite() && std::isfinite(p.phi); }

/// Value of the cubic Hermite interpolant of a cell at t in [0, 1].
double hermite(const EnergySample& a, const EnergySample& b, double t) {
  const double h = b.psi - a.psi, r = 1.0 - t;
  return r * r * (1.0 + 2.0 * t) * a.energy + t * t * (3.0 - 2.0 * t) * b.energy + h * t * r * (r * a.slope - t * b.slope);
}

}  // namespace

Status SwivelSearch::prepare(const ArmModel& arm, const Posture& start, const Vec3& target, ReachPlan& out) noexcept {
  if (!finite(start) || !target.allFinite()) return Status::NotFinite;
  find_feasible_arcs(arm, target, set_);
  out.reach_margin_m = set_.motion.reach_margin_m;
  out.best_margin = set_.best;
  if (set_.motion.count == 0) return Status::TargetUnreachable;
  if (set_.count == 0) return Status::LimitsInfeasible;
  return Status::Ok;
}

/// Coarse energy and its exact derivative along the loop (docs/equations.md, S2).
bool SwivelSearch::coarse_energy(const ArmModel& arm, const Posture& start, const Vec3& target,
                                            const SelfMotionLoop& loop, const GeodesicPath* warm, EnergySample& s) {
  if (!loop_posture(arm, target, loop, s.psi, s.opening, s.posture)) return false;
  Certificate c;
  bool ok = solver.solve(arm, start, s.posture, kCoarse, warm, s.path, c) == Status::Ok;
  Vec4 momentum = solver.end_momentum();
  if (warm != nullptr && (!ok || c.long_way || c.rotation_angle_rad > kWideTurn)) {
    const bool cold = solver.solve(arm, start, s.posture, kCoarse, nullptr, scratch_, c) == Status::Ok;
    if (cold && (!ok || scratch_.energy < s.path.energy)) {
      s.path = scratch_;
      momentum = solver.end_momentum();
      ok = true;
    }
  }
  if (!ok) return false;
  s.energy = s.path.energy;
  Posture ahead;
  double opening = s.opening;
  if (!loop_posture(arm, target, loop, s.psi + kTangentStep, opening, ahead)) return false;
  const Vec3 turn = rotation_vector(s.posture.R_TU.transpose() * ahead.R_TU);
  s.slope = (momentum.head<3>().dot(turn) + momentum[3] * (ahead.phi - s.posture.phi)) / kTangentStep;
  return true;
}

void SwivelSearch::sample_arc(const ArmModel& arm, const Posture& start, const Vec3& target, int arc) {
  const FeasibleArc& a = set_.arcs[static_cast<std::size_t>(arc)];
  const SelfMotionLoop& loop = set_.motion.loops[static_cast<std::size_t>(a.loop)];
  const int cells = std::max(1, static_cast<int>(std::ceil((a.end - a.begin) / kCellWidth)));
  const int first = sample_count_;
  const GeodesicPath* warm = nullptr;
  double opening = 0.0;
  for (int k = 0; k <= cells && sample_count_ < kMaxSamples; ++k) {
    EnergySample& s = samples_[static_cast<std::size_t>(sample_count_)];
    s.psi = a.begin + (a.end - a.begin) * k / cells;
    s.opening = opening;
    if (k == cells && a.whole) {
      const double psi = s.psi;
      s = samples_[static_cast<std::size_t>(first)];  // the loop closes
      s.psi = psi;
    } else if (!coarse_energy(arm, start, target, loop, warm, s)) {
      continue;
    }
    opening = s.opening;
    warm = &s.path;
    ++sample_count_;
  }
  if (sample_count_ > first) find_candidates(arc, first);
}

void SwivelSearch::add_candidate(const Candidate& c) {
  if (candidate_count_ < kMaxCandidates) candidates_[static_cast<std::size_t>(candidate_count_++)] = c;
}

void SwivelSearch::find_candidates(int arc, int first) {
  const bool whole = set_.arcs[static_cast<std::size_t>(arc)].whole;
  const EnergySample& begin = samples_[static_cast<std::size_t>(first)];
  const EnergySample& end = samples_[static_cast<std::size_t>(sample_count_ - 1)];
  if (!whole) {
    if (begin.slope >= 0.0) add_candidate({begin.energy, begin.psi, arc, first, -1});
    if (end.slope <= 0.0) add_candidate({end.energy, end.psi, arc, sample_count_ - 1, +1});
  }
  constexpr int kParts = 8;
  for (int i = first; i + 1 < sample_count_; ++i) {
    const EnergySample &a = samples_[static_cast<std::size_t>(i)], &b = samples_[static_cast<std::size_t>(i + 1)];
    int best = 0;
    double least = a.energy;
    for (int k = 1; k <= kParts; ++k) {
      const double e = hermite(a, b, static_cast<double>(k) / kParts);
      if (e < least) least = e, best = k;
    }
    const bool interior = best > 0 && best < kParts;
    if (interior || (a.slope < 0.0 && b.slope > 0.0)) {
      const double t = static_cast<double>(best) / kParts;
      add_candidate({least, a.psi + t * (b.psi - a.psi), arc, t < 0.5 ? i : i + 1, 0});
    }
  }
}

Status SwivelSearch::refine_edge(const ArmModel& arm, const Posture& start, const Vec3& target, int arc, int edge,
                                            ReachPlan& out) {
  const FeasibleArc& a = set_.arcs[static_cast<std::size_t>(arc)];
  const SelfMotionLoop& loop = set_.motion.loops[static_cast<std::size_t>(a.loop)];
  const double psi = edge < 0 ? a.begin : a.end;
  double opening = 0.0;
  Posture posture, inside;
  if (!loop_posture(arm, target, loop, psi, opening, posture)) return Status::NoConvergence;
  const Status status = solver.solve(arm, start, posture, kFine, nullptr, out.path, out.certificate);
  if (status != Status::Ok) return status;
  const Vec4 p = solver.end_momentum();
  if (!loop_posture(arm, target, loop, psi - edge * kTangentStep, opening, inside)) return Status::NoConvergence;
  Vec4 tangent;
  tangent << rotation_vector(posture.R_TU.transpose() * inside.R_TU), inside.phi - posture.phi;
  const double inward = p.dot(tangent) / (p.norm() * tangent.norm() + 1e-300);
  out.certificate.swivel_at_limit = true;
  out.certificate.transversality = inward;  // >= 0: the energy rises into the feasible side
  return Status::Ok;
}

Status SwivelSearch::best_edge(const ArmModel& arm, const Posture& start, const Vec3& target, int arc,
                                          ReachPlan& out) {
  const Status first = refine_edge(arm, start, target, arc, -1, edge_);
  const Status second = refine_edge(arm, start, target, arc, +1, out);
  if (first == Status::Ok && (second != Status::Ok || edge_.path.energy < out.path.energy)) {
    out.path = edge_.path;
    out.certificate = edge_.certificate;
    return first;
  }
  return second;
}

Status SwivelSearch::refine(const ArmModel& arm, const Posture& start, const Vec3& target, const Candidate& c,
                                       ReachPlan& out) {
  if (c.edge != 0) return refine_edge(arm, start, target, c.arc, c.edge, out);
  const EnergySample& s = samples_[static_cast<std::size_t>(c.nearest)];
  const SelfMotionLoop& loop =
      set_.motion.loops[static_cast<std::size_t>(set_.arcs[static_cast<std::size_t>(c.arc)].loop)];
  Posture guess;
  double opening = s.opening;
  if (!loop_posture(arm, target, loop, c.psi, opening, guess)) guess = s.posture;
  const Status status = solver.solve_free_end(arm, start, guess, target, kFine, &s.path, out.path, out.certificate);
  if (status == Status::Ok) {
    const Posture& end = out.path.nodes[static_cast<std::size_t>(out.path.order)];
    if (limit_margin(arm.limits, end).margin_rad >= -kMarginTolerance) return status;
  }
  // It left the arc (or did not settle): the least energy of this arc lies at one of its edges, if it has any.
  return set_.arcs[static_cast<std::size_t>(c.arc)].whole ? Status::NoConvergence : best_edge(arm, start, target, c.arc, out);
}

/// No candidate settled: the end posture of least coarse energy, without a claim to be the minimum.
Status SwivelSearch::fall_back(const ArmModel& arm, const Posture& start, ReachPlan& out) {
  int least = -1;
  for (int i = 0; i < sample_count_; ++i) {
    const double energy = samples_[static_cast<std::size_t>(i)].energy;
    if (least < 0 || energy < samples_[static_cast<std::size_t>(least)].energy) least = i;
  }
  if (least < 0) return Status::NoConvergence;
  const Posture& end = samples_[static_cast<std::size_t>(least)].posture;
  const Status status = solver.solve(arm, start, end, kFine, nullptr, out.path, out.certificate);
  out.certificate.transversality = 1.0;  // nothing was shown about it
  return status;
}

Status SwivelSearch::search(const ArmModel& arm, const Posture& start, const Vec3& target, ReachPlan& out) noexcept {
  sample_count_ = candidate_count_ = 0;
  for (int arc = 0; arc < set_.count; ++arc) sample_arc(arm, start, target, arc);
  auto* const begin = candidates_.data();
  std::sort(begin, begin + candidate_count_, [](const Candidate& a, const Candidate& b) { return a.energy < b.energy; });
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < candidate_count_; ++i) {
    const Candidate& c = candidates_[static_cast<std::size_t>(i)];
    if (c.energy > (1.0 + kRival) * best) break;
    if (refine(arm, start, target, c, trial) != Status::Ok || !(trial.path.energy < best)) continue;
    best = trial.path.energy;
    out.path = trial.path;
    out.certificate = trial.certificate;
  }
  const Status status = std::isfinite(best) ? Status::Ok : fall_back(arm, start, out);
  if (status == Status::Ok) describe_reach(arm, target, out);
  return status;
}

void describe_reach(const ArmModel& arm, const Vec3& target, ReachPlan& out) noexcept {
  const Posture& end = out.path.nodes[static_cast<std::size_t>(out.path.order)];
  const ArmPoints points = forward_kinematics(arm, end);
  out.certificate.hand_error_m = (points.wrist - target).norm();
  out.swivel_rad = swivel_angle(points);
  LimitViolation& v = out.certificate.limits;
  v.worst.margin_rad = std::numeric_limits<double>::infinity();
  const int steps = 2 * std::max(out.path.order, 8);
  for (int k = 0; k <= steps; ++k) {
    const double lambda = static_cast<double>(k) / steps;
    const LimitMargin m = limit_margin(arm.limits, path_posture(out.path, lambda));
    if (m.margin_rad < v.worst.margin_rad) {
      v.worst = m;
      v.lambda = lambda;
    }
  }
  v.any = v.worst.margin_rad < -1e-6;
}

}  // namespace glenoid
