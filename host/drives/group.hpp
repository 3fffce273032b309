#pragma once

// Up to sixteen drives on one bus.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "host/bridge/can/port.hpp"
#include "host/drives/drive.hpp"
#include "host/drives/outbox.hpp"

namespace glenoid::drives {

inline constexpr std::size_t kMostDrives = 16;

/// A fault at a time after the first step.
struct ScheduledFault {
  std::int64_t at_ns = 0;
  std::uint8_t node = 0;  ///< 0: all drives
  Fault fault;
};

/// What the group counted beside its drives.
struct GroupCounters {
  std::uint64_t steps = 0;
  std::uint64_t syncs = 0;             ///< on the bus
  std::uint64_t unanswered_syncs = 0;  ///< SYNCs of which an answer that was due was refused by the port
  std::uint64_t late_syncs = 0;        ///< SYNCs answered after the next one had come
  std::uint64_t refused_frames = 0;    ///< by the port, or no room in the outbox
};

/// Steps the drives of one bus. The port is the caller's and outlives the group. No allocation after construction.
class DriveGroup {
 public:
  /// @throws std::invalid_argument for none or more than 16 drives, or two of the same node.
  DriveGroup(can::Port& port, std::vector<Drive> drives, std::vector<ScheduledFault> schedule = {});

  /// Couples the drives by a load, joint k of it being drive k; drives without one pay nothing for it.
  /// @throws std::invalid_argument  the load has another number of joints
  void carry(std::unique_ptr<Load> load);

  /// Hands the frames that have arrived to every drive, lets time pass until `now_ns` and sends the answers.
  /// Frames take effect at the port's reception time, no later than `now_ns`.
  void step(std::int64_t now_ns) noexcept;

  [[nodiscard]] std::span<Drive> drives() noexcept { return drives_; }
  [[nodiscard]] std::span<const Drive> drives() const noexcept { return drives_; }
  [[nodiscard]] const GroupCounters& counters() const noexcept { return counters_; }

 private:
  void deliver(const can::Received& received, bool later_sync_waits) noexcept;
  void run_schedule() noexcept;
  void move_load() noexcept;
  void flush() noexcept;

  can::Port* port_;
  std::vector<Drive> drives_;
  std::vector<ScheduledFault> schedule_;
  std::size_t next_fault_ = 0;
  std::int64_t begin_ns_ = -1;
  std::int64_t now_ns_ = 0;
  std::unique_ptr<Load> load_;
  std::int64_t load_ns_ = 0;  // up to when the joints and their load have moved together
  Outbox outbox_;
  GroupCounters counters_;
};

}  // namespace glenoid::drives
