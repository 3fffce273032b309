#include "prior_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace glenoid {
namespace {

constexpr double kSpacing = 5.0 * kPi / 180.0;  // rad of psi between samples
constexpr double kResolved = 1e-8;              // rad of psi

/// Cost of a loop's postures; infinite where there is none.
struct LoopCost {
  const ArmModel& arm;
  const Vec3& target;
  const SelfMotionLoop& loop;
  const PosturePrior& prior;
  double swivel_rad;

  double operator()(double psi, Posture& posture) const noexcept {
    double opening = 0.0;
    if (!loop_posture(arm, target, loop, psi, opening, posture)) return std::numeric_limits<double>::infinity();
    return prior.cost(arm, posture, swivel_rad);
  }
};

struct Best {
  double cost = std::numeric_limits<double>::infinity();
  Posture posture;
  void offer(double value, const Posture& candidate) noexcept {
    if (value < cost) cost = value, posture = candidate;
  }
};

void refine(const LoopCost& cost, double low, double high, Best& best) noexcept {
  constexpr double kGolden = 0.38196601125010515;
  Posture left, right;
  while (high - low > kResolved) {
    const double a = low + kGolden * (high - low), b = high - kGolden * (high - low);
    const double at_a = cost(a, left), at_b = cost(b, right);
    best.offer(at_a, left);
    best.offer(at_b, right);
    (at_a < at_b ? high : low) = at_a < at_b ? b : a;
  }
}

void search_arc(const LoopCost& cost, const FeasibleArc& arc, Best& best) noexcept {
  const int cells = std::max(1, static_cast<int>(std::ceil((arc.end - arc.begin) / kSpacing)));
  const double width = (arc.end - arc.begin) / cells;
  double least = std::numeric_limits<double>::infinity(), at = arc.begin;
  Posture posture;
  for (int k = 0; k <= cells; ++k) {
    const double psi = arc.begin + k * width, value = cost(psi, posture);
    best.offer(value, posture);
    if (value < least) least = value, at = psi;
  }
  if (std::isfinite(least)) {
    refine(cost, std::max(arc.begin, at - width), std::min(arc.end, at + width), best);
  }
}

}  // namespace

bool most_likely_posture(const ArmModel& arm, const Vec3& target, const FeasibleSet& feasible,
                         const PosturePrior& prior, Posture& out) noexcept {
  Best best;
  const double swivel = prior.swivel(target);
  for (int i = 0; i < feasible.count; ++i) {
    const FeasibleArc& arc = feasible.arcs[static_cast<std::size_t>(i)];
    search_arc({arm, target, feasible.motion.loops[static_cast<std::size_t>(arc.loop)], prior, swivel}, arc, best);
  }
  if (!std::isfinite(best.cost)) return false;
  out = best.posture;
  return true;
}

}  // namespace glenoid
