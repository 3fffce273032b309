#pragma once

// What the bridge is told and what it tells, free of any wire format. Numbers of enumerators are fixed: they are in logs.

#include <array>
#include <cstddef>
#include <cstdint>

namespace glenoid::bridge {

inline constexpr std::size_t kMaxJoints = 16;
inline constexpr std::size_t kMaxBuses = 4;

using JointValues = std::array<double, kMaxJoints>;

/// Idle: drives without power. Ready: enabled, at rest, token given. Run: follows setpoints. Hold: comes to rest, enabled.
/// Stop: quick stop, latched. Fault: quick stop, latched, something is wrong with the device.
enum class State : std::int32_t { Idle = 1, Ready = 2, Run = 3, Hold = 4, Stop = 5, Fault = 6 };

/// Requests of the operator, numbered as command_v1_t.
enum class Request : std::int32_t { Arm = 1, Start = 2, Stop = 3, EStop = 4, ResetFault = 5, Disarm = 6 };

/// Why a setpoint was not used. A setpoint is used whole or not at all.
enum class Rejection : std::int32_t {
  None = 0,
  Size = 1,            ///< message of another length (found before decoding)
  Type = 2,            ///< message of another type (found before decoding)
  NotFinite = 3,       ///< NaN or infinity
  Count = 4,           ///< number of joints is not the configured one
  Mask = 5,            ///< not all joints commanded
  Session = 6,         ///< not the token of this session
  Sequence = 7,        ///< not after the last accepted one
  Age = 8,             ///< stamp too old, or not after the last accepted one
  Future = 9,          ///< stamp too far ahead
  Position = 10,       ///< beyond the position limits
  Velocity = 11,       ///< beyond the velocity limit
  Step = 12,           ///< too far from the previous command
  StartDistance = 13,  ///< before the start: too far from where the joint is
  NotArmed = 14,       ///< no session
};
inline constexpr std::size_t kRejectionCount = 15;

/// Why the bridge stopped. Latched until ResetFault.
enum class Fault : std::int32_t {
  None = 0,
  EStop = 1,           ///< state Stop
  StaleSetpoints = 2,  ///< state Stop
  LoopStalled = 3,     ///< state Stop: the bridge itself did not run for longer than the quick-stop time
  TwoPublishers = 4,
  LimitExceeded = 5,  ///< a joint whose limits are not to be clamped
  FollowingError = 6,
  MeasuredOutOfRange = 7,
  DriveFault = 8,           ///< statusword shows fault or fault reaction
  DriveEmergency = 9,       ///< EMCY
  DriveLeftOperation = 10,  ///< statusword left operation enabled without being told
  DriveNotFollowing = 11,   ///< statusword bit 12 went away
  DriveRebooted = 12,       ///< boot-up message nobody asked for
  DriveLeftNmt = 13,        ///< heartbeat shows another state than operational
  HeartbeatLost = 14,
  FeedbackLost = 15,  ///< a drive stopped answering SYNC
  BusSilent = 16,     ///< every drive of a bus stopped answering SYNC
  BusOff = 17,
  LinkDown = 18,
  TransmitStalled = 19,  ///< frames do not reach the bus
  StartUpFailed = 20,    ///< a drive refused its configuration or is not the configured one
  EnableTimeout = 21,    ///< the CiA 402 state walk did not finish in time
  CountOverflow = 22,    ///< a command does not fit 607Ah
  ForeignMaster = 23,    ///< somebody else sends NMT, SYNC, RPDOs or the master's heartbeat
  DriveKeepsPower = 24,  ///< still enabled or in quick stop when it was told to be without power
};

/// What else is worth an event. Events of a fault carry the Fault number, these start at 100.
enum class Notice : std::int32_t {
  DriveFound = 100,
  DriveConfigured = 101,
  DriveOperational = 102,
  DriveSilent = 103,  ///< no answer to the probe so far
  SdoAbort = 104,
  ObjectWritten = 105,  ///< value = what was written and read back
  Emergency = 106,
  EmergencyCleared = 107,
  Armed = 108,
  Disarmed = 109,
  Started = 110,
  Stopped = 111,
  Held = 112,
  Resumed = 113,
  Refused = 114,  ///< a request that cannot be fulfilled now
  FaultReset = 115,
  SetpointRejected = 116,
  Limited = 117,
  CycleSkipped = 118,
  BusState = 119,
  PurgeFailed = 120,
  EventsLost = 121,
  StateChanged = 122,
  DriveUnwatched = 123,  ///< it has no 1016h, and the configuration accepts that
  ForeignFrames = 124,   ///< of another master, while nothing is armed
};

enum class Severity : std::int32_t { Info = 0, Warning = 1, Error = 2 };

enum class BusState : std::int32_t { Active = 0, Warning = 1, Passive = 2, Off = 3, Down = 4 };

/// NMT states as a heartbeat carries them; Unknown before the first one.
enum class Nmt : std::int32_t {
  BootUp = 0x00,
  Stopped = 0x04,
  Operational = 0x05,
  PreOperational = 0x7F,
  Unknown = -1
};

/// States of CiA 402.
enum class DriveState : std::int32_t {
  Unknown = 0,
  NotReady = 1,
  SwitchOnDisabled = 2,
  ReadyToSwitchOn = 3,
  SwitchedOn = 4,
  OperationEnabled = 5,
  QuickStopActive = 6,
  FaultReaction = 7,
  Fault = 8,
};

/// Where the joints shall be at `time_ns`. rad, rad/s, Nm in the order of exo.q.
struct Setpoint {
  std::int64_t time_ns = 0;
  std::int64_t arrival_ns = 0;  ///< CLOCK_MONOTONIC at reception; 0: when the step sees it
  std::int64_t sequence = 0;
  std::int64_t session = 0;
  std::int32_t count = 0;
  std::int32_t valid_mask = 0;
  JointValues position_rad{};
  JointValues velocity_rad_per_s{};
  JointValues effort_feedforward_Nm{};
};

/// A request with its stamp.
struct Command {
  std::int64_t time_ns = 0;
  std::int64_t sequence = 0;
  std::int64_t session = 0;
  Request request = Request::Stop;
};

/// What the drives reported for one SYNC.
struct Feedback {
  std::int64_t time_ns = 0;  ///< of the SYNC
  std::int64_t sequence = 0;
  std::int64_t session = 0;
  std::int64_t sync_count = 0;
  std::int64_t setpoint_sequence = 0;
  std::int32_t count = 0;
  std::int32_t valid_mask = 0;  ///< bit k: joint k answered this SYNC
  JointValues position_rad{};
  JointValues velocity_rad_per_s{};
  JointValues effort_Nm{};
  JointValues command_rad{};  ///< what was sent for this SYNC
  std::array<std::int32_t, kMaxJoints> statusword{};
};

struct BusStatus {
  BusState state = BusState::Active;
  std::int32_t tx_errors = 0;
  std::int32_t rx_errors = 0;
  std::int64_t refused = 0;
  std::int64_t outstanding = 0;
  std::int64_t overruns = 0;
  float load = 0.0F;  ///< measured, 0..1, bits without stuffing
};

struct DriveStatus {
  std::int32_t node_id = 0;
  Nmt nmt = Nmt::Unknown;
  DriveState state = DriveState::Unknown;
  std::int32_t statusword = 0;
  std::int32_t error_code = 0;  ///< last EMCY
  std::int64_t heartbeat_age_ns = -1;
  std::int64_t missed_feedback = 0;
  double following_error_rad = 0.0;
};

struct Status {
  std::int64_t time_ns = 0;
  std::int64_t sequence = 0;
  std::int64_t session = 0;
  State state = State::Idle;
  Fault fault = Fault::None;
  std::int32_t joint_count = 0;
  std::int32_t bus_count = 0;
  bool purge_needed = false;
  bool configured = false;  ///< every drive is configured and operational: arming is possible
  std::int64_t cycles = 0;
  std::int64_t cycles_skipped = 0;
  std::int64_t setpoints_accepted = 0;
  std::int64_t setpoints_rejected = 0;
  Rejection last_rejection = Rejection::None;
  std::array<BusStatus, kMaxBuses> bus{};
  std::array<DriveStatus, kMaxJoints> drive{};
};

/// A distribution in short.
struct Figure {
  std::int64_t values = 0;
  double p50_us = 0.0;
  double p99_us = 0.0;
  double p999_us = 0.0;
  double largest_us = 0.0;
};
inline constexpr std::size_t kFigures = 10;

/// What the loop measured since it began, numbered as figures_v1_t.
struct Figures {
  std::int64_t time_ns = 0;
  std::int64_t cycles = 0;
  std::int64_t cycles_left_out = 0;
  std::int64_t setpoints_accepted = 0;
  std::int64_t setpoints_rejected = 0;
  std::array<Figure, kFigures> figure{};
};

/// Something happened. `text` is UTF-8 and zero-terminated.
struct Event {
  std::int64_t time_ns = 0;
  std::int64_t sequence = 0;
  Severity severity = Severity::Info;
  std::int32_t code = 0;  ///< Fault or Notice
  std::int32_t bus = -1;
  std::int32_t node = 0;
  std::int32_t joint = -1;
  double value = 0.0;
  double limit = 0.0;
  std::array<char, 160> text{};
};

}  // namespace glenoid::bridge
