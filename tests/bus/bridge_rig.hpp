#pragma once

// The bridge's core with scripted drives, in virtual time: nothing sleeps, nothing is left to chance.

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "host/bridge/can/frame.hpp"
#include "host/bridge/core/bridge.hpp"
#include "host/bridge/core/resampler.hpp"

namespace glenoid::bridge::test {

inline constexpr std::int64_t kMs = 1'000'000;

/// A CANopen drive as simple as can be: follows its target at once, and misbehaves on demand.
class FakeDrive {
 public:
  explicit FakeDrive(std::uint8_t node, std::int32_t position = 0);

  void receive(const can::Frame& frame, std::int64_t now_ns, std::vector<can::Frame>& out);
  void advance(std::int64_t now_ns, std::vector<can::Frame>& out);
  /// Power cycle: everything back to defaults, boot-up message.
  void reboot(std::vector<can::Frame>& out);
  [[nodiscard]] static std::uint32_t key(std::uint32_t index, std::uint32_t sub) { return index << 8 | sub; }

  std::uint8_t node;
  std::int32_t position;
  std::int32_t target = 0;
  std::uint16_t controlword = 0;
  std::uint16_t statusword = 0x0240;
  std::uint8_t nmt = 0x7F;
  std::map<std::uint32_t, std::uint32_t> objects;  ///< index << 8 | sub
  std::vector<std::uint32_t> writes;               ///< keys in the order they came

  bool dead = false;      ///< neither hears nor speaks
  bool mute_pdo = false;  ///< answers no SYNC
  bool mute_heartbeat = false;
  bool mute_sdo = false;
  bool follows = true;                               ///< bit 12
  bool stuck = false;                                ///< does not move
  bool refuses_enable = false;                       ///< stays in switched on
  bool keeps_power = false;                          ///< stays in operation enabled
  std::map<std::uint32_t, std::uint32_t> aborts;     ///< SDO access to these is aborted with a code
  std::map<std::uint32_t, std::uint32_t> read_back;  ///< reads give this instead

 private:
  void sdo(const can::Frame& frame, std::vector<can::Frame>& out);
  void control(std::uint16_t word);
  void answer_sync(std::vector<can::Frame>& out);

  std::uint16_t pending_control_ = 0;
  std::int32_t pending_target_ = 0;
  bool pending_ = false;
  std::int64_t heartbeat_ns_ = 0;
};

/// What was on the wire.
struct Wire {
  std::int64_t time_ns;
  std::size_t bus;
  can::Frame frame;
  bool from_bridge;
};

/// One bus of the rig and how it behaves.
struct RigBus {
  can::Link link = can::Link::Up;
  bool stalled = false;  ///< what the bridge sends waits in `queue`
  bool can_purge = true;
  bool refuses = false;  ///< what the bridge sends is not taken
  std::vector<can::Frame> queue;
  std::vector<can::Received> to_bridge;
  can::PortCounters counters;
  bool purge_failed = false;
  int purges = 0;
};

Settings six_drives(std::size_t drives = 6, std::size_t buses = 1);

class Rig {
 public:
  explicit Rig(const Settings& settings);

  void cycle();
  void cycles(int count);
  void run_for(std::int64_t ns) { cycles(static_cast<int>(ns / settings.period_ns)); }
  /// Runs until `done` or the time is over. True: done.
  bool run_until(const std::function<bool()>& done, std::int64_t within_ns);

  void command(Request request);
  void command(const Command& value) { commands.push_back(value); }
  void error_frame(std::size_t bus, const can::Frame& frame);

  /// Start-up, arming and start with a motion streaming: state RUN, blended in.
  bool configure();
  bool arm();
  bool run(const std::function<Sample(double)>& motion_of_time);

  [[nodiscard]] bool has_event(std::int32_t code) const;
  [[nodiscard]] const Event* first_event(std::int32_t code) const;
  [[nodiscard]] std::string told() const;
  [[nodiscard]] double seconds() const { return 1e-9 * static_cast<double>(now_ns); }
  [[nodiscard]] Setpoint setpoint_now();
  /// Last RPDO that the bridge sent to a node; controlword in `.first`, target in `.second`.
  [[nodiscard]] std::pair<std::uint16_t, std::int32_t> last_rpdo(std::uint8_t node) const;

  Settings settings;
  Bridge bridge;
  std::vector<FakeDrive> drives;
  std::vector<RigBus> buses;
  std::int64_t now_ns = 1'000'000'000;
  std::int64_t sync_number = 0;
  std::vector<Wire> wire;
  std::vector<Event> events;
  std::vector<Feedback> feedback;
  std::vector<Status> statuses;
  std::vector<Setpoint> setpoints;  ///< to be handed over with the next step
  std::vector<Command> commands;
  std::function<Sample(double)> motion;  ///< streamed while set
  std::int64_t sequence = 0;
  bool local_estop = false;
  bool shutdown = false;
  bool suppress_heartbeat = false;
  std::int64_t entropy = 0x1234'5678'9ABC;
  long allocations = 0;
  Outputs outputs;

 private:
  void to_wire(std::size_t bus, const can::Frame& frame);
  void from_drives(std::size_t bus, const std::vector<can::Frame>& frames);
  void transmit();
  void collect();
};

}  // namespace glenoid::bridge::test
