#include "host/drives/power.hpp"

namespace glenoid::drives {
namespace {

constexpr unsigned kVoltage = 0x02, kNoQuickStop = 0x04, kSwitchOn = 0x01, kOperate = 0x08, kResetFault = 0x80;

enum class Command : std::uint8_t { DisableVoltage, QuickStop, Shutdown, SwitchOn, EnableOperation };

Command decode(std::uint16_t word) noexcept {
  if ((word & kVoltage) == 0) return Command::DisableVoltage;
  if ((word & kNoQuickStop) == 0) return Command::QuickStop;
  if ((word & kSwitchOn) == 0) return Command::Shutdown;
  return (word & kOperate) == 0 ? Command::SwitchOn : Command::EnableOperation;
}

/// 605Ah: 1, 5 profile ramp; 2, 6 quick-stop ramp; 3, 7 current limit; from 5 on the drive stays in quick stop.
StopRamp quick_stop_ramp(std::int64_t option) noexcept {
  switch (option) {
    case 1:
    case 5:
      return StopRamp::Profile;
    case 2:
    case 6:
      return StopRamp::QuickStop;
    case 3:
    case 7:
      return StopRamp::CurrentLimit;
    default:
      return StopRamp::Off;
  }
}

}  // namespace

std::uint16_t Power::status_bits() const noexcept {
  switch (state_) {
    case PowerState::NotReady:
      return 0x00;
    case PowerState::SwitchOnDisabled:
      return 0x40;
    case PowerState::ReadyToSwitchOn:
      return 0x21;
    case PowerState::SwitchedOn:
      return 0x23;
    case PowerState::OperationEnabled:
      return 0x27;
    case PowerState::QuickStopActive:
      return 0x07;
    case PowerState::FaultReaction:
      return 0x0F;
    case PowerState::Fault:
      return 0x08;
  }
  return 0;
}

bool Power::powered() const noexcept {
  return state_ == PowerState::OperationEnabled || state_ == PowerState::QuickStopActive ||
         state_ == PowerState::FaultReaction;
}

void Power::restart() noexcept { *this = Power{}; }

void Power::ready() noexcept {
  if (state_ == PowerState::NotReady) state_ = PowerState::SwitchOnDisabled;
}

PowerEffect Power::go(PowerState state) noexcept {
  const bool was_powered = powered();
  state_ = state;
  stopping_ = false;
  enabling_ = false;
  return was_powered && !powered() ? PowerEffect::Disable : PowerEffect::None;
}

PowerEffect Power::begin_stop(PowerState state, StopRamp ramp, PowerState after, bool stay) noexcept {
  if (ramp == StopRamp::Off) return go(after);
  state_ = state;
  ramp_ = ramp;
  after_stop_ = after;
  stopping_ = true;
  stay_ = stay;
  enabling_ = false;
  return PowerEffect::Stop;
}

PowerEffect Power::command(std::uint16_t controlword, const StopOptions& options) noexcept {
  const bool reset = (controlword & kResetFault) != 0 && (last_ & kResetFault) == 0;
  last_ = controlword;
  const Command wanted = decode(controlword);
  switch (state_) {
    case PowerState::SwitchOnDisabled:
      return wanted == Command::Shutdown ? go(PowerState::ReadyToSwitchOn) : PowerEffect::None;
    case PowerState::ReadyToSwitchOn:
    case PowerState::SwitchedOn:
      if (wanted == Command::DisableVoltage || wanted == Command::QuickStop) return go(PowerState::SwitchOnDisabled);
      if (wanted == Command::Shutdown) return go(PowerState::ReadyToSwitchOn);
      state_ = PowerState::SwitchedOn;
      enabling_ = wanted == Command::EnableOperation;
      return PowerEffect::None;
    case PowerState::OperationEnabled:
      return leave_operation(controlword, options);
    case PowerState::QuickStopActive:
      if (wanted == Command::DisableVoltage) return go(PowerState::SwitchOnDisabled);
      if (wanted != Command::EnableOperation || !stay_) return PowerEffect::None;
      go(PowerState::OperationEnabled);
      return PowerEffect::Enable;
    case PowerState::Fault:
      return reset ? go(PowerState::SwitchOnDisabled) : PowerEffect::None;
    case PowerState::NotReady:
    case PowerState::FaultReaction:
      return PowerEffect::None;
  }
  return PowerEffect::None;
}

PowerEffect Power::leave_operation(std::uint16_t controlword, const StopOptions& options) noexcept {
  const auto ramp = [](std::int64_t option) { return option == 1 ? StopRamp::Profile : StopRamp::Off; };
  switch (decode(controlword)) {
    case Command::DisableVoltage:
      return go(PowerState::SwitchOnDisabled);
    case Command::QuickStop:
      return quick_stop(options);
    case Command::Shutdown:
      if (stopping_) return PowerEffect::None;
      return begin_stop(state_, ramp(options.shutdown), PowerState::ReadyToSwitchOn, false);
    case Command::SwitchOn:
      if (stopping_) return PowerEffect::None;
      return begin_stop(state_, ramp(options.disable_operation), PowerState::SwitchedOn, false);
    case Command::EnableOperation:
      break;
  }
  if (!stopping_) return PowerEffect::None;
  stopping_ = false;  // wanted again before the ramp had ended
  return PowerEffect::Enable;
}

PowerEffect Power::enabled() noexcept {
  if (!enabling_) return PowerEffect::None;
  go(PowerState::OperationEnabled);
  return PowerEffect::Enable;
}

PowerEffect Power::quick_stop(const StopOptions& options) noexcept {
  if (state_ == PowerState::ReadyToSwitchOn || state_ == PowerState::SwitchedOn)
    return go(PowerState::SwitchOnDisabled);
  if (state_ != PowerState::OperationEnabled) return PowerEffect::None;
  return begin_stop(PowerState::QuickStopActive, quick_stop_ramp(options.quick_stop), PowerState::SwitchOnDisabled,
                    options.quick_stop >= 5);
}

PowerEffect Power::disable_voltage() noexcept {
  if (state_ == PowerState::NotReady || faulty()) return PowerEffect::None;
  return go(PowerState::SwitchOnDisabled);
}

PowerEffect Power::fault(const StopOptions& options) noexcept {
  if (faulty()) return PowerEffect::None;
  if (!powered()) return go(PowerState::Fault);
  const StopRamp ramp = options.fault_reaction == 0 ? StopRamp::Off : quick_stop_ramp(options.fault_reaction);
  return begin_stop(PowerState::FaultReaction, ramp, PowerState::Fault, false);
}

PowerEffect Power::settled() noexcept {
  if (!stopping_) return PowerEffect::None;
  stopping_ = false;
  if (state_ == PowerState::QuickStopActive && stay_) return PowerEffect::None;
  return go(after_stop_);
}

}  // namespace glenoid::drives
