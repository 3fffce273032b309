#include "host/rig/rig.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace glenoid::rig {
namespace {

constexpr std::size_t kBatch = 256;
constexpr std::uint16_t kProducerHeartbeat = 0x1017;

/// One turn of the pseudo-random numbers of George Marsaglia's xorshift64*.
std::uint64_t next_random(std::uint64_t& state) noexcept {
  state ^= state >> 12;
  state ^= state << 25;
  state ^= state >> 27;
  return state * 0x2545F4914F6CDD1DU;
}

bool is_whole(double value) noexcept { return value == std::floor(value) && value >= 1.0 && value < 4294967296.0; }

/// The drive as the configuration describes it.
drives::Profile with_gear(drives::Profile profile, const bridge::JointSettings& joint) {
  if (is_whole(joint.gear_ratio) && is_whole(joint.encoder_counts_per_turn)) {
    profile.mechanics.gear_ratio = static_cast<std::uint32_t>(joint.gear_ratio);
    profile.mechanics.encoder_counts_per_motor_rev = static_cast<std::uint32_t>(joint.encoder_counts_per_turn);
  } else if (std::abs(profile.mechanics.counts_per_rev() / (joint.gear_ratio * joint.encoder_counts_per_turn) - 1.0) >
             1e-12) {
    throw std::invalid_argument(joint.name + ": gear ratio and encoder counts are not whole, and the drive's profile " +
                                profile.name + " counts otherwise");
  }
  if (joint.rated_torque_Nm > 0.0) profile.mechanics.rated_torque_Nm = joint.rated_torque_Nm;
  return profile;
}

/// SDO download of the drive's heartbeat period, 0 ms.
can::Frame silence(std::uint8_t node) noexcept {
  can::Frame frame;
  frame.id = 0x600U + node;
  frame.size = 8;
  frame.data = {0x2B, kProducerHeartbeat & 0xFF, kProducerHeartbeat >> 8};
  return frame;
}

}  // namespace

struct Rig::Bus {
  explicit Bus(std::vector<drives::Drive> drives)
      : logger(memory.connect()),
        master(memory.connect()),
        drives_port(memory.connect()),
        group(*drives_port, std::move(drives)) {}

  can::MemoryBus memory{{32, 4096, true}};
  std::unique_ptr<can::Port> logger, master, drives_port;
  drives::DriveGroup group;
  std::vector<can::Received> received = std::vector<can::Received>(kBatch);
  bool purge_failed = false;
};

Rig::Rig(const bridge::Config& config, const std::vector<DriveSetup>& drives, const RigOptions& options,
         std::unique_ptr<drives::Load> load)
    : config_(config),
      bridge_(config.settings),
      now_ns_(options.start_ns),
      random_(options.seed != 0 ? options.seed : 1) {
  const std::vector<bridge::JointSettings>& joints = config_.settings.joints;
  if (drives.size() != joints.size())
    throw std::invalid_argument("drives: " + std::to_string(drives.size()) + " for " + std::to_string(joints.size()) +
                                " joints");
  for (std::size_t b = 0; b < config_.settings.bus_count; ++b) {
    std::vector<drives::Drive> own;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      if (joints[j].bus != b) continue;
      const double start_rad = joints[j].sign * (drives[j].start_rad - joints[j].offset_rad);
      own.emplace_back(with_gear(drives[j].profile, joints[j]),
                       drives::Placement{joints[j].node, start_rad, options.seed + j});
    }
    buses_.push_back(std::make_unique<Bus>(std::move(own)));
  }
  std::vector<std::size_t> used(buses_.size(), 0);
  for (const bridge::JointSettings& joint : joints) place_.push_back(used[joint.bus]++);
  if (!load) return;
  if (buses_.size() != 1)
    throw std::invalid_argument("load: the drives are on " + std::to_string(buses_.size()) + " buses, must be on one");
  buses_.front()->group.carry(std::move(load));
}

Rig::~Rig() = default;

const drives::Drive& Rig::drive(std::size_t joint) const {
  return std::as_const(buses_[config_.settings.joints.at(joint).bus]->group).drives()[place_[joint]];
}

double Rig::true_position_rad(std::size_t joint) const {
  const bridge::JointSettings& settings = config_.settings.joints.at(joint);
  return settings.sign * drive(joint).view().position_rad + settings.offset_rad;
}

