#pragma once

#include <cstddef>
#include <cstdint>

#include "host/bridge/core/settings.hpp"

namespace glenoid::bridge {

/// What one joint may do.
struct JointLimits {
  double lower_rad = 0.0;
  double upper_rad = 0.0;
  double velocity_rad_per_s = 0.0;
  double acceleration_rad_per_s2 = 0.0;
  double blend_rad_per_s = 0.0;
};

/// Bits of what had to be changed.
enum Limited : std::uint8_t { kWithinLimits = 0, kPositionLimited = 1, kVelocityLimited = 2, kAccelerationLimited = 4 };

/// The command of one joint, moved by one period at a time and never faster than it may.
///
/// Laws, for any sequence of finite targets, starting at rest:
///   - inside [lower, upper] it never leaves them; outside it never moves further out once it can turn;
///   - |velocity| <= velocity limit, |acceleration| <= acceleration limit;
///   - a target that can be reached within the limits is reached exactly in that period.
class CommandLimiter {
 public:
  CommandLimiter() = default;
  CommandLimiter(const JointLimits& limits, double period_s) noexcept : limits_(limits), period_s_(period_s) {}

  /// Starts at rest.
  void reset(double position_rad) noexcept {
    position_rad_ = position_rad;
    velocity_rad_per_s_ = 0.0;
  }

  /// One period towards a target that moves at `target_velocity`.
  /// @param blending  closes the distance no faster than the blend speed
  /// @return bits of Limited
  std::uint8_t follow(double target_rad, double target_velocity_rad_per_s, bool blending) noexcept;

  /// One period of coming to rest with the acceleration limit.
  void brake() noexcept;

  [[nodiscard]] double position_rad() const noexcept { return position_rad_; }
  [[nodiscard]] double velocity_rad_per_s() const noexcept { return velocity_rad_per_s_; }
  [[nodiscard]] bool at_rest() const noexcept { return velocity_rad_per_s_ == 0.0; }

 private:
  [[nodiscard]] double braking_speed(double distance_rad) const noexcept;
  std::uint8_t move(double wanted_rad_per_s) noexcept;

  JointLimits limits_{};
  double period_s_ = 0.002;
  double position_rad_ = 0.0;
  double velocity_rad_per_s_ = 0.0;
};

}  // namespace glenoid::bridge
