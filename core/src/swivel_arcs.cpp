#include "swivel_arcs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

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

/// Adds samples on both sides of the elevation below which the limit on eta does not apply: the margin jumps there, and an
/// arc or a gap beside the jump may be narrower than the ring's spacing.
struct JumpFinder {
  const ArmModel& arm;
  const Vec3& wrist;
  const SelfMotionLoop& loop;
  FeasibleSet& out;
  int jumps = 0;

  RingSample at(double psi, double opening) const {
    RingSample s;
    s.opening = opening;
    sample_loop(arm, wrist, loop, psi, s);
    if (!s.exists) s.margin.margin_rad = -1e3;
    return s;
  }

  /// Cosine of the elevation; the sample of a ray without a posture counts as raised.
  static double height(const RingSample& s) { return s.exists ? s.posture.R_TU(2, 2) : -1.0; }
  static bool below(const RingSample& s) { return height(s) > std::cos(kEtaLimitMinElevation); }

  /// Sample of least elevation between two.
  RingSample lowest(double a, double b, double opening) const {
    for (int it = 0; it < 24; ++it) {
      const double c = a + (b - a) / 3.0, d = b - (b - a) / 3.0;
      const bool left = height(at(c, opening)) > height(at(d, opening));
      (left ? b : a) = left ? d : c;
    }
    return at(0.5 * (a + b), opening);
  }

  /// Samples just above and just below the elevation, between one above and one below it.
  void add_jump(RingSample above, RingSample under) {
    if (jumps == FeasibleSet::kMaxJumps) return;
    while (std::abs(above.psi - under.psi) > kEdgeTolerance) {
      const RingSample middle = at(0.5 * (above.psi + under.psi), under.opening);
      (below(middle) ? under : above) = middle;
    }
    for (const RingSample& s : {above, under}) out.ring[static_cast<std::size_t>(out.samples++)] = s;
    ++jumps;
  }

  /// Looks beside sample k of the first `ring` ones; their distance is `spacing`, and the upper arm turns by less than that.
  void look(int k, int ring, double spacing) {
    RingSample s0 = out.ring[static_cast<std::size_t>((k + ring - 1) % ring)];
    const RingSample s1 = out.ring[static_cast<std::size_t>(k)];
    RingSample s2 = out.ring[static_cast<std::size_t>((k + 1) % ring)];
    s0.psi = s1.psi - spacing;
    s2.psi = s1.psi + spacing;
    if (below(s1) != below(s2)) below(s1) ? add_jump(s2, s1) : add_jump(s1, s2);
    const bool dips = height(s1) > height(s0) && height(s1) >= height(s2) && !below(s0) && !below(s1) && !below(s2);
    if (!dips || height(s1) < std::cos(kEtaLimitMinElevation + spacing)) return;
    const RingSample under = lowest(s0.psi, s2.psi, s1.opening);
    if (!below(under)) return;
    add_jump(under.psi < s1.psi ? s0 : s1, under);
    add_jump(under.psi < s1.psi ? s1 : s2, under);
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
      out.arcs[static_cast<std::size_t>(out.count++)] = {loop, 0.0, 2.0 * kPi, true, 0.0};
    }
    return;
  }
  for (int i = 0; i < count; ++i) {
    const Crossing& a = crossings[static_cast<std::size_t>(i)];
    if (!a.enters || out.count >= FeasibleSet::kMaxArcs) continue;
    const Crossing& b = crossings[static_cast<std::size_t>((i + 1) % count)];
    const double turn = i + 1 == count ? 2.0 * kPi : 0.0;
    out.arcs[static_cast<std::size_t>(out.count++)] = {loop, a.psi, b.psi + turn, false, 0.5 * (a.psi + b.psi + turn)};
  }
}

/// Sets `nearest` of the arcs from `first` on, by the samples of the ring.
void find_nearest(const Posture& start, int first, FeasibleSet& out) {
  for (int i = first; i < out.count; ++i) {
    FeasibleArc& arc = out.arcs[static_cast<std::size_t>(i)];
    double best = -std::numeric_limits<double>::infinity();
    for (int k = 0; k < out.samples; ++k) {
      const RingSample& s = out.ring[static_cast<std::size_t>(k)];
      const double psi = s.psi < arc.begin ? s.psi + 2.0 * kPi : s.psi;
      if (slack(s) < 0.0 || psi < arc.begin || psi > arc.end) continue;
      const double trace = start.R_TU.cwiseProduct(s.posture.R_TU).sum();  // 1 + 2 cos(angle of rotation)
      if (trace > best) best = trace, arc.nearest = psi;
    }
    if (arc.whole) arc.begin = arc.nearest, arc.end = arc.nearest + 2.0 * kPi;
  }
}

