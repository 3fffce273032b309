#include "swivel_arcs.hpp"

#include <algorithm>
#include <cmath>

namespace glenoid {
namespace {

constexpr double kEdgeTolerance = 1e-11;  // rad of psi
constexpr double kLimitRounding = 5e-10;  // rad; a posture that sits on a limit is inside, whatever its last digits say
constexpr double kNarrow = 0.35;  // rad of margin per ring step that an extremum between samples may hide, at 72

/// Margin by which feasibility is decided.
double slack(const RingSample& s) { return s.exists ? s.margin.margin_rad + kLimitRounding : -1e3; }

/// Explores the margin along one loop.
struct Explorer {
  const ArmModel& arm;
  const Vec3& wrist;
  const SelfMotionLoop& loop;
  FeasibleSet& out;

  double margin(double psi, double& opening) {
    RingSample s;
    s.opening = opening;
    sample_loop(arm, wrist, loop, psi, s);
    opening = s.opening;
    if (s.exists && s.margin.margin_rad > out.best.margin_rad) out.best = s.margin;
    return slack(s);
  }

  /// Last feasible psi between a feasible and an infeasible one.
  double edge(double inside, double outside, double m_in, double m_out, double opening) {
    for (int it = 0; it < 60 && std::abs(outside - inside) > kEdgeTolerance; ++it) {
      double t = it % 3 == 2 || m_out < -100.0 ? 0.5 : m_in / (m_in - m_out);
      t = std::clamp(t, 0.02, 0.98);
      const double psi = inside + t * (outside - inside);
      const double m = margin(psi, opening);
      if (m >= 0.0) {
        inside = psi;
        m_in = m;
        if (m < 1e-13) break;
      } else {
        outside = psi;
        m_out = m;
      }
    }
    return inside;
  }

