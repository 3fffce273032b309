#pragma once

#include <string>

#include "glenoid/types.hpp"

namespace glenoid {

/// The four limited quantities: elevation theta, plane eta, axial rotation tau = eta + zeta, elbow flexion phi.
enum LimitedAngle : int { kLimitTheta = 0, kLimitEta = 1, kLimitTau = 2, kLimitPhi = 3 };

/// Below this elevation eta is undefined and its limit does not apply, rad (5 deg).
inline constexpr double kEtaLimitMinElevation = 5.0 * kPi / 180.0;

/// Joint limits of a person, rad, on (theta, eta, eta + zeta, phi); docs/equations.md, L1.
struct JointLimits {
  Vec4 lower = Vec4(0.0, -135.0, -90.0, 0.0) * (kPi / 180.0);
  Vec4 upper = Vec4(150.0, 45.0, 80.0, 145.0) * (kPi / 180.0);
};

/// How far a posture is inside the limits, and which limit is nearest.
struct LimitMargin {
  double margin_rad = 0.0;  ///< least signed distance; negative outside
  int angle = 0;            ///< LimitedAngle of the least distance
  bool at_upper = false;
};

/// (theta, eta, tau, phi) of a posture. eta is reported in (-pi, pi], tau likewise; eta is 0 where undefined.
Vec4 limited_angles(const Posture& posture) noexcept;

/// Signed margin of a posture; angles are compared modulo 2 pi about the middle of each range.
LimitMargin limit_margin(const JointLimits& limits, const Posture& posture) noexcept;

/// @throws std::invalid_argument naming variable, value, unit and rule: finite, lower < upper, theta within 0..180 deg,
///         phi within 0..180 deg, ranges of eta and tau at most 360 deg and within -360..360 deg.
void validate(const JointLimits& limits);

}  // namespace glenoid
