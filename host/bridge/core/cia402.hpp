#pragma once

// CiA 402: what a statusword says and which controlword comes next.

#include <cstdint>
#include <string_view>

#include "host/bridge/core/messages.hpp"

namespace glenoid::bridge::cia402 {

inline constexpr std::uint16_t kDisableVoltage = 0x00;
inline constexpr std::uint16_t kQuickStop = 0x02;
inline constexpr std::uint16_t kShutdown = 0x06;
inline constexpr std::uint16_t kSwitchOn = 0x07;
inline constexpr std::uint16_t kEnableOperation = 0x0F;
inline constexpr std::uint16_t kFaultReset = 0x80;  // rising edge

inline constexpr std::uint16_t kFollowsTarget = 1U << 12;   // in CSP
inline constexpr std::uint16_t kFollowingError = 1U << 13;  // in CSP
inline constexpr std::uint16_t kInternalLimit = 1U << 11;

inline constexpr std::int8_t kModeCsp = 8;               // 6060h
inline constexpr std::uint32_t kSupportsCsp = 1U << 7;   // 6502h
inline constexpr std::uint32_t kDeviceProfile = 0x0192;  // low word of 1000h: 402

[[nodiscard]] DriveState decode(std::uint16_t statusword) noexcept;

/// One step from `state` towards operation enabled. `enable` false stays in switched on.
/// In a fault the answer is disable voltage: a reset is a separate request.
[[nodiscard]] std::uint16_t towards_enabled(DriveState state, bool enable) noexcept;

[[nodiscard]] std::string_view words(DriveState state) noexcept;

}  // namespace glenoid::bridge::cia402
