#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "host/drives/fault.hpp"

namespace glenoid::rig {

/// What can go wrong around the bridge, beside what the stream of setpoints does.
enum class DisturbanceKind : std::uint8_t {
  Drive = 0,            ///< a fault of the drive model
  DriveHeartbeat = 1,   ///< the drive produces no heartbeat any more, all else goes on
  MasterHeartbeat = 2,  ///< the bridge's heartbeat is missing
  EStopMessage = 3,     ///< ESTOP of the operator
  EStopInput = 4,       ///< the local input is pressed
  BusSilent = 5,        ///< no drive of the bus hears or speaks
  BusStalled = 6,       ///< nobody acknowledges: frames stay in the queues
  LinkDown = 7,         ///< the interface is down
};
inline constexpr int kDisturbanceKinds = 8;

/// Something that goes wrong at a time.
struct Disturbance {
  DisturbanceKind kind = DisturbanceKind::Drive;
  std::int64_t at_ns = 0;
  std::int64_t duration_ns = 0;  ///< 0: to the end
  int joint = -1;                ///< -1: all
  int bus = 0;
  drives::Fault fault;  ///< of kind Drive; its own duration is not used
};

/// Word of scenarios: "drive", "drive-heartbeat", ...
std::string_view name(DisturbanceKind kind) noexcept;

/// The kind a word names.
std::optional<DisturbanceKind> disturbance_kind(std::string_view word) noexcept;

}  // namespace glenoid::rig
