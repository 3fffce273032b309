#include "bridge_rig.hpp"

#include <algorithm>
#include <utility>

#include "host/bridge/core/codec.hpp"
#include "support/allocation_guard.hpp"

namespace glenoid::bridge::test {

Settings six_drives(std::size_t drives, std::size_t buses) {
  Settings settings;
  settings.name = "test";
  settings.bus_count = buses;
  for (std::size_t j = 0; j < drives; ++j) {
    JointSettings joint;
    joint.name = "joint" + std::to_string(j + 1);
    joint.bus = j * buses / drives;
    joint.node = static_cast<std::uint8_t>(j + 1);
    joint.gear_ratio = 100;
    joint.sign = j % 2 == 0 ? 1 : -1;
    joint.offset_rad = 0.1 * static_cast<double>(j);
    joint.encoder_counts_per_turn = 4096;
    joint.lower_rad = -2.0;
    joint.upper_rad = 2.0;
    joint.velocity_rad_per_s = 3.0;
    joint.acceleration_rad_per_s2 = 30.0;
    joint.step_rad = 0.05;
    joint.start_window_rad = 0.2;
    joint.blend_rad_per_s = 0.5;
    joint.measured_margin_rad = 0.1;
    joint.following_window_rad = 0.1;
    joint.following_time_ns = 20 * kMs;
    settings.joints.push_back(joint);
  }
  return settings;
}

Rig::Rig(const Settings& given) : settings(given), bridge(given), buses(given.bus_count) {
  for (const JointSettings& joint : settings.joints) drives.emplace_back(joint.node, Scale(joint).counts(0.3).value());
}

void Rig::to_wire(std::size_t b, const can::Frame& frame) {
  wire.push_back({now_ns, b, frame, true});
  std::vector<can::Frame> answers;
  for (std::size_t j = 0; j < drives.size(); ++j)
    if (settings.joints[j].bus == b) drives[j].receive(frame, now_ns, answers);
  from_drives(b, answers);
}

void Rig::from_drives(std::size_t b, const std::vector<can::Frame>& frames) {
  for (const can::Frame& frame : frames) {
    wire.push_back({now_ns, b, frame, false});
    if (buses[b].link == can::Link::Up) buses[b].to_bridge.push_back({frame, now_ns, false});
  }
}

void Rig::transmit() {
  for (std::size_t b = 0; b < buses.size(); ++b) {
    RigBus& bus = buses[b];
    if (outputs.bus[b].purge) {
      ++bus.purges;
      bus.purge_failed = !bus.can_purge;
      if (bus.can_purge) bus.queue.clear();
    }
    if (!bus.stalled)  // first in, first out
      for (const can::Frame& frame : std::exchange(bus.queue, {})) to_wire(b, frame);
    for (const can::Frame& frame : outputs.bus[b].frames) {
      if (bus.link != can::Link::Up || bus.refuses) {
        ++bus.counters.refused;
      } else if (bus.stalled) {
        ++bus.counters.sent;
        bus.queue.push_back(frame);
      } else {
        ++bus.counters.sent;
        to_wire(b, frame);
      }
    }
  }
}

void Rig::collect() {
  events.insert(events.end(), outputs.events.begin(), outputs.events.end());
  if (outputs.has_feedback) feedback.push_back(outputs.feedback);
  if (outputs.has_status) statuses.push_back(outputs.status);
}

Setpoint Rig::setpoint_now() {
  Setpoint setpoint;
  const Sample sample = motion(seconds());
  setpoint.time_ns = now_ns;
  setpoint.sequence = ++sequence;
  setpoint.session = bridge.session();
  setpoint.count = static_cast<std::int32_t>(settings.joints.size());
  setpoint.valid_mask = (1 << settings.joints.size()) - 1;
  for (std::size_t j = 0; j < settings.joints.size(); ++j) {
    setpoint.position_rad[j] = sample.position_rad[j];
    setpoint.velocity_rad_per_s[j] = sample.velocity_rad_per_s[j];
  }
  return setpoint;
}

void Rig::cycle() {
  using glenoid::test::AllocationGuard;
  {
    AllocationGuard guard;
    bridge.sync(sync_number, now_ns, outputs);
    allocations += guard.allocations();
  }
  collect();
  transmit();
  const std::int64_t sync_ns = now_ns;
  now_ns += settings.period_ns / 2;
  std::vector<can::Frame> spoken;
  for (std::size_t j = 0; j < drives.size(); ++j) {
    spoken.clear();
    drives[j].advance(now_ns, spoken);
    from_drives(settings.joints[j].bus, spoken);
  }
  if (motion) setpoints.push_back(setpoint_now());
  Inputs inputs;
  std::vector<std::vector<can::Received>> received(buses.size());
  for (std::size_t b = 0; b < buses.size(); ++b) {
    RigBus& bus = buses[b];
    received[b] = std::exchange(bus.to_bridge, {});
    inputs.bus[b] = {received[b], bus.link, bus.queue.size(), std::exchange(bus.purge_failed, false), bus.counters};
  }
  inputs.setpoints = setpoints;
  inputs.commands = commands;
  inputs.entropy = ++entropy;
  inputs.local_estop = local_estop;
  inputs.shutdown = shutdown;
  inputs.suppress_heartbeat = suppress_heartbeat;
  {
    AllocationGuard guard;
    bridge.step(now_ns, inputs, outputs);
    allocations += guard.allocations();
  }
  setpoints.clear();
  commands.clear();
  collect();
  transmit();
  now_ns = sync_ns + settings.period_ns;
  ++sync_number;
}

void Rig::cycles(int count) {
  for (int k = 0; k < count; ++k) cycle();
}

bool Rig::run_until(const std::function<bool()>& done, std::int64_t within_ns) {
  for (const std::int64_t end = now_ns + within_ns; now_ns < end;) {
    cycle();
    if (done()) return true;
  }
  return false;
}

void Rig::command(Request request) { commands.push_back({now_ns, 0, bridge.session(), request}); }

void Rig::error_frame(std::size_t b, const can::Frame& frame) { buses[b].to_bridge.push_back({frame, now_ns, false}); }

bool Rig::configure() {
  return run_until([&] { return bridge.configured(); }, 5000 * kMs);
}

bool Rig::arm() {
  if (!configure()) return false;
  cycles(2);
  command(Request::Arm);
  return run_until([&] { return bridge.state() == State::Ready; }, 2000 * kMs);
}

bool Rig::run(const std::function<Sample(double)>& motion_of_time) {
  if (!arm()) return false;
  motion = motion_of_time;
  cycles(5);
  command(Request::Start);
  if (!run_until([&] { return bridge.state() == State::Run; }, 100 * kMs)) return false;
  run_for(1000 * kMs);
  return bridge.state() == State::Run;
}

bool Rig::has_event(std::int32_t code) const { return first_event(code) != nullptr; }

const Event* Rig::first_event(std::int32_t code) const {
  const auto found = std::find_if(events.begin(), events.end(), [&](const Event& e) { return e.code == code; });
  return found == events.end() ? nullptr : &*found;
}

std::string Rig::told() const {
  std::string text;
  for (const Event& event : events)
    if (event.code != static_cast<std::int32_t>(Notice::ObjectWritten)) text += std::string(event.text.data()) + "\n";
  return text;
}

std::pair<std::uint16_t, std::int32_t> Rig::last_rpdo(std::uint8_t node) const {
  for (auto entry = wire.rbegin(); entry != wire.rend(); ++entry)
    if (entry->from_bridge && entry->frame.id == 0x200U + node)
      if (const auto value = decode_rpdo1(entry->frame)) return {value->controlword, value->target_position};
  return {0xFFFF, 0};
}

}  // namespace glenoid::bridge::test
