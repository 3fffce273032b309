#include <cmath>

#include "glenoid/kinematics.hpp"
#include "self_motion.hpp"

namespace glenoid {
namespace {

constexpr int kRing = 144;
constexpr int kHalvings = 40;  // 2.5 deg to 4e-14 rad

/// Swivel of a loop posture minus the wanted one, in (-pi, pi].
struct SwivelError {
  const ArmModel& arm;
  const Vec3& wrist;
  const SelfMotionLoop& loop;
  double wanted;

  bool operator()(double psi, double& opening, double& error, Posture& posture) const {
    if (!loop_posture(arm, wrist, loop, psi, opening, posture)) return false;
    error = std::remainder(swivel_angle(forward_kinematics(arm, posture)) - wanted, 2.0 * kPi);
    return true;
  }
};

void add_solution(const Posture& p, IkSolutions& out) {
  for (int i = 0; i < out.count; ++i) {
    const Posture& other = out.postures[static_cast<std::size_t>(i)];
    if ((other.R_TU - p.R_TU).norm() + std::abs(other.phi - p.phi) < 1e-8) return;
  }
  if (out.count < kMaxIkSolutions) out.postures[static_cast<std::size_t>(out.count++)] = p;
}

/// Root of the swivel error between two angles of opposite sign (Illinois with bisection).
void add_root(const SwivelError& f, double a, double b, double fa, double fb, double opening, IkSolutions& out) {
  Posture p;
  double e = 0.0;
  for (int it = 0; it < 80; ++it) {
    double psi = a - fa * (b - a) / (fb - fa);
    if (it % 4 == 3) psi = 0.5 * (a + b);
    if (!f(psi, opening, e, p)) return;
    if (std::abs(e) < 1e-15 || std::abs(b - a) < 1e-15) break;
    if ((e > 0.0) == (fb > 0.0)) {
      b = psi, fb = e, fa *= it % 4 == 1 ? 0.5 : 1.0;
    } else {
      a = psi, fa = e, fb *= it % 4 == 1 ? 0.5 : 1.0;
    }
  }
  if (std::abs(e) < 1e-9) add_solution(p, out);
}

bool changes_sign(double fa, double fb) { return (fa > 0.0) != (fb > 0.0) && std::abs(fa - fb) <= kPi; }

/// Roots between two angles. Next to a straight elbow the swivel turns half round within an angle of the elbow's flexion: such
/// an interval is halved until the turn is resolved.
void add_roots(const SwivelError& f, double a, double b, double fa, double fb, double opening, int halvings,
               IkSolutions& out) {
  constexpr double kFastTurn = 0.5;  // rad; elsewhere the swivel follows psi, by 2.5 deg a sample
  if (halvings > 0 && std::abs(std::remainder(fb - fa, 2.0 * kPi)) > kFastTurn) {
    const double middle = 0.5 * (a + b);
    Posture p;
    double e = 0.0, there = opening;
    if (!f(middle, there, e, p)) return;
    add_roots(f, a, middle, fa, e, opening, halvings - 1, out);
    add_roots(f, middle, b, e, fb, there, halvings - 1, out);
  } else if (fa == 0.0 || changes_sign(fa, fb)) {
    add_root(f, a, b, fa, fb, opening, out);
  }
}

/// Two roots may hide between samples where the error dips towards zero without changing sign.
void add_hidden_pair(const SwivelError& f, double a, double b, double fa, double fb, double opening, IkSolutions& out) {
  const double sign = fa > 0.0 ? 1.0 : -1.0;
  double lo = a, hi = b, e = 0.0, e2 = 0.0;
  Posture p;
  for (int it = 0; it < 60 && hi - lo > 1e-9; ++it) {
    const double c = lo + 0.382 * (hi - lo), d = lo + 0.618 * (hi - lo);
    if (!f(c, opening, e, p) || !f(d, opening, e2, p)) return;
    if (sign * e <= 0.0 || sign * e2 <= 0.0) {
      const double middle = sign * e <= 0.0 ? c : d, value = sign * e <= 0.0 ? e : e2;
      add_root(f, a, middle, fa, value, opening, out);
      add_root(f, middle, b, value, fb, opening, out);
      return;
    }
    (sign * e < sign * e2 ? hi : lo) = sign * e < sign * e2 ? d : c;
  }
}

}  // namespace

Status inverse_kinematics(const ArmModel& arm, const Vec3& wrist, double swivel_rad, IkSolutions& out) noexcept {
  out.count = 0;
  out.reach_margin_m = 0.0;
  if (!wrist.allFinite() || !std::isfinite(swivel_rad)) return Status::NotFinite;
  SelfMotion motion;
  find_self_motion(arm, wrist, motion);
  out.reach_margin_m = motion.reach_margin_m;
  for (int l = 0; l < motion.count; ++l) {
    const SwivelError f{arm, wrist, motion.loops[static_cast<std::size_t>(l)], swivel_rad};
    double error[kRing], openings[kRing];
    bool valid[kRing];
    double opening = 0.0;
    Posture p;
    for (int k = 0; k < kRing; ++k) {
      valid[k] = f(2.0 * kPi * k / kRing, opening, error[k], p);
      openings[k] = opening;
      if (!valid[k]) opening = 0.0;
    }
    const auto at = [](int k) { return (k + kRing) % kRing; };
    for (int k = 0; k < kRing; ++k) {
      const int j = at(k + 1), i = at(k - 1);
      const double psi = 2.0 * kPi * k / kRing, step = 2.0 * kPi / kRing;
      if (!valid[k] || !valid[j]) continue;
      add_roots(f, psi, psi + step, error[k], error[j], openings[k], kHalvings, out);
      if (!changes_sign(error[k], error[j]) && valid[i] && std::abs(error[k]) <= std::abs(error[i]) &&
          std::abs(error[k]) < std::abs(error[j]) && std::abs(error[k]) < 0.5 && (error[i] > 0.0) == (error[k] > 0.0)) {
        add_hidden_pair(f, psi - step, psi + step, error[i], error[j], openings[k], out);
      }
    }
  }
  return out.count > 0 ? Status::Ok : Status::TargetUnreachable;
}

}  // namespace glenoid
