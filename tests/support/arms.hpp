#pragma once

#include "glenoid/arm_model.hpp"

namespace glenoid::test {

inline constexpr double kDegree = kPi / 180.0;

/// (theta, eta, zeta, phi) or (theta, eta, tau, phi) from degrees.
inline Vec4 degrees(double first, double second, double third, double fourth) {
  return Vec4(first, second, third, fourth) * kDegree;
}

/// The default subject (1.75 m, 75 kg, male) with the default limits.
ArmModel default_arm(const RhythmSettings& rhythm = {}, bool moving_shoulder = true);

}  // namespace glenoid::test