/// Opening angle that three samples before this one lead to; 0, no guess, if one is missing.
double extrapolate(const RingSample* s) {
  return s[-1].exists && s[-2].exists && s[-3].exists ? 3.0 * (s[-1].opening - s[-2].opening) + s[-3].opening : 0.0;
}

void sample_ring(const ArmModel& arm, const Vec3& wrist, const SelfMotionLoop& loop, int ring, FeasibleSet& out) {
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
  out.samples = ring;
  JumpFinder finder{arm, wrist, loop, out};
  for (int k = 0; k < ring; ++k) finder.look(k, ring, spacing);
  if (out.samples == ring) return;
  for (int k = ring; k < out.samples; ++k) {
    double& psi = out.ring[static_cast<std::size_t>(k)].psi;
    psi -= 2.0 * kPi * std::floor(psi / (2.0 * kPi));
  }
  std::sort(out.ring.begin(), out.ring.begin() + out.samples,
            [](const RingSample& a, const RingSample& b) { return a.psi < b.psi; });
}

void scan_loop(const ArmModel& arm, const Posture& start, const Vec3& wrist, int index, int ring, FeasibleSet& out) {
  const SelfMotionLoop& loop = out.motion.loops[static_cast<std::size_t>(index)];
  Explorer explorer{arm, wrist, loop, out};
  sample_ring(arm, wrist, loop, ring, out);
  std::array<Crossing, 2 * FeasibleSet::kMaxArcs> crossings;
  int count = 0;
  const auto add = [&crossings, &count](double psi, bool enters) {
    if (count < static_cast<int>(crossings.size())) crossings[static_cast<std::size_t>(count++)] = {psi, enters};
  };
  const int last = out.samples - 1;
  const double hidden = kNarrow * FeasibleSet::kRing / ring;
  for (int k = 0; k <= last; ++k) {
    const RingSample &s0 = out.ring[static_cast<std::size_t>(k > 0 ? k - 1 : last)],
                     &s1 = out.ring[static_cast<std::size_t>(k)],
                     &s2 = out.ring[static_cast<std::size_t>(k < last ? k + 1 : 0)];
    const double m0 = slack(s0), m1 = slack(s1), m2 = slack(s2);
    const double before = s0.psi - (k > 0 ? 0.0 : 2.0 * kPi), psi = s1.psi,
                 after = s2.psi + (k < last ? 0.0 : 2.0 * kPi);
    const bool all_in = m0 >= 0.0 && m1 >= 0.0 && m2 >= 0.0, all_out = m0 < 0.0 && m1 < 0.0 && m2 < 0.0;
    const bool narrow_arc = all_out && m1 >= m0 && m1 > m2 && m1 > -hidden;
    const bool narrow_gap = all_in && m1 <= m0 && m1 < m2 && m1 < hidden;
    if (narrow_arc || narrow_gap) {
      double value = 0.0;
      const double top = explorer.extremum(before, after, narrow_arc ? 1.0 : -1.0, s1.opening, value);
      if (narrow_arc == (value >= 0.0)) {
        if (narrow_arc) {
          add(explorer.edge(top, before, value, m0, s1.opening), true);
          add(explorer.edge(top, after, value, m2, s1.opening), false);
        } else {
          add(explorer.edge(before, top, m0, value, s1.opening), false);
          add(explorer.edge(after, top, m2, value, s1.opening), true);
        }
      }
    }
    if (m1 >= 0.0 && m2 < 0.0) add(explorer.edge(psi, after, m1, m2, s1.opening), false);
    if (m1 < 0.0 && m2 >= 0.0) add(explorer.edge(after, psi, m2, m1, s2.opening), true);
  }
  std::sort(crossings.begin(), crossings.begin() + count,
            [](const Crossing& a, const Crossing& b) { return a.psi < b.psi; });
  const int first = out.count;
  connect(crossings, count, slack(out.ring[0]) >= 0.0, index, out);
  find_nearest(start, first, out);
}

}  // namespace

void sample_loop(const ArmModel& arm, const Vec3& wrist, const SelfMotionLoop& loop, double psi,
                 RingSample& s) noexcept {
  s.psi = psi;
  s.exists = loop_posture(arm, wrist, loop, psi, s.opening, s.posture);
  if (s.exists) s.margin = limit_margin(arm.limits, s.posture);
}

void find_feasible_arcs(const ArmModel& arm, const Posture& start, const Vec3& wrist, FeasibleSet& out) noexcept {
  find_self_motion(arm, wrist, out.motion);
  out.count = 0;
  out.best = LimitMargin{-1e3, 0, false};
  for (int i = 0; i < out.motion.count; ++i) scan_loop(arm, start, wrist, i, FeasibleSet::kRing, out);
  if (out.count > 0) return;
  for (int i = 0; i < out.motion.count; ++i) scan_loop(arm, start, wrist, i, FeasibleSet::kFineRing, out);
}

}  // namespace glenoid
