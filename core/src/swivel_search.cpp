#include "swivel_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "embedding.hpp"
#include "glenoid/mass_matrix.hpp"
#include "lobatto.hpp"
#include "motion_jet.hpp"

namespace glenoid {
namespace {

constexpr double kCellWidth = 25.0 * kPi / 180.0;  // rad of psi between coarse energies
constexpr double kRivalCellWidth = 8.0 * kPi /
                                   180.0;  // the same where the rotation is wide and two geodesics may compete
constexpr double kRival = 0.02;            // relative energy within which a second candidate is examined
constexpr double kWideTurn = 1.9;          // rad; beyond it cold starts are tried beside the warm one
constexpr double kDear = 1.3;              // times the least energy: what a second geodesic does not save
constexpr double kTangentStep = 1e-5;      // rad of psi
constexpr double kMarginTolerance = 1e-9;  // rad; rounding of an end posture that sits on a limit
constexpr GeodesicOptions kCoarse{std::numeric_limits<double>::infinity(), 6, 6, 1e-1};
constexpr GeodesicOptions kMedium{std::numeric_limits<double>::infinity(), 6, 12, 1e-4};  // wide turns: rivals are near
constexpr GeodesicOptions kFine{};
constexpr GeodesicOptions kFreeEnd = [] {
  GeodesicOptions options;
  options.quick = true;  // what it does not find is bracketed
  return options;
}();

bool finite(const Posture& p) { return p.R_TU.allFinite() && std::isfinite(p.phi); }

double rotation_angle(const Posture& a, const Posture& b) {
  return rotation_vector(a.R_TU.transpose() * b.R_TU).norm();
}

/// A path as warm start for a solution that begins on the grid of `options`.
const GeodesicPath* warm_start(GeodesicPath& path, const GeodesicOptions& options) {
  if (path.order != options.first_order) finish_path(path);
  return &path;
}

/// Value of the cubic Hermite interpolant of a cell at t in [0, 1].
double hermite(const EnergySample& a, const EnergySample& b, double t) {
  const double h = b.psi - a.psi, r = 1.0 - t;
  return r * r * (1.0 + 2.0 * t) * a.energy + t * t * (3.0 - 2.0 * t) * b.energy +
         h * t * r * (r * a.slope - t * b.slope);
}

/// Looks for the least margin along a path.
struct MarginSearch {
  const JointLimits& limits;
  const GeodesicPath& path;
  LimitViolation& v;
  double spacing = 0.0;  ///< distance to the points beside the worst one

  double look(const Posture& posture, double lambda, double step) {
    const LimitMargin m = limit_margin(limits, posture);
    if (m.margin_rad < v.worst.margin_rad) v.worst = m, v.lambda = lambda, spacing = step;
    return m.margin_rad;
  }