void Rig::run(std::int64_t cycles) {
  for (std::int64_t k = 0; k < cycles; ++k) cycle();
}

bool Rig::run_until(bridge::State state, std::int64_t cycles) {
  for (std::int64_t k = 0; k < cycles && bridge_.state() != state; ++k) cycle();
  return bridge_.state() == state;
}

bool Rig::configure(std::int64_t cycles) {
  for (std::int64_t k = 0; k < cycles && !bridge_.configured(); ++k) cycle();
  return bridge_.configured();
}

void Rig::request(bridge::Request request) {
  commands_.push_back({now_ns_, ++command_sequence_, bridge_.session(), request});
}

void Rig::play(std::span<const PlannedSetpoint> setpoints) {
  setpoints_.erase(setpoints_.begin(), setpoints_.begin() + static_cast<std::ptrdiff_t>(next_setpoint_));
  next_setpoint_ = 0;
  setpoints_.insert(setpoints_.end(), setpoints.begin(), setpoints.end());
  std::stable_sort(setpoints_.begin(), setpoints_.end(),
                   [](const PlannedSetpoint& a, const PlannedSetpoint& b) { return a.due_ns < b.due_ns; });
}

void Rig::schedule(const Disturbance& disturbance) { disturbances_.push_back({disturbance}); }

/// Both halves of a period; the clock stands at the next SYNC afterwards.
void Rig::cycle() {
  const std::int64_t sync_ns = now_ns_;
  disturb();
  bridge_.sync(cycle_, sync_ns, outputs_);
  transmit();
  collect();
  step_drives();
  now_ns_ = sync_ns + static_cast<std::int64_t>(config_.rpdo_phase * static_cast<double>(config_.settings.period_ns));
  disturb();
  step_drives();
  step_bridge();
  step_drives();
  note_cycle(sync_ns);
  now_ns_ = sync_ns + config_.settings.period_ns;
  ++cycle_;
}

void Rig::step_drives() {
  for (const auto& bus : buses_) {
    bus->memory.set_time(now_ns_);
    bus->group.step(now_ns_);
  }
}

void Rig::step_bridge() {
  for (std::size_t b = 0; b < buses_.size(); ++b) {
    Bus& bus = *buses_[b];
    const std::size_t count = bus.master->receive(bus.received);
    inputs_.bus[b] = {{bus.received.data(), count},
                      bus.master->link(),
                      bus.master->outstanding(),
                      std::exchange(bus.purge_failed, false),
                      bus.master->counters()};
  }
  const std::size_t first = record_.setpoints.size();
  for (; next_setpoint_ < setpoints_.size() && setpoints_[next_setpoint_].due_ns <= now_ns_; ++next_setpoint_) {
    bridge::Setpoint& setpoint = record_.setpoints.emplace_back(setpoints_[next_setpoint_].setpoint);
    setpoint.session ^= bridge_.session();
    setpoint.arrival_ns = setpoints_[next_setpoint_].due_ns;
  }
  inputs_.setpoints = {record_.setpoints.data() + first, record_.setpoints.size() - first};
  inputs_.commands = commands_;
  inputs_.entropy = static_cast<std::int64_t>(next_random(random_));
  bridge_.step(now_ns_, inputs_, outputs_);
  record_.commands.insert(record_.commands.end(), commands_.begin(), commands_.end());
  commands_.clear();
  transmit();
  collect();
}

void Rig::transmit() {
  for (std::size_t b = 0; b < buses_.size(); ++b) {
    Bus& bus = *buses_[b];
    bus.memory.set_time(now_ns_);
    if (outputs_.bus[b].purge) bus.purge_failed = !bus.master->purge();
    if (!outputs_.bus[b].frames.empty()) bus.master->send(outputs_.bus[b].frames.view());
  }
}

/// What the bridge told, and what the bus carried.
void Rig::collect() {
  record_.events.insert(record_.events.end(), outputs_.events.begin(), outputs_.events.end());
  if (outputs_.has_feedback) record_.feedback.push_back({outputs_.feedback, bridge_.state()});
  if (outputs_.has_status) record_.statuses.push_back(outputs_.status);
  outputs_.events.clear();
  outputs_.has_feedback = outputs_.has_status = false;
}

