#pragma once

// One simulated drive: a CANopen slave (CiA 301) with a motor behind it (CiA 402, cyclic synchronous position).

#include <cstdint>
#include <memory>

#include "host/bridge/can/frame.hpp"
#include "host/drives/fault.hpp"
#include "host/drives/load.hpp"
#include "host/drives/outbox.hpp"
#include "host/drives/profile.hpp"

namespace glenoid::drives {

/// States of CiA 301 as the heartbeat carries them.
enum class Nmt : std::uint8_t { Initialising = 0x00, Stopped = 0x04, Operational = 0x05, PreOperational = 0x7F };

/// States of CiA 402.
enum class PowerState : std::uint8_t {
  NotReady,
  SwitchOnDisabled,
  ReadyToSwitchOn,
  SwitchedOn,
  OperationEnabled,
  QuickStopActive,
  FaultReaction,
  Fault
};

/// Where a drive stands on the bus and how it begins.
struct Placement {
  std::uint8_t node = 1;      ///< 1..127
  double position_rad = 0.0;  ///< of the joint at power-up
  std::uint64_t seed = 1;     ///< of the frames that the fault "drop" loses
};

/// What a drive counted since it was made; a reboot does not clear it.
struct DriveCounters {
  std::uint64_t syncs = 0;          ///< received
  std::uint64_t missed_cycles = 0;  ///< SYNCs that should have come: gaps above 1.5 interpolation periods, while operational
  std::uint64_t answers_due = 0;        ///< synchronous TPDOs that a SYNC asked for
  std::uint64_t setpoints = 0;          ///< RPDOs taken over
  std::uint64_t missing_setpoints = 0;  ///< SYNCs in operation enabled before which no RPDO had come
  std::uint64_t bad_pdos = 0;           ///< too short or too long
  std::uint64_t emergencies = 0;        ///< EMCY frames other than "error reset"
  std::uint16_t last_emergency = 0;     ///< code of the last of them
  std::uint64_t reboots = 0;
  double worst_following_error_rad = 0.0;  ///< while operation was enabled or a quick stop held
};

/// What the world outside the bus may see: for reports, loads and tests.
struct DriveView {
  Nmt nmt = Nmt::Initialising;
  PowerState state = PowerState::NotReady;
  std::uint16_t statusword = 0;  ///< 6041h
  double demand_rad = 0.0;       ///< reference of the position controller
  double position_rad = 0.0;     ///< true, not the encoder's
  double velocity_rad_per_s = 0.0;
  double torque_Nm = 0.0;
  bool powered = false;  ///< the power stage drives the motor
  Fault fault;           ///< the one being injected
};

/// Frames in, frames out, time passed in: no clock, no I/O, no allocation after construction, the same bits every run.
///
/// Time is integer nanoseconds, not negative, and must not run backwards (an earlier one counts as the last).
/// Frames must be handed over in the order of the bus. Error frames of the port are ignored: the fault "bus-off" plays that.
class Drive {
 public:
  /// The drive is without power until the first call of `advance` or `receive`, which begins its boot.
  /// @throws std::invalid_argument for a node outside 1..127 or a profile that names an object the table lacks.
  Drive(const Profile& profile, const Placement& placement);
  ~Drive();
  Drive(Drive&&) noexcept;
  Drive& operator=(Drive&&) noexcept;

  /// A frame of somebody else. Answers go to `out`.
  void receive(const can::Frame& frame, std::int64_t now_ns, Outbox& out) noexcept;

  /// Lets time pass: motor, heartbeat, watchdogs, timers.
  void advance(std::int64_t now_ns, Outbox& out) noexcept;

  /// Injects a fault, as a write to 2F00h does. `Kind::None` ends the one that runs.
  void inject(const Fault& fault, std::int64_t now_ns, Outbox& out) noexcept;

  /// A load on the joint: torque and inertia beside the drive's own. Holds until set again.
  void set_load(const JointLoad& load) noexcept;
  /// The joint as a load sees it.
  [[nodiscard]] JointState joint_state() const noexcept;

  [[nodiscard]] std::uint8_t node() const noexcept;
  [[nodiscard]] double counts_per_rad() const noexcept;
  [[nodiscard]] DriveView view() const noexcept;
  [[nodiscard]] const DriveCounters& counters() const noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace glenoid::drives
