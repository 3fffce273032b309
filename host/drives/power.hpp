#pragma once

#include <cstdint>

#include "host/drives/drive.hpp"

namespace glenoid::drives {

/// What a power state change asks the motion side to do.
enum class PowerEffect : std::uint8_t {
  None,
  Enable,   ///< close the position loop at the place where the joint stands
  Disable,  ///< power stage off at once
  Stop,     ///< slow down, then `settled`
};

/// How the drive stops; from the option codes.
enum class StopRamp : std::uint8_t { Off, Profile, QuickStop, CurrentLimit };

/// Option codes of CiA 402 as the dictionary has them.
struct StopOptions {
  std::int64_t quick_stop = 2;         ///< 605Ah
  std::int64_t shutdown = 0;           ///< 605Bh
  std::int64_t disable_operation = 1;  ///< 605Ch
  std::int64_t fault_reaction = 2;     ///< 605Eh
};

/// State machine of CiA 402: states, the transitions that controlwords ask for, and those that stops and faults cause.
class Power {
 public:
  [[nodiscard]] PowerState state() const noexcept { return state_; }
  /// State bits of 6041h: 0 to 3, 5 and 6.
  [[nodiscard]] std::uint16_t status_bits() const noexcept;
  /// The ramp of the stop that runs.
  [[nodiscard]] StopRamp ramp() const noexcept { return ramp_; }
  /// A stop runs that has not ended yet.
  [[nodiscard]] bool stopping() const noexcept { return stopping_; }
  /// A fault is reacted to or waits for its reset.
  [[nodiscard]] bool faulty() const noexcept {
    return state_ == PowerState::FaultReaction || state_ == PowerState::Fault;
  }
  /// The power stage drives the motor.
  [[nodiscard]] bool powered() const noexcept;

  /// Power-up.
  void restart() noexcept;
  /// Self-test passed: not ready becomes switch-on disabled.
  void ready() noexcept;
  /// A controlword became active. It may be the same as before: only the edge of bit 7 counts as an event.
  PowerEffect command(std::uint16_t controlword, const StopOptions& options) noexcept;
  /// The enable delay has passed.
  PowerEffect enabled() noexcept;
  /// Whether the drive waits for its enable delay.
  [[nodiscard]] bool enabling() const noexcept { return enabling_; }
  /// A quick stop that no controlword asked for (connection lost).
  PowerEffect quick_stop(const StopOptions& options) noexcept;
  /// As controlword "disable voltage".
  PowerEffect disable_voltage() noexcept;
  PowerEffect fault(const StopOptions& options) noexcept;
  /// The stop has ended: the joint stands still.
  PowerEffect settled() noexcept;

 private:
  PowerEffect begin_stop(PowerState state, StopRamp ramp, PowerState after, bool stay) noexcept;
  PowerEffect go(PowerState state) noexcept;
  PowerEffect leave_operation(std::uint16_t controlword, const StopOptions& options) noexcept;

  PowerState state_ = PowerState::NotReady;
  PowerState after_stop_ = PowerState::SwitchOnDisabled;
  StopRamp ramp_ = StopRamp::Off;
  bool stopping_ = false;
  bool stay_ = false;
  bool enabling_ = false;
  std::uint16_t last_ = 0;
};

}  // namespace glenoid::drives
