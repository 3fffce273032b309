#include "host/bridge/core/cia402.hpp"

#include <array>

namespace glenoid::bridge::cia402 {
namespace {

struct Pattern {
  std::uint16_t mask;
  std::uint16_t value;
  DriveState state;
};

// IEC 61800-7-201, statusword bits of the states.
constexpr std::array kPatterns = std::to_array<Pattern>({
    {0x4F, 0x00, DriveState::NotReady},
    {0x4F, 0x40, DriveState::SwitchOnDisabled},
    {0x6F, 0x21, DriveState::ReadyToSwitchOn},
    {0x6F, 0x23, DriveState::SwitchedOn},
    {0x6F, 0x27, DriveState::OperationEnabled},
    {0x6F, 0x07, DriveState::QuickStopActive},
    {0x4F, 0x0F, DriveState::FaultReaction},
    {0x4F, 0x08, DriveState::Fault},
});

}  // namespace

DriveState decode(std::uint16_t statusword) noexcept {
  for (const Pattern& pattern : kPatterns)
    if ((statusword & pattern.mask) == pattern.value) return pattern.state;
  return DriveState::Unknown;
}

std::uint16_t towards_enabled(DriveState state, bool enable) noexcept {
  switch (state) {
    case DriveState::SwitchOnDisabled:
      return kShutdown;
    case DriveState::ReadyToSwitchOn:
      return kSwitchOn;
    case DriveState::SwitchedOn:
      return enable ? kEnableOperation : kSwitchOn;
    case DriveState::OperationEnabled:
      return kEnableOperation;
    default:
      return kDisableVoltage;
  }
}

std::string_view words(DriveState state) noexcept {
  switch (state) {
    case DriveState::NotReady:
      return "not ready to switch on";
    case DriveState::SwitchOnDisabled:
      return "switch-on disabled";
    case DriveState::ReadyToSwitchOn:
      return "ready to switch on";
    case DriveState::SwitchedOn:
      return "switched on";
    case DriveState::OperationEnabled:
      return "operation enabled";
    case DriveState::QuickStopActive:
      return "quick stop active";
    case DriveState::FaultReaction:
      return "fault reaction active";
    case DriveState::Fault:
      return "fault";
    case DriveState::Unknown:
      break;
  }
  return "unknown";
}

}  // namespace glenoid::bridge::cia402