  /// Golden-section extremum of the margin in (a, b); sign = +1 for a maximum. Stops early once its sign is settled.
  double extremum(double a, double b, double sign, double opening, double& value) {
    constexpr double kGolden = 0.6180339887498949;
    double c = b - kGolden * (b - a), d = a + kGolden * (b - a);
    double fc = sign * margin(c, opening), fd = sign * margin(d, opening);
    for (int it = 0; it < 40 && !(std::max(fc, fd) > 0.0); ++it) {
      if (fc > fd) {
        b = d, d = c, fd = fc;
        c = b - kGolden * (b - a);
        fc = sign * margin(c, opening);
      } else {
        a = c, c = d, fc = fd;
        d = a + kGolden * (b - a);
        fd = sign * margin(d, opening);
      }
    }
    value = sign * std::max(fc, fd);
    return fc > fd ? c : d;
  }
};

struct Crossing {
  double psi;
  bool enters;  ///< from infeasible to feasible with growing psi
};

/// Appends the arcs between consecutive crossings of one loop.
void connect(const std::array<Crossing, 2 * FeasibleSet::kMaxArcs>& crossings, int count, bool feasible, int loop,
             FeasibleSet& out) {
  if (count == 0) {
    if (feasible && out.count < FeasibleSet::kMaxArcs) {
      out.arcs[static_cast<std::size_t>(out.count++)] = {loop, 0.0, 2.0 * kPi, true};
    }
    return;
  }
  for (int i = 0; i < count; ++i) {
    const Crossing& a = crossings[static_cast<std::size_t>(i)];
    if (!a.enters || out.count >= FeasibleSet::kMaxArcs) continue;
    const Crossing& b = crossings[static_cast<std::size_t>((i + 1) % count)];
    const double turn = i + 1 == count ? 2.0 * kPi : 0.0;
    out.arcs[static_cast<std::size_t>(out.count++)] = {loop, a.psi, b.psi + turn, false};
  }
}

/// Opening angle that three samples before this one lead to; 0, no guess, if one is missing.
double extrapolate(const RingSample* s) {
  return s[-1].exists && s[-2].exists && s[-3].exists ? 3.0 * (s[-1].opening - s[-2].opening) + s[-3].opening : 0.0;
}

void scan_loop(const ArmModel& arm, const Vec3& wrist, int index, int ring, FeasibleSet& out) {
  const SelfMotionLoop& loop = out.motion.loops[static_cast<std::size_t>(index)];
  Explorer explorer{arm, wrist, loop, out};
  const double spacing = 2.0 * kPi / ring;
  double opening = 0.0;
  for (int k = 0; k < ring; ++k) {
    RingSample& s = out.ring[static_cast<std::size_t>(k)];
    s.opening = k < 3 ? opening : extrapolate(&out.ring[static_cast<std::size_t>(k)]);
    sample_loop(arm, wrist, loop, k * spacing, s);
    opening = s.exists ? s.opening : 0.0;
    if (!s.exists) s.margin.margin_rad = -1e3;
    if (s.margin.margin_rad > out.best.margin_rad) out.best = s.margin;
  }
  const auto at = [&out, ring](int k) -> const RingSample& {
    return out.ring[static_cast<std::size_t>((k + ring) % ring)];
  };
  std::array<Crossing, 2 * FeasibleSet::kMaxArcs> crossings;
  int count = 0;
  const auto add = [&crossings, &count](double psi, bool enters) {
    if (count < static_cast<int>(crossings.size())) crossings[static_cast<std::size_t>(count++)] = {psi, enters};
  };
  for (int k = 0; k < ring; ++k) {
    const RingSample &s0 = at(k - 1), &s1 = at(k), &s2 = at(k + 1);
    const double m0 = slack(s0), m1 = slack(s1), m2 = slack(s2);
    const double psi = k * spacing, hidden = kNarrow * FeasibleSet::kRing / ring;
    const bool all_in = m0 >= 0.0 && m1 >= 0.0 && m2 >= 0.0, all_out = m0 < 0.0 && m1 < 0.0 && m2 < 0.0;
    const bool narrow_arc = all_out && m1 >= m0 && m1 > m2 && m1 > -hidden;
    const bool narrow_gap = all_in && m1 <= m0 && m1 < m2 && m1 < hidden;
    if (narrow_arc || narrow_gap) {
      double value = 0.0;
      const double top = explorer.extremum(psi - spacing, psi + spacing, narrow_arc ? 1.0 : -1.0, s1.opening, value);
      if (narrow_arc == (value >= 0.0)) {
        if (narrow_arc) {
          add(explorer.edge(top, psi - spacing, value, m0, s1.opening), true);
          add(explorer.edge(top, psi + spacing, value, m2, s1.opening), false);
        } else {
          add(explorer.edge(psi - spacing, top, m0, value, s1.opening), false);
          add(explorer.edge(psi + spacing, top, m2, value, s1.opening), true);
        }
      }
    }
    if (m1 >= 0.0 && m2 < 0.0) add(explorer.edge(psi, psi + spacing, m1, m2, s1.opening), false);
    if (m1 < 0.0 && m2 >= 0.0) add(explorer.edge(psi + spacing, psi, m2, m1, s2.opening), true);
  }
  std::sort(crossings.begin(), crossings.begin() + count,
            [](const Crossing& a, const Crossing& b) { return a.psi < b.psi; });
  connect(crossings, count, slack(at(0)) >= 0.0, index, out);
}

}  // namespace

void sample_loop(const ArmModel& arm, const Vec3& wrist, const SelfMotionLoop& loop, double psi,
                 RingSample& s) noexcept {
  s.psi = psi;
  s.exists = loop_posture(arm, wrist, loop, psi, s.opening, s.posture);
  if (s.exists) s.margin = limit_margin(arm.limits, s.posture);
}

void find_feasible_arcs(const ArmModel& arm, const Vec3& wrist, FeasibleSet& out) noexcept {
  find_self_motion(arm, wrist, out.motion);
  out.count = 0;
  out.best = LimitMargin{-1e3, 0, false};
  for (int i = 0; i < out.motion.count; ++i) scan_loop(arm, wrist, i, FeasibleSet::kRing, out);
  if (out.count > 0) return;
  for (int i = 0; i < out.motion.count; ++i) scan_loop(arm, wrist, i, FeasibleSet::kFineRing, out);
}

}  // namespace glenoid
