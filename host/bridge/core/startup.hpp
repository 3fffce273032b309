#pragma once

// The objects a drive is given before it may move, in the order CiA 301 asks for.

#include <cstdint>
#include <string_view>
#include <vector>

#include "host/bridge/core/settings.hpp"

namespace glenoid::bridge {

inline constexpr std::uint16_t kHeartbeatConsumer = 0x1016;

/// One access to a drive's dictionary.
struct StartupStep {
  enum class Kind : std::uint8_t {
    Check,           ///< read, compare under `mask`
    Write,           ///< write, read back, compare under `mask`
    WriteIfPresent,  ///< as Write; an object that does not exist is passed over
    WriteOnly        ///< written without read-back: a step on the way, its final value is verified later
  };
  Kind kind = Kind::Write;
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
  std::uint8_t bytes = 4;
  std::uint32_t value = 0;
  std::uint32_t mask = 0xFFFF'FFFF;
  std::string_view name;
};

/// Reads that tell whether this is the drive of the configuration: 1000h, 1018h, 6502h.
[[nodiscard]] std::vector<StartupStep> identity_steps(const JointSettings& joint);

/// Writes in pre-operational: heartbeat both ways, reactions to loss and faults, windows and limits, period, PDOs, mode.
/// @throws std::invalid_argument limits or windows that do not fit the objects.
[[nodiscard]] std::vector<StartupStep> configuration_steps(const Settings& settings, const JointSettings& joint);

}  // namespace glenoid::bridge
