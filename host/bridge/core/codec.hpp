#pragma once

// Process data between frames and numbers, and joint angles between radians and counts.

#include <cstdint>
#include <optional>

#include "host/bridge/can/frame.hpp"
#include "host/bridge/core/settings.hpp"

namespace glenoid::bridge {

struct Rpdo1 {
  std::uint16_t controlword = 0;
  std::int32_t target_position = 0;
  friend bool operator==(const Rpdo1&, const Rpdo1&) = default;
};

struct Tpdo1 {
  std::uint16_t statusword = 0;
  std::int32_t position_actual = 0;
  std::int16_t torque_actual = 0;
  friend bool operator==(const Tpdo1&, const Tpdo1&) = default;
};

struct Tpdo2 {
  std::int32_t velocity_actual = 0;
  std::uint16_t error_code = 0;
  friend bool operator==(const Tpdo2&, const Tpdo2&) = default;
};

[[nodiscard]] can::Frame encode(std::uint8_t node, const Rpdo1& value) noexcept;
[[nodiscard]] can::Frame encode(std::uint8_t node, const Tpdo1& value) noexcept;
[[nodiscard]] can::Frame encode(std::uint8_t node, const Tpdo2& value) noexcept;

/// Empty where the frame is not this PDO: other size, extended, remote or error. The id is not looked at.
[[nodiscard]] std::optional<Rpdo1> decode_rpdo1(const can::Frame& frame) noexcept;
[[nodiscard]] std::optional<Tpdo1> decode_tpdo1(const can::Frame& frame) noexcept;
[[nodiscard]] std::optional<Tpdo2> decode_tpdo2(const can::Frame& frame) noexcept;

/// rad to counts and back for one joint.
class Scale {
 public:
  Scale() = default;
  explicit Scale(const JointSettings& joint) noexcept;

  /// Nearest count; empty where it is not finite or does not fit int32.
  [[nodiscard]] std::optional<std::int32_t> counts(double position_rad) const noexcept;
  [[nodiscard]] double position_rad(std::int32_t counts) const noexcept;
  /// Counts of a distance or a window, rounded up, without sign.
  [[nodiscard]] std::optional<std::uint32_t> window_counts(double distance_rad) const noexcept;
  [[nodiscard]] double counts_per_rad() const noexcept { return counts_per_rad_; }

 private:
  double counts_per_rad_ = 1.0;  ///< with the sign
  double offset_rad_ = 0.0;
};

}  // namespace glenoid::bridge