void Rig::note_cycle(std::int64_t sync_ns) {
  CycleRecord& now = record_.cycles.emplace_back();
  now.time_ns = sync_ns;
  now.state = bridge_.state();
  now.fault = bridge_.fault();
  for (std::size_t j = 0; j < place_.size(); ++j) {
    const drives::DriveView view = drive(j).view();
    now.position_rad[j] = true_position_rad(j);
    now.velocity_rad_per_s[j] = config_.settings.joints[j].sign * view.velocity_rad_per_s;
    now.torque_Nm[j] = view.torque_Nm;
    now.command_rad[j] = bridge_.command_rad()[j];
    if (view.powered) now.powered_mask |= 1U << j;
  }
  std::array<can::Received, kBatch> batch;
  for (std::size_t b = 0; b < buses_.size(); ++b) {
    for (std::size_t count = kBatch; count == kBatch;) {
      count = buses_[b]->logger->receive(batch);
      for (std::size_t k = 0; k < count; ++k)
        record_.frames.push_back({batch[k].time_ns, static_cast<std::int32_t>(b), batch[k].frame});
    }
  }
}

void Rig::disturb() {
  for (Timed& timed : disturbances_) {
    if (!timed.begun && timed.disturbance.at_ns <= now_ns_) {
      timed.begun = true;
      begin(timed.disturbance);
    }
    const Disturbance& own = timed.disturbance;
    if (timed.begun && own.duration_ns > 0 && own.at_ns + own.duration_ns <= now_ns_) {
      end(own);
      timed.disturbance.duration_ns = 0;
    }
  }
}

void Rig::each_drive(const Disturbance& disturbance, const drives::Fault& fault) {
  drives::Outbox out;
  for (std::size_t j = 0; j < place_.size(); ++j) {
    Bus& bus = *buses_[config_.settings.joints[j].bus];
    const bool whole_bus = disturbance.kind == DisturbanceKind::BusSilent;
    if (whole_bus && static_cast<int>(config_.settings.joints[j].bus) != disturbance.bus) continue;
    if (!whole_bus && disturbance.joint >= 0 && static_cast<int>(j) != disturbance.joint) continue;
    drives::Drive& own = bus.group.drives()[place_[j]];
    if (disturbance.kind == DisturbanceKind::DriveHeartbeat) {
      own.receive(silence(own.node()), now_ns_, out);  // nobody on the bus hears of it
    } else {
      own.inject(fault, now_ns_, out);
      bus.memory.set_time(now_ns_);
      bus.drives_port->send(out.frames());
    }
    out.clear();
  }
}

void Rig::begin(const Disturbance& disturbance) {
  const auto b = static_cast<std::size_t>(std::clamp(disturbance.bus, 0, static_cast<int>(buses_.size()) - 1));
  switch (disturbance.kind) {
    case DisturbanceKind::Drive:
    case DisturbanceKind::DriveHeartbeat:
      return each_drive(disturbance, {disturbance.fault.kind, disturbance.fault.amount, 0});
    case DisturbanceKind::BusSilent:
      return each_drive(disturbance, {drives::FaultKind::Stall, 0, 0});
    case DisturbanceKind::MasterHeartbeat:
      inputs_.suppress_heartbeat = true;
      return;
    case DisturbanceKind::EStopMessage:
      return request(bridge::Request::EStop);
    case DisturbanceKind::EStopInput:
      inputs_.local_estop = true;
      return;
    case DisturbanceKind::BusStalled:
      return buses_[b]->memory.stall(true);
    case DisturbanceKind::LinkDown:
      return buses_[b]->memory.set_link(can::Link::Down);
  }
}

void Rig::end(const Disturbance& disturbance) {
  const auto b = static_cast<std::size_t>(std::clamp(disturbance.bus, 0, static_cast<int>(buses_.size()) - 1));
  switch (disturbance.kind) {
    case DisturbanceKind::Drive:
    case DisturbanceKind::BusSilent:
      return each_drive(disturbance, {});
    case DisturbanceKind::MasterHeartbeat:
      inputs_.suppress_heartbeat = false;
      return;
    case DisturbanceKind::EStopInput:
      inputs_.local_estop = false;
      return;
    case DisturbanceKind::BusStalled:
      buses_[b]->memory.set_time(now_ns_);
      return buses_[b]->memory.stall(false);
    case DisturbanceKind::LinkDown:
      return buses_[b]->memory.set_link(can::Link::Up);
    case DisturbanceKind::DriveHeartbeat:
    case DisturbanceKind::EStopMessage:
      return;  // these do not end by themselves
  }
}

}  // namespace glenoid::rig
