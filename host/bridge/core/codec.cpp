#include "host/bridge/core/codec.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "host/bridge/core/bytes.hpp"
#include "host/bridge/core/pdo_table.hpp"

namespace glenoid::bridge {
namespace {

can::Frame frame_of(const Pdo& pdo, std::uint8_t node) noexcept {
  can::Frame frame;
  frame.id = pdo.cob_id + node;
  frame.size = pdo.bytes();
  return frame;
}

bool fits(const can::Frame& frame, const Pdo& pdo) noexcept {
  return frame.size == pdo.bytes() && !frame.extended && !frame.remote && !frame.error;
}

/// First byte of entry `k`: the sum of what stands before it.
consteval std::size_t offset(const Pdo& pdo, std::size_t k) {
  std::size_t bits = 0;
  for (std::size_t i = 0; i < k; ++i) bits += pdo.entries[i].bits;
  return bits / 8;
}

constexpr std::size_t kControlword = offset(kRpdo1, 0);
constexpr std::size_t kTarget = offset(kRpdo1, 1);
constexpr std::size_t kStatusword = offset(kTpdo1, 0);
constexpr std::size_t kPosition = offset(kTpdo1, 1);
constexpr std::size_t kTorque = offset(kTpdo1, 2);
constexpr std::size_t kVelocity = offset(kTpdo2, 0);
constexpr std::size_t kErrorCode = offset(kTpdo2, 1);

}  // namespace

can::Frame encode(std::uint8_t node, const Rpdo1& value) noexcept {
  can::Frame frame = frame_of(kRpdo1, node);
  put_u16(frame, kControlword, value.controlword);
  put_u32(frame, kTarget, static_cast<std::uint32_t>(value.target_position));
  return frame;
}

can::Frame encode(std::uint8_t node, const Tpdo1& value) noexcept {
  can::Frame frame = frame_of(kTpdo1, node);
  put_u16(frame, kStatusword, value.statusword);
  put_u32(frame, kPosition, static_cast<std::uint32_t>(value.position_actual));
  put_u16(frame, kTorque, static_cast<std::uint16_t>(value.torque_actual));
  return frame;
}

can::Frame encode(std::uint8_t node, const Tpdo2& value) noexcept {
  can::Frame frame = frame_of(kTpdo2, node);
  put_u32(frame, kVelocity, static_cast<std::uint32_t>(value.velocity_actual));
  put_u16(frame, kErrorCode, value.error_code);
  return frame;
}

std::optional<Rpdo1> decode_rpdo1(const can::Frame& frame) noexcept {
  if (!fits(frame, kRpdo1)) return std::nullopt;
  return Rpdo1{get_u16(frame, kControlword), static_cast<std::int32_t>(get_u32(frame, kTarget))};
}

std::optional<Tpdo1> decode_tpdo1(const can::Frame& frame) noexcept {
  if (!fits(frame, kTpdo1)) return std::nullopt;
  return Tpdo1{get_u16(frame, kStatusword), static_cast<std::int32_t>(get_u32(frame, kPosition)),
               static_cast<std::int16_t>(get_u16(frame, kTorque))};
}

std::optional<Tpdo2> decode_tpdo2(const can::Frame& frame) noexcept {
  if (!fits(frame, kTpdo2)) return std::nullopt;
  return Tpdo2{static_cast<std::int32_t>(get_u32(frame, kVelocity)), get_u16(frame, kErrorCode)};
}

Scale::Scale(const JointSettings& joint) noexcept
    : counts_per_rad_(joint.sign * joint.gear_ratio * joint.encoder_counts_per_turn / (2.0 * std::numbers::pi)),
      offset_rad_(joint.offset_rad) {}

std::optional<std::int32_t> Scale::counts(double position_rad) const noexcept {
  const double exact = std::round((position_rad - offset_rad_) * counts_per_rad_);
  // Written so that NaN fails.
  if (!(exact >= std::numeric_limits<std::int32_t>::min() && exact <= std::numeric_limits<std::int32_t>::max()))
    return std::nullopt;
  return static_cast<std::int32_t>(exact);
}

double Scale::position_rad(std::int32_t counts) const noexcept { return offset_rad_ + counts / counts_per_rad_; }

std::optional<std::uint32_t> Scale::window_counts(double distance_rad) const noexcept {
  const double exact = std::ceil(std::abs(distance_rad * counts_per_rad_));
  if (!(exact <= std::numeric_limits<std::uint32_t>::max())) return std::nullopt;
  return static_cast<std::uint32_t>(exact);
}

}  // namespace glenoid::bridge
