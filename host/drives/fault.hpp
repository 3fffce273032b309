#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace glenoid::drives {

/// What can be made to go wrong. `amount` means, by kind:
enum class FaultKind : std::uint8_t {
  None = 0,          ///< ends the fault that runs
  Drop = 1,          ///< frames lost in both directions, per mille
  Delay = 2,         ///< every frame sent comes later, us
  Stall = 3,         ///< the communication processor hangs (no frame in or out, the motor finishes its last target); -
  Emergency = 4,     ///< the drive reports this EMCY code and goes through its fault reaction; 0 = 2310h over-current
  Reboot = 5,        ///< power-up from the beginning; -
  StuckEncoder = 6,  ///< the position sensor repeats its last value; -
  BusOff = 7,        ///< the controller is off the bus and recovers after the duration; -
  Jam = 8,           ///< the joint is blocked mechanically; -
};
inline constexpr int kFaultKinds = 9;

/// A fault to inject. `duration_ms` 0: until it is ended by `None` or, for Emergency and Reboot, at once.
struct Fault {
  FaultKind kind = FaultKind::None;
  std::uint32_t amount = 0;
  std::uint32_t duration_ms = 0;
};

/// Word of the command line and of reports: "drop", "bus-off", ...
std::string_view name(FaultKind kind) noexcept;

/// The kind a word names.
std::optional<FaultKind> fault_kind(std::string_view word) noexcept;

}  // namespace glenoid::drives
