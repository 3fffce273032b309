#pragma once

// The bridge's core and simulated drives on one bus in memory, in virtual time: what a rehearsal runs.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "host/bridge/can/memory_bus.hpp"
#include "host/bridge/config/config.hpp"
#include "host/bridge/core/bridge.hpp"
#include "host/drives/group.hpp"
#include "host/rig/disturbance.hpp"
#include "host/rig/record.hpp"

namespace glenoid::rig {

/// A setpoint and when it reaches the bridge. The rig puts the token in: `setpoint.session` is combined with the present one
/// by exclusive or, so that 0 is the right token and everything else a wrong one.
struct PlannedSetpoint {
  std::int64_t due_ns = 0;
  bridge::Setpoint setpoint;
};

/// Drive of one joint.
struct DriveSetup {
  drives::Profile profile;  ///< its gear and encoder are replaced by those of the configuration, where these are whole
  double start_rad = 0.0;   ///< of the joint, as the configuration counts it
};

struct RigOptions {
  std::int64_t start_ns = 1'000'000'000;  ///< of the virtual clock
  std::uint64_t seed = 1;                 ///< of tokens and lost frames
};

/// One exoskeleton in lock-step. Time is integer nanoseconds and nothing else moves it: equal calls give equal bits.
///
/// A cycle: SYNC, the drives answer; after the phase of the configuration the setpoints and requests that are due, the
/// bridge's step, and its RPDOs reach the drives. Frames take no time on the bus; the load is computed, not played.
class Rig {
 public:
  /// @param drives  one per joint of the configuration
  /// @param load    what couples the drives, in the drives' own directions; none: each joint is by itself
  /// @throws std::invalid_argument  another number of drives, or a drive that the profile or configuration does not allow; a
  ///                                load with drives on several buses
  Rig(const bridge::Config& config, const std::vector<DriveSetup>& drives, const RigOptions& options,
      std::unique_ptr<drives::Load> load = nullptr);
  ~Rig();
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  /// Runs so many SYNC periods.
  void run(std::int64_t cycles);
  /// Runs until the bridge is in `state`, at most so many periods. @return it is
  bool run_until(bridge::State state, std::int64_t cycles);
  /// Runs until every drive is configured and operational. @return they are
  bool configure(std::int64_t cycles);

  /// A request of the operator, taken by the next step, with the present token.
  void request(bridge::Request request);
  /// Adds setpoints, in the order of their due times; those in the past arrive with the next step.
  void play(std::span<const PlannedSetpoint> setpoints);
  /// Adds a disturbance. Those of the past happen with the next cycle.
  void schedule(const Disturbance& disturbance);

  [[nodiscard]] std::int64_t now_ns() const noexcept { return now_ns_; }
  [[nodiscard]] const bridge::Bridge& bridge() const noexcept { return bridge_; }
  [[nodiscard]] const Record& record() const noexcept { return record_; }
  /// Forgets what was recorded.
  void clear_record() { record_ = {}; }
  /// Drive of a joint.
  [[nodiscard]] const drives::Drive& drive(std::size_t joint) const;
  /// Where the joint truly is, rad, as the configuration counts it.
  [[nodiscard]] double true_position_rad(std::size_t joint) const;

 private:
  struct Bus;
  struct Timed {
    Disturbance disturbance;
    bool begun = false;
  };

  void cycle();
  void disturb();
  void begin(const Disturbance& disturbance);
  void end(const Disturbance& disturbance);
  void step_drives();
  void step_bridge();
  void transmit();
  void collect();
  void note_cycle(std::int64_t sync_ns);
  void each_drive(const Disturbance& disturbance, const drives::Fault& fault);

  bridge::Config config_;
  bridge::Bridge bridge_;
  bridge::Inputs inputs_;
  bridge::Outputs outputs_;
  std::vector<std::unique_ptr<Bus>> buses_;
  std::vector<std::size_t> place_;  // of a joint's drive in its bus's group
  std::vector<PlannedSetpoint> setpoints_;
  std::size_t next_setpoint_ = 0;
  std::vector<bridge::Command> commands_;
  std::vector<Timed> disturbances_;
  std::int64_t now_ns_;
  std::int64_t cycle_ = 0;
  std::int64_t command_sequence_ = 0;
  std::uint64_t random_;
  Record record_;
};

}  // namespace glenoid::rig
