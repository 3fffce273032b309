#include "host/bridge/core/limits.hpp"

#include <algorithm>
#include <cmath>

namespace glenoid::bridge {
namespace {

// Braking in whole periods needs up to 9/8 of the acceleration that the same path takes in continuous time: for a speed
// of (1 + r) a T, the last but one period loses a T (1 + r / 2 - r^2 / 2). 0.85 * 9 / 8 < 1.
constexpr double kBrakingShare = 0.85;

// Relative: rounding of the differences, not a change of the target.
constexpr double kSlack = 1e-9;

}  // namespace

/// Highest speed from which `distance` suffices to come to rest, this period's step included.
double CommandLimiter::braking_speed(double distance_rad) const noexcept {
  if (distance_rad <= 0.0) return 0.0;
  const double step = kBrakingShare * limits_.acceleration_rad_per_s2 * period_s_;
  const double smooth = 0.5 *
                        (std::sqrt(step * step + 8.0 * kBrakingShare * limits_.acceleration_rad_per_s2 * distance_rad) -
                         step);
  return std::min(smooth, distance_rad / period_s_);
}

/// Takes the speed nearest to the wanted one that every limit allows; where they disagree, acceleration has the last word.
std::uint8_t CommandLimiter::move(double wanted_rad_per_s) noexcept {
  std::uint8_t limited = kWithinLimits;
  const auto clamp = [&](double low, double high, std::uint8_t bit) {
    const double slack = kSlack * limits_.velocity_rad_per_s;
    if (wanted_rad_per_s < low - slack || wanted_rad_per_s > high + slack) {
      wanted_rad_per_s = std::clamp(wanted_rad_per_s, low, high);
      limited = static_cast<std::uint8_t>(limited | bit);
    }
  };
  clamp(-limits_.velocity_rad_per_s, limits_.velocity_rad_per_s, kVelocityLimited);
  clamp(-braking_speed(position_rad_ - limits_.lower_rad), braking_speed(limits_.upper_rad - position_rad_),
        kPositionLimited);
  const double change = limits_.acceleration_rad_per_s2 * period_s_;
  clamp(velocity_rad_per_s_ - change, velocity_rad_per_s_ + change, kAccelerationLimited);
  velocity_rad_per_s_ = wanted_rad_per_s;
  position_rad_ += wanted_rad_per_s * period_s_;
  return limited;
}

std::uint8_t CommandLimiter::follow(double target_rad, double target_velocity_rad_per_s, bool blending) noexcept {
  const double bounded = std::clamp(target_rad, std::min(limits_.lower_rad, position_rad_),
                                    std::max(limits_.upper_rad, position_rad_));
  const double distance = bounded - position_rad_;
  const double exact = distance / period_s_;
  const double change = limits_.acceleration_rad_per_s2 * period_s_;
  const double slack = kSlack * limits_.velocity_rad_per_s;
  const bool reachable = std::abs(exact) <= limits_.velocity_rad_per_s + slack &&
                         std::abs(exact - velocity_rad_per_s_) <= change + slack &&
                         exact <= braking_speed(limits_.upper_rad - position_rad_) + slack &&
                         exact >= -braking_speed(position_rad_ - limits_.lower_rad) - slack;
  const std::uint8_t outside = bounded != target_rad ? kPositionLimited : kWithinLimits;
  if (reachable &&
      std::abs(exact - target_velocity_rad_per_s) <= (blending ? std::min(limits_.blend_rad_per_s, change) : change)) {
    velocity_rad_per_s_ = exact;
    position_rad_ = bounded;
    return outside;
  }
  // Too far for one period: catch up with a target that moves on, at a relative speed from which it can still be met.
  const double target_velocity = bounded == target_rad ? target_velocity_rad_per_s : 0.0;
  const double ahead = distance - target_velocity * period_s_;
  const double most = blending ? limits_.blend_rad_per_s : limits_.velocity_rad_per_s;
  const double closing = std::copysign(std::min(braking_speed(std::abs(ahead)), most), ahead);
  return static_cast<std::uint8_t>(outside | move(target_velocity + closing));
}

void CommandLimiter::brake() noexcept {
  const double change = limits_.acceleration_rad_per_s2 * period_s_;
  const double lost = std::min(std::abs(velocity_rad_per_s_), change);
  move(velocity_rad_per_s_ - std::copysign(lost, velocity_rad_per_s_));
}

}  // namespace glenoid::bridge
