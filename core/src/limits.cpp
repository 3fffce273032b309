#include "glenoid/limits.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "problems.hpp"

namespace glenoid {
namespace {

/// atan2 in (-pi, pi]: a signed zero in y must not turn pi into -pi.
double angle_of(double y, double x) noexcept {
  const double angle = std::atan2(y, x);
  return angle == -kPi ? kPi : angle;
}

struct RangeDistance {
  double below;  ///< to the lower limit, negative outside
  double above;  ///< to the upper limit
};

RangeDistance distance(double angle, double lower, double upper) noexcept { return {angle - lower, upper - angle}; }

/// The same for an angle that is only known modulo 2 pi: taken nearest to the middle of the range.
RangeDistance circular_distance(double angle, double lower, double upper) noexcept {
  const double middle = 0.5 * (lower + upper);
  return distance(middle + std::remainder(angle - middle, 2.0 * kPi), lower, upper);
}

}  // namespace

Vec4 limited_angles(const Posture& posture) noexcept {
  const Mat3& R = posture.R_TU;
  const double sin_theta = std::hypot(R(0, 2), R(1, 2));
  Vec4 angles;
  angles[kLimitTheta] = std::atan2(sin_theta, R(2, 2));
  angles[kLimitEta] = sin_theta == 0.0 ? 0.0 : angle_of(R(0, 2), -R(1, 2));
  angles[kLimitTau] = angle_of(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1));
  angles[kLimitPhi] = posture.phi;
  return angles;
}

LimitMargin limit_margin(const JointLimits& limits, const Posture& posture) noexcept {
  const Vec4 angles = limited_angles(posture);
  LimitMargin least;
  least.margin_rad = std::numeric_limits<double>::infinity();
  if (!angles.allFinite()) {
    least.margin_rad = std::numeric_limits<double>::quiet_NaN();
    return least;
  }
  for (int k = 0; k < 4; ++k) {
    if (k == kLimitEta && angles[kLimitTheta] < kEtaLimitMinElevation) continue;
    const bool circular = k == kLimitEta || k == kLimitTau;
    const RangeDistance d = circular ? circular_distance(angles[k], limits.lower[k], limits.upper[k])
                                     : distance(angles[k], limits.lower[k], limits.upper[k]);
    const double nearest = std::fmin(d.below, d.above);
    if (nearest < least.margin_rad) least = {nearest, k, d.above < d.below};
  }
  return least;
}

void validate(const JointLimits& limits) {
  constexpr std::array<const char*, 4> kNames = {"theta", "eta", "eta+zeta", "phi"};
  constexpr std::array<double, 4> kLowest = {0.0, -2.0 * kPi, -2.0 * kPi, 0.0};
  constexpr std::array<double, 4> kHighest = {kPi, 2.0 * kPi, 2.0 * kPi, kPi};
  Problems problems;
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const std::string lower = "limits.lower[" + std::string(kNames[k]) + "]";
    const std::string upper = "limits.upper[" + std::string(kNames[k]) + "]";
    problems.require_range(lower, limits.lower[i], kLowest[k], kHighest[k], "rad");
    problems.require_range(upper, limits.upper[i], kLowest[k], kHighest[k], "rad");
    const double width = limits.upper[i] - limits.lower[i];
    if (!std::isfinite(width)) continue;
    problems.require(width > 0.0, lower, limits.lower[i], "rad", "must be below " + upper);
    // A whole turn given in degrees may exceed 2 pi by rounding.
    problems.require(width <= 2.0 * kPi * (1.0 + 1e-12), upper, limits.upper[i], "rad",
                     "must be at most 2 pi above " + lower);
  }
  problems.throw_if_any();
}

}  // namespace glenoid
