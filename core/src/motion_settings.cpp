#include "motion_settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "glenoid/kinematics.hpp"
#include "problems.hpp"

namespace glenoid {
namespace {

constexpr double kStartTolerance = 1e-9;  // rad

}  // namespace

void validate(const MotionSettings& s, double start_time) {
  Problems problems;
  problems.require_range("motion.duration", s.duration_s, kLeastDuration, kMostDuration, "s");
  problems.require_range("swivel.prescribed", s.swivel_prescribed_rad, -2.0 * kPi, 2.0 * kPi, "rad");
  problems.require(std::isfinite(start_time), "start time", start_time, "s", "must be finite");
  problems.require(s.axial_factor == 0.0 || (s.axial_factor >= 1.0 && s.axial_factor <= 5.0), "metric.axialFactor",
                   s.axial_factor, "1", "must be in 1..5, or 0 (3 with HumanPrior, else 1)");
  const int mode = static_cast<int>(s.swivel_mode);
  problems.require(mode >= 1 && mode <= 3, "swivel.mode", mode, "",
                   "must be 1 (MinimumEnergy), 2 (Prescribed) or 3 (HumanPrior)");
  const int law = static_cast<int>(s.timing);
  problems.require(law >= 1 && law <= 3, "motion.timing", law, "", "must be 1, 2 or 3");
  if (s.shoulder_start_m) {
    for (int i = 0; i < 3; ++i) {
      problems.require_range("shoulder_start[" + std::to_string(i + 1) + "]", (*s.shoulder_start_m)[i], -2.0, 2.0, "m");
    }
  }
  static constexpr std::array<const char*, 4> kNames = {"theta", "eta", "zeta", "phi"};
  static constexpr std::array<double, 4> kLowest = {0.0, -2.0 * kPi, -4.0 * kPi, 0.0};
  static constexpr std::array<double, 4> kHighest = {kPi, 2.0 * kPi, 4.0 * kPi, kPi};
  for (int i = 0; i < 4; ++i) {
    const auto k = static_cast<std::size_t>(i);
    problems.require_range("start.q[" + std::to_string(i + 1) + "] (" + kNames[k] + ")", s.start_q[i], kLowest[k],
                           kHighest[k], "rad");
  }
  problems.throw_if_any();
}

void validate_start(const ArmModel& arm, const Vec4& q) {
  static constexpr std::array<const char*, 4> kNames = {"theta", "eta", "eta+zeta", "phi"};
  const LimitMargin m = limit_margin(arm.limits, posture_from_angles(q));
  Problems problems;
  if (m.margin_rad < -kStartTolerance) {
    const double value = m.angle == kLimitTau ? q[kEta] + q[kZeta] : q[m.angle == kLimitPhi ? kPhi : m.angle];
    const double limit = m.at_upper ? arm.limits.upper[m.angle] : arm.limits.lower[m.angle];
    problems.require(false, std::string("start.q: ") + kNames[static_cast<std::size_t>(m.angle)], value, "rad",
                     std::string("must not be ") + (m.at_upper ? "above" : "below") + " its limit " +
                         std::to_string(limit) + " rad");
  }
  problems.throw_if_any();
}

ArmModel build_arm(const MotionSettings& s, const ScaledArm& scaled) {
  Rhythm rhythm(s.rhythm, scaled.shoulder_distance_m);
  if (s.shoulder_start_m) {
    rhythm.anchor(posture_from_angles(s.start_q).R_TU.col(2), mirror_if(s.subject.left_arm, *s.shoulder_start_m));
  }
  ScaledArm inertias = scaled;
  apply_axial_factor(inertias, effective_axial_factor(s.axial_factor, s.swivel_mode));
  return make_arm_model(inertias, rhythm, s.limits, s.moving_shoulder);
}

bool is_valid(const MotionState& s) noexcept {
  const auto within = [](double v, double lower, double upper) { return v >= lower && v <= upper; };
  bool ok = within(s.duration_s, kLeastDuration, kMostDuration) &&
            within(s.next_duration_s, kLeastDuration, kMostDuration) && s.path.order >= 0 &&
            s.path.order <= kMaxPathOrder && s.rest_status >= 1 && s.rest_status <= 8 &&
            std::abs(static_cast<int>(s.exo_guide.branch)) == 1 && s.target.allFinite() &&
            s.refused_target.allFinite() && s.fade_w.allFinite() && s.fade_dw.allFinite();
  const Certificate& c = s.certificate;
  for (const double v :
       {s.move_time_s, s.stop_time_s, s.stop_duration_s, s.fade_duration_s, s.fade_share, s.fade_dphi, s.fade_ddphi,
        s.path.energy, c.newton_step_rad, c.gradient, c.spectral_tail, c.speed_variation, c.hand_error_m,
        c.transversality, c.rotation_angle_rad, c.limits.lambda, c.limits.worst.margin_rad}) {
    ok = ok && std::isfinite(v);
  }
  for (const Posture& p : s.path.nodes) ok = ok && p.R_TU.allFinite() && std::isfinite(p.phi);
  for (const auto& row : s.path.legendre)
    ok = ok && std::all_of(row.begin(), row.end(), [](double v) { return std::isfinite(v); });
  for (const Vec4& q : s.guide_q) ok = ok && q.allFinite();
  for (const double v : s.hand_clock.legendre) ok = ok && std::isfinite(v);
  for (const auto& q : s.exo_guide.shoulder_q)
    ok = ok && std::all_of(q.begin(), q.end(), [](double v) { return std::isfinite(v); });
  return ok;
}

}  // namespace glenoid
