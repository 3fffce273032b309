#include "prior_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace glenoid {
namespace {

constexpr double kSpacing = 5.0 * kPi / 180.0;  // rad of psi between samples
constexpr double kResolved = 1e-9;              // rad of psi

/// Distance of a loop's postures from the wanted swivel angle, rad; infinite where there is none.
struct SwivelDistance {
  const ArmModel& arm;
  const Vec3& target;
  const SelfMotionLoop& loop;
  double swivel_rad;

  double operator()(double psi, Posture& posture) const noexcept {
    double opening = 0.0;
    if (!loop_posture(arm, target, loop, psi, opening, posture)) return std::numeric_limits<double>::infinity();
    return std::abs(std::remainder(swivel_angle(forward_kinematics(arm, posture)) - swivel_rad, 2.0 * kPi));
  }
};

struct Nearest {
  double distance = std::numeric_limits<double>::infinity();
  Posture posture;
  void offer(double value, const Posture& candidate) noexcept {
    if (value < distance) distance = value, posture = candidate;
  }
};

void refine(const SwivelDistance& distance, double low, double high, Nearest& best) noexcept {
  constexpr double kGolden = 0.38196601125010515;
  Posture left, right;
  while (high - low > kResolved) {
    const double a = low + kGolden * (high - low), b = high - kGolden * (high - low);
    const double at_a = distance(a, left), at_b = distance(b, right);
    best.offer(at_a, left);
    best.offer(at_b, right);
    (at_a < at_b ? high : low) = at_a < at_b ? b : a;
  }
}

void search_arc(const SwivelDistance& distance, const FeasibleArc& arc, Nearest& best) noexcept {
  const int cells = std::max(1, static_cast<int>(std::ceil((arc.end - arc.begin) / kSpacing)));
  const double width = (arc.end - arc.begin) / cells;
  double least = std::numeric_limits<double>::infinity(), at = arc.begin;
  Posture posture;
  for (int k = 0; k <= cells; ++k) {
    const double psi = arc.begin + k * width, value = distance(psi, posture);
    best.offer(value, posture);
    if (value < least) least = value, at = psi;
  }
  if (std::isfinite(least)) {
    refine(distance, std::max(arc.begin, at - width), std::min(arc.end, at + width), best);
  }
}

}  // namespace

bool nearest_feasible_posture(const ArmModel& arm, const Vec3& target, const FeasibleSet& feasible, double swivel_rad,
                              Posture& out) noexcept {
  Nearest best;
  for (int i = 0; i < feasible.count; ++i) {
    const FeasibleArc& arc = feasible.arcs[static_cast<std::size_t>(i)];
    const SelfMotionLoop& loop = feasible.motion.loops[static_cast<std::size_t>(arc.loop)];
    search_arc({arm, target, loop, swivel_rad}, arc, best);
  }
  if (!std::isfinite(best.distance)) return false;
  out = best.posture;
  return true;
}

}  // namespace glenoid