  /// Halving steps to both sides of the worst point.
  void sharpen() {
    constexpr int kHalvings = 3;
    for (int i = 0; i < kHalvings; ++i) {
      const double step = 0.5 * spacing, middle = v.lambda;
      for (const double lambda : {middle - step, middle + step}) {
        if (lambda > 0.0 && lambda < 1.0) look(path_posture(path, lambda), lambda, step);
      }
      spacing = step;
    }
  }
};

/// Least margin along a path: at its nodes, and between two of them where a limit is near.
void find_violation(const JointLimits& limits, const GeodesicPath& path, LimitViolation& v) {
  constexpr double kNear = 0.2;       // rad of margin
  constexpr double kReported = 1e-6;  // rad; less is the rounding of an end on a limit
  const Lobatto& grid = lobatto(path.order);
  v = LimitViolation{};
  v.worst.margin_rad = std::numeric_limits<double>::infinity();
  MarginSearch search{limits, path, v};
  double before = search.look(path.nodes[0], 0.0, grid.node[1]);
  for (int k = 1; k <= path.order; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double width = grid.node[i] - grid.node[i - 1], middle = grid.node[i - 1] + 0.5 * width;
    const double now = search.look(path.nodes[i], grid.node[i], width);
    if (std::min(before, now) < kNear) search.look(path_posture(path, middle), middle, 0.5 * width);
    before = now;
  }
  if (v.worst.margin_rad < kNear) search.sharpen();
  v.any = v.worst.margin_rad < -kReported;
}

/// Variation of the energy of the interpolated path: between nodes it is larger than at them, where derivatives are best.
double variation_between_nodes(const ArmModel& arm, const GeodesicPath& path) {
  const Lobatto& grid = lobatto(path.order);
  double conserved = path.energy, most = 0.0;
  for (int k = 0; k <= path.order && path.lift_m != 0.0; ++k) {
    const auto i = static_cast<std::size_t>(k);
    conserved += grid.weight[i] * path.lift_m * mass_height(arm, path.nodes[i]);
  }
  for (const int k : {0, 1, path.order / 2, path.order - 1}) {
    const auto i = static_cast<std::size_t>(k);
    const double middle = 0.5 * (grid.node[i] + grid.node[i + 1]);
    PostureJet jet;
    PostureRates rates, accelerations;
    evaluate_path(path, middle, jet);
    body_rates(jet, rates, accelerations);
    Vec4 v;
    v << rates.w_TU_U, rates.phi;
    const Posture posture = path_posture(path, middle);
    const double raised = path.lift_m != 0.0 ? path.lift_m * mass_height(arm, posture) : 0.0;
    most = std::max(most, std::abs(0.5 * v.dot(body_mass_matrix(arm, posture) * v) + raised - conserved));
  }
  return path.energy > 0.0 ? 2.0 * most / path.energy : 0.0;
}

}  // namespace

Status SwivelSearch::prepare(const ArmModel& arm, const Posture& start, const Vec3& target, ReachPlan& out) noexcept {
  if (!finite(start) || !target.allFinite()) return Status::NotFinite;
  find_feasible_arcs(arm, start, target, set_);
  out.reach_margin_m = set_.motion.reach_margin_m;
  out.best_margin = set_.best;
  if (set_.motion.count == 0) return Status::TargetUnreachable;
  if (set_.count == 0) return Status::LimitsInfeasible;
  return Status::Ok;
}

const SelfMotionLoop& SwivelSearch::loop_of(int arc) const {
  return set_.motion.loops[static_cast<std::size_t>(set_.arcs[static_cast<std::size_t>(arc)].loop)];
}

/// Cold starts in the short class and, where the rotation is wide, in the other one; keeps what is cheaper than s.path.
bool SwivelSearch::try_cold(const ArmModel& arm, const Posture& start, const GeodesicOptions& options, bool solved,
                            EnergySample& s) {
  Certificate c;
  const bool ok = solver.solve_cheapest(arm, start, s.posture, options, scratch_, c) == Status::Ok;
  if (ok && (!solved || scratch_.energy < s.path.energy)) {
    s.path = scratch_;
    s.momentum = solver.end_momentum();
  }
  return ok || solved;
}

/// Energy and its exact derivative along the loop (docs/equations.md, S2), continued from a sample beside it where there is one.
bool SwivelSearch::sample_energy(const ArmModel& arm, const Posture& start, const Vec3& target,
                                 const SelfMotionLoop& loop, const GeodesicOptions& options, EnergySample* beside,
                                 EnergySample& s) {
  if (!loop_posture(arm, target, loop, s.psi, s.opening, s.posture)) return false;
  s.rotation = rotation_angle(start, s.posture);
  Certificate c;
  bool ok = false;
  if (beside != nullptr) {
    ok = solver.solve(arm, start, s.posture, options, warm_start(beside->path, options), s.path, c) == Status::Ok;
    s.momentum = solver.end_momentum();
  }
  const bool refined = beside != nullptr && beside->psi == s.psi;  // the same posture, solved before
  const bool wide = std::max(s.rotation, beside != nullptr ? beside->rotation : 0.0) > kWideTurn;
  const bool dear = ok && s.path.energy > kDear * least_;
  if (!ok || (!refined && (c.long_way || (wide && !dear)))) ok = try_cold(arm, start, options, ok, s);
  if (!ok) return false;
  s.energy = s.path.energy;
  least_ = std::min(least_, s.energy);
  Posture ahead;
  double opening = s.opening;
  if (!loop_posture(arm, target, loop, s.psi + kTangentStep, opening, ahead)) return false;
  const Vec3 turn = rotation_vector(s.posture.R_TU.transpose() * ahead.R_TU);
  s.slope = (s.momentum.head<3>().dot(turn) + s.momentum[3] * (ahead.phi - s.posture.phi)) / kTangentStep;
  return true;
}

/// Solves the coarse energy at psi of an arc. @return the new sample, or null where there is no room or no path.
EnergySample* SwivelSearch::add_sample(const ArmModel& arm, const Posture& start, const Vec3& target, int arc,
                                       double psi, EnergySample* beside) {
  if (sample_count_ == kMaxSamples) return nullptr;
  const SelfMotionLoop& loop = loop_of(arc);
  EnergySample& s = samples_[static_cast<std::size_t>(sample_count_)];
  s.psi = psi;
  s.opening = beside != nullptr ? beside->opening : 0.0;
  bool ok = sample_energy(arm, start, target, loop, kCoarse, beside, s);
  if (ok && contested(s)) {  // the coarse grid errs by more than rivals differ
    coarse_ = s;
    ok = sample_energy(arm, start, target, loop, kMedium, &coarse_, s);
  }
  if (!ok) return nullptr;
  ++sample_count_;
  return &s;
}

/// Samples from the one `beside` to the end of an arc.
void SwivelSearch::sweep(const ArmModel& arm, const Posture& start, const Vec3& target, int arc, double end,
                         EnergySample* beside) {
  const FeasibleArc& a = set_.arcs[static_cast<std::size_t>(arc)];
  double psi = a.nearest;
  const double span = end - psi, width = span / std::max(1.0, std::ceil(std::abs(span) / kCellWidth));
  const double narrow = std::copysign(std::min(std::abs(width), kRivalCellWidth), span);
  while (std::abs(end - psi) > kTangentStep && sample_count_ < kMaxSamples) {
    psi += beside != nullptr && contested(*beside) ? narrow : width;
    if ((end - psi) * span < kTangentStep * std::abs(span)) psi = end;
    if (EnergySample* const next = add_sample(arm, start, target, arc, psi, beside)) beside = next;
  }
}

/// Energies along an arc, from the posture that is turned least towards both ends: the cheap ones come first, and the
/// dear ones need not be exact.
void SwivelSearch::sample_arc(const ArmModel& arm, const Posture& start, const Vec3& target, int arc) {
  const FeasibleArc& a = set_.arcs[static_cast<std::size_t>(arc)];
  const int first = sample_count_;
  EnergySample* const middle = add_sample(arm, start, target, arc, a.nearest, nullptr);
  if (!a.whole) sweep(arm, start, target, arc, a.begin, middle);
  const int below = sample_count_;
  sweep(arm, start, target, arc, a.end, middle);
  for (int k = first; k < below; ++k) order_[static_cast<std::size_t>(first + below - 1 - k)] = k;
  for (int k = below; k < sample_count_; ++k) order_[static_cast<std::size_t>(k)] = k;
  if (sample_count_ > first) find_candidates(arc, first);
}

/// Whether another geodesic to this posture may be the cheapest of all.
bool SwivelSearch::contested(const EnergySample& s) const noexcept {
  return s.rotation > kWideRotation && s.energy < kDear * least_;
}

void SwivelSearch::add_candidate(const Candidate& c) {
  if (candidate_count_ < kMaxCandidates) candidates_[static_cast<std::size_t>(candidate_count_++)] = c;
}

void SwivelSearch::find_candidates(int arc, int first) {
  const bool whole = set_.arcs[static_cast<std::size_t>(arc)].whole;
  const EnergySample& begin = sample(first);
  const EnergySample& end = sample(sample_count_ - 1);
  if (!whole) {
    if (begin.slope >= 0.0) add_candidate({begin.energy, begin.psi, arc, first, first, -1});
    if (end.slope <= 0.0) add_candidate({end.energy, end.psi, arc, sample_count_ - 1, first, +1});
  }
  constexpr int kParts = 8;
  for (int i = first; i + 1 < sample_count_; ++i) {
    const EnergySample &a = sample(i), &b = sample(i + 1);
    int best = 0;
    double least = a.energy;
    for (int k = 1; k <= kParts; ++k) {
      const double e = hermite(a, b, static_cast<double>(k) / kParts);
      if (e < least) least = e, best = k;
    }
    const bool dips = best > 0 && best < kParts;
    // An energy that falls into the cell from the lower side has a minimum inside, whatever the interpolant says.
    const bool enclosed = (a.slope < 0.0 && b.energy >= a.energy) || (b.slope > 0.0 && a.energy >= b.energy);
    if (dips || enclosed || (a.slope < 0.0 && b.slope > 0.0)) {
      const double t = std::clamp(static_cast<double>(best) / kParts, 0.5 / kParts, 1.0 - 0.5 / kParts);
      add_candidate({least, a.psi + t * (b.psi - a.psi), arc, t < 0.5 ? i : i + 1, i, 0});
    }
  }
}

Status SwivelSearch::refine_edge(const ArmModel& arm, const Posture& start, const Vec3& target, int arc, int edge,
                                 const GeodesicPath* warm, ReachPlan& out) {
  const FeasibleArc& a = set_.arcs[static_cast<std::size_t>(arc)];
  const SelfMotionLoop& loop = loop_of(arc);
  const double psi = edge < 0 ? a.begin : a.end;
  double opening = 0.0;
  Posture posture, inside;
  if (!loop_posture(arm, target, loop, psi, opening, posture)) return Status::NoConvergence;
  const Status status = warm != nullptr ? solver.solve(arm, start, posture, kFine, warm, out.path, out.certificate)
                                        : solver.solve_cheapest(arm, start, posture, kFine, out.path, out.certificate);
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

Status SwivelSearch::best_edge(const ArmModel& arm, const Posture& start, const Vec3& target, int arc, ReachPlan& out) {
  if (set_.arcs[static_cast<std::size_t>(arc)].whole) return Status::NoConvergence;
  const Status first = refine_edge(arm, start, target, arc, -1, nullptr, edge_);
  const Status second = refine_edge(arm, start, target, arc, +1, nullptr, out);
  if (first == Status::Ok && (second != Status::Ok || edge_.path.energy < out.path.energy)) {
    out.path = edge_.path;
    out.certificate = edge_.certificate;
    return first;
  }
  return second;
}

/// Free end from a guess, with the result inside the limits.
Status SwivelSearch::refine_interior(const ArmModel& arm, const Posture& start, const Vec3& target,
                                     const Posture& guess, const GeodesicPath& warm, ReachPlan& out) {
  const Status status = solver.solve_free_end(arm, start, guess, target, kFreeEnd, &warm, out.path, out.certificate);
  if (status != Status::Ok) return status;
  const Posture& end = out.path.nodes[static_cast<std::size_t>(out.path.order)];
  return limit_margin(arm.limits, end).margin_rad >= -kMarginTolerance ? status : Status::LimitsInfeasible;
}

/// Narrows (low_, high_) around a minimum by the sign of the exact slope; middle_ is the last one tried.
bool SwivelSearch::narrow_cell(const ArmModel& arm, const Posture& start, const Vec3& target,
                               const SelfMotionLoop& loop, const GeodesicOptions& options, double width) {
  constexpr int kMostSteps = 40;
  for (int i = 0; i < kMostSteps && high_.psi - low_.psi > width; ++i) {
    const double secant = low_.slope / (low_.slope - high_.slope);
    const double share = i % 3 == 2 || !(secant > 0.05 && secant < 0.95) ? 0.5 : secant;
    EnergySample& near = share < 0.5 ? low_ : high_;
    middle_.psi = low_.psi + share * (high_.psi - low_.psi);
    middle_.opening = near.opening;
    if (!sample_energy(arm, start, target, loop, options, &near, middle_)) return false;
    (middle_.slope < 0.0 ? low_ : high_) = middle_;
  }
  return true;
}

/// Minimum inside a cell where the free end left the arc or did not settle: bracketed, so that it cannot escape.
Status SwivelSearch::refine_cell(const ArmModel& arm, const Posture& start, const Vec3& target, const Candidate& c,
                                 ReachPlan& out) {
  constexpr double kFirstWidth = 0.02, kLastWidth = 1e-6;  // rad of psi
  const SelfMotionLoop& loop = loop_of(c.arc);
  low_ = sample(c.cell);
  high_ = sample(c.cell + 1);
  if (!narrow_cell(arm, start, target, loop, kMedium, kFirstWidth)) return Status::NoConvergence;
  const GeodesicPath& warm = *warm_start(middle_.path, kFine);
  if (refine_interior(arm, start, target, middle_.posture, warm, out) == Status::Ok) return Status::Ok;
  if (!narrow_cell(arm, start, target, loop, kFine, kLastWidth)) return Status::NoConvergence;
  const Status status = solver.solve(arm, start, middle_.posture, kFine, warm_start(middle_.path, kFine), out.path,
                                     out.certificate);
  const Vec4 p = solver.end_momentum();
  out.certificate.transversality = std::abs(middle_.slope) / (p.norm() + 1e-300);
  return status;
}

Status SwivelSearch::refine(const ArmModel& arm, const Posture& start, const Vec3& target, const Candidate& c,
                            ReachPlan& out) {
  EnergySample& s = sample(c.nearest);
  const GeodesicPath& warm = *warm_start(s.path, kFine);
  if (c.edge != 0) return refine_edge(arm, start, target, c.arc, c.edge, &warm, out);
  Posture guess;
  double opening = s.opening;
  if (!loop_posture(arm, target, loop_of(c.arc), c.psi, opening, guess)) guess = s.posture;
  if (refine_interior(arm, start, target, guess, warm, out) == Status::Ok) return Status::Ok;
  const Status inside = refine_cell(arm, start, target, c, out);
  const Status edge = best_edge(arm, start, target, c.arc, edges_);
  if (edge != Status::Ok || (inside == Status::Ok && out.path.energy <= edges_.path.energy)) return inside;
  out.path = edges_.path;
  out.certificate = edges_.certificate;
  return edge;
}

/// No candidate settled: the end posture of least coarse energy, without a claim to be the minimum.
Status SwivelSearch::fall_back(const ArmModel& arm, const Posture& start, ReachPlan& out) {
  int least = -1;
  for (int i = 0; i < sample_count_; ++i) {
    if (least < 0 || sample(i).energy < sample(least).energy) least = i;
  }
  if (least < 0) return Status::NoConvergence;
  const Posture& end = sample(least).posture;
  const Status status = solver.solve(arm, start, end, kFine, nullptr, out.path, out.certificate);
  out.certificate.transversality = 1.0;  // nothing was shown about it
  return status;
}

Status SwivelSearch::search(const ArmModel& arm, const Posture& start, const Vec3& target, ReachPlan& out) noexcept {
  sample_count_ = candidate_count_ = 0;
  least_ = std::numeric_limits<double>::infinity();
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
  find_violation(arm.limits, out.path, out.certificate.limits);
  out.certificate.speed_variation = std::max(out.certificate.speed_variation, variation_between_nodes(arm, out.path));
}

}  // namespace glenoid
