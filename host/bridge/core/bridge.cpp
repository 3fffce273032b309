#include "host/bridge/core/bridge.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "host/bridge/core/canopen.hpp"
#include "host/bridge/core/implementation.hpp"

namespace glenoid::bridge {
namespace {

constexpr std::int64_t kStatusPeriodNs = 100'000'000;
constexpr std::int64_t kTellAgainNs = 1'000'000'000;  // repeated events of a kind
constexpr int kSdoPerCycle = 2;                       // on one bus

void clear(Outputs& outputs) noexcept {
  for (BusOutput& bus : outputs.bus) {
    bus.frames.clear();
    bus.purge = false;
  }
  outputs.events.clear();
  outputs.has_feedback = outputs.has_status = false;
}

}  // namespace

Bridge::Bridge(const Settings& settings) : implementation_(std::make_unique<Implementation>(settings)) {}
Bridge::~Bridge() = default;
Bridge::Bridge(Bridge&&) noexcept = default;
Bridge& Bridge::operator=(Bridge&&) noexcept = default;

void Bridge::sync(std::int64_t cycle, std::int64_t time_ns, Outputs& outputs) noexcept {
  implementation_->sync(cycle, time_ns, outputs);
}
void Bridge::step(std::int64_t time_ns, const Inputs& inputs, Outputs& outputs) noexcept {
  implementation_->step(time_ns, inputs, outputs);
}
State Bridge::state() const noexcept { return implementation_->state(); }
Fault Bridge::fault() const noexcept { return implementation_->fault(); }
std::int64_t Bridge::session() const noexcept { return implementation_->session(); }
bool Bridge::configured() const noexcept { return implementation_->configured(); }
bool Bridge::released() const noexcept { return implementation_->released(); }
std::span<const double> Bridge::command_rad() const noexcept { return implementation_->command_rad(); }

Bridge::Implementation::Implementation(const Settings& settings)
    : settings_(settings),
      gate_(settings_),
      clock_(settings.time_base),
      resampler_(settings.joints.size(), settings.hold_after_ns) {
  if (settings_.joints.empty() || settings_.joints.size() > kMaxJoints)
    throw std::invalid_argument("joints: 1 to 16 are possible");
  if (settings_.bus_count == 0 || settings_.bus_count > kMaxBuses)
    throw std::invalid_argument("buses: 1 to 4 are possible");
  for (std::size_t b = 0; b < settings_.bus_count; ++b)
    buses_.emplace_back(b < settings_.bit_rate_bit_per_s.size() ? settings_.bit_rate_bit_per_s[b] : 1e6,
                        settings_.transmit_skips);
  const double period_s = 1e-9 * static_cast<double>(settings_.period_ns);
  for (std::size_t j = 0; j < settings_.joints.size(); ++j) {
    const JointSettings& joint = settings_.joints[j];
    if (joint.bus >= settings_.bus_count) throw std::invalid_argument(joint.name + ": no such bus");
    nodes_.emplace_back(settings_, j);
    Joint& own = joints_.emplace_back();
    own.scale = Scale(joint);
    own.limiter = CommandLimiter({joint.lower_rad, joint.upper_rad, joint.velocity_rad_per_s,
                                  joint.acceleration_rad_per_s2, joint.blend_rad_per_s},
                                 period_s);
  }
  command_rad_.fill(std::numeric_limits<double>::quiet_NaN());
  sent_rad_.fill(command_rad_);
  rejection_told_ns_.fill(-kTellAgainNs);
  foreign_told_ns_.fill(-kTellAgainNs);
  link_told_.fill(true);
}

bool Bridge::Implementation::configured() const noexcept {
  return std::all_of(nodes_.begin(), nodes_.end(), [](const Node& node) { return node.operational(); });
}

bool Bridge::Implementation::released() const noexcept {
  return std::all_of(nodes_.begin(), nodes_.end(),
                     [](const Node& node) { return node.phase() == Node::Phase::Released; });
}

void Bridge::Implementation::sync(std::int64_t cycle, std::int64_t time_ns, Outputs& outputs) noexcept {
  clear(outputs);
  reporter_.begin(time_ns, outputs);
  if (cycle_ >= 0 && cycle > cycle_ + 1) {
    const std::int64_t missing = cycle - cycle_ - 1;
    skipped_ += missing;
    if (skipped_told_ns_ < 0 || time_ns - skipped_told_ns_ >= kTellAgainNs) {
      skipped_told_ns_ = time_ns;
      reporter_.report(Severity::Warning, code(Notice::CycleSkipped), {}, static_cast<double>(missing), 0,
                       "%lld cycles left out, %lld so far", static_cast<long long>(missing),
                       static_cast<long long>(skipped_));
    }
  }
  cycle_ = cycle;
  sync_ns_ = time_ns;
  sync_sequence_ = gate_.sequence();
  sync_session_ = session_;
  ++cycles_;
  // The step that follows will stop; a SYNC now would make an old command active.
  const bool overslept = (armed() || arming_) && last_step_ns_ >= 0 &&
                         time_ns - last_step_ns_ > settings_.quick_stop_after_ns;
  for (std::size_t b = 0; b < buses_.size(); ++b) {
    sync_sent_[b] = buses_[b].clear() && !overslept && (!stopped() || stop_sent_[b]);
    if (sync_sent_[b]) outputs.bus[b].frames.push(canopen::sync());
  }
}

void Bridge::Implementation::step(std::int64_t time_ns, const Inputs& inputs, Outputs& outputs) noexcept {
  clear(outputs);
  outputs_ = &outputs;
  now_ns_ = time_ns;
  entropy_ = inputs.entropy;
  local_estop_ = inputs.local_estop;
  arming_obstacle_ = inputs.arming_obstacle;
  reporter_.begin(time_ns, outputs);
  receive(inputs);
  supervise(inputs);
  for (const Command& command : inputs.commands) take(command);
  setpoints_rejected_ += inputs.undecodable;
  if (inputs.undecodable > 0) last_rejection_ = Rejection::Size;
  for (const Setpoint& setpoint : inputs.setpoints) take(setpoint);
  if (inputs.shutdown) shut_down();
  advance();
  send();
  send_heartbeats(inputs.suppress_heartbeat);
  publish_feedback();
  publish_status();
  last_step_ns_ = time_ns;
}

void Bridge::Implementation::receive(const Inputs& inputs) noexcept {
  for (std::size_t b = 0; b < buses_.size(); ++b) {
    buses_[b].observe(inputs.bus[b]);
    for (const can::Received& received : inputs.bus[b].received)
      if (!received.own) dispatch(b, received.frame);
    buses_[b].measure_load(now_ns_);
  }
  for (std::size_t j = 0; j < nodes_.size(); ++j) {
    nodes_[j].close_cycle(sync_sent_[settings_.joints[j].bus]);
    if (nodes_[j].answered()) measure(j);
  }
}

void Bridge::Implementation::dispatch(std::size_t bus, const can::Frame& frame) noexcept {
  buses_[bus].receive(frame);
  if (frame.error || frame.extended) return;
  if (is_order(bus, frame)) foreign_[bus] = {now_ns_, frame.id};
  const std::uint32_t node = frame.id & 0x7FU;
  if (node == 0) return;
  for (std::size_t j = 0; j < nodes_.size(); ++j)
    if (settings_.joints[j].bus == bus && settings_.joints[j].node == node)
      nodes_[j].receive(frame, now_ns_, reporter_);
}

void Bridge::Implementation::measure(std::size_t j) noexcept {
  Joint& joint = joints_[j];
  const double position_rad = joint.scale.position_rad(nodes_[j].feedback().position_actual);
  const std::int64_t periods = cycle_ - joint.measured_cycle;
  if (joint.measured_cycle >= 0 && periods > 0)
    joint.velocity_rad_per_s = (position_rad - joint.measured_rad) /
                               (1e-9 * static_cast<double>(settings_.period_ns) * static_cast<double>(periods));
  joint.measured_rad = position_rad;
  joint.measured_cycle = cycle_;
}

void Bridge::Implementation::send() noexcept {
  std::array<int, kMaxBuses> sdo{};
  sdo.fill(kSdoPerCycle);
  for (std::size_t b = 0; b < buses_.size(); ++b) outputs_->bus[b].purge = buses_[b].take_purge();
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    const std::size_t j = (k + sdo_turn_) % nodes_.size();  // every node gets its turn
    const std::size_t b = settings_.joints[j].bus;
    if (!buses_[b].clear()) continue;
    bool allowed = sdo[b] > 0;
    const bool before = allowed;
    nodes_[j].step(now_ns_, allowed, outputs_->bus[b], reporter_);
    if (before && !allowed) --sdo[b];
  }
  ++sdo_turn_;
  for (std::size_t j = 0; j < nodes_.size(); ++j) {
    const std::size_t b = settings_.joints[j].bus;
    if (nodes_[j].operational() && nodes_[j].has_feedback() && buses_[b].clear())
      outputs_->bus[b].frames.push(encode(settings_.joints[j].node, Rpdo1{joints_[j].controlword, joints_[j].target}));
  }
  for (std::size_t b = 0; b < buses_.size(); ++b) {
    stop_sent_[b] = stop_sent_[b] || buses_[b].clear();
    for (const can::Frame& frame : outputs_->bus[b].frames) buses_[b].receive(frame);
  }
}

void Bridge::Implementation::send_heartbeats(bool suppressed) noexcept {
  // Half a period of slack: the cycle nearest to the due time sends it.
  if (heartbeat_ns_ >= 0 && now_ns_ - heartbeat_ns_ < settings_.master_heartbeat_ns - settings_.period_ns / 2) return;
  heartbeat_ns_ = now_ns_;
  if (suppressed) return;
  for (std::size_t b = 0; b < buses_.size(); ++b)
    if (buses_[b].clear()) outputs_->bus[b].frames.push(canopen::heartbeat(settings_.master_id, Nmt::Operational));
}

void Bridge::Implementation::publish_feedback() noexcept {
  Feedback& feedback = outputs_->feedback;
  outputs_->has_feedback = std::any_of(nodes_.begin(), nodes_.end(), [](const Node& n) { return n.has_feedback(); });
  const JointValues sent = sent_rad_[0];  // before this step
  sent_rad_[2] = sent_rad_[1];
  sent_rad_[1] = sent_rad_[0];
  sent_rad_[0] = command_rad_;
  if (!outputs_->has_feedback) return;
  feedback = {};
  feedback.time_ns = sync_ns_;
  feedback.sequence = ++feedback_sequence_;
  feedback.session = sync_session_;
  feedback.sync_count = cycle_;
  feedback.setpoint_sequence = sync_sequence_;
  feedback.count = static_cast<std::int32_t>(nodes_.size());
  for (std::size_t j = 0; j < nodes_.size(); ++j) {
    const Tpdo1& value = nodes_[j].feedback();
    if (nodes_[j].answered()) feedback.valid_mask |= 1 << j;
    feedback.position_rad[j] = joints_[j].measured_rad;
    feedback.velocity_rad_per_s[j] = joints_[j].velocity_rad_per_s;
    feedback.effort_Nm[j] = 1e-3 * value.torque_actual * settings_.joints[j].rated_torque_Nm * settings_.joints[j].sign;
    feedback.command_rad[j] = sent[j];
    feedback.statusword[j] = value.statusword;
  }
}

/// Changes whenever something changed that a reader must know at once.
std::uint64_t Bridge::Implementation::status_key() const noexcept {
  std::uint64_t key = 14695981039346656037U;  // FNV-1a, 64 bit
  const auto mix = [&](std::int64_t value) { key = (key ^ static_cast<std::uint64_t>(value)) * 1099511628211U; };
  mix(code(state_));
  mix(code(fault_));
  mix(session_);
  for (const BusMonitor& bus : buses_) {
    mix(code(bus.status().state));
    mix(bus.purge_needed() ? 1 : 0);
  }
  for (const Node& node : nodes_) {
    const DriveStatus status = node.status(now_ns_);
    mix(code(status.nmt));
    mix(code(status.state));
    mix(status.error_code);
    mix(code(node.phase()));
  }
  return key;
}

void Bridge::Implementation::publish_status() noexcept {
  const std::uint64_t key = status_key();
  outputs_->has_status = status_ns_ < 0 || key != status_key_ || now_ns_ - status_ns_ >= kStatusPeriodNs;
  if (!outputs_->has_status) return;
  status_key_ = key;
  status_ns_ = now_ns_;
  Status& status = outputs_->status;
  status = {};
  status.time_ns = now_ns_;
  status.sequence = ++status_sequence_;
  status.session = session_;
  status.state = state_;
  status.fault = fault_;
  status.joint_count = static_cast<std::int32_t>(nodes_.size());
  status.bus_count = static_cast<std::int32_t>(buses_.size());
  status.configured = configured();
  status.cycles = cycles_;
  status.cycles_skipped = skipped_;
  status.setpoints_accepted = setpoints_accepted_;
  status.setpoints_rejected = setpoints_rejected_;
  status.last_rejection = last_rejection_;
  for (std::size_t b = 0; b < buses_.size(); ++b) {
    status.bus[b] = buses_[b].status();
    status.purge_needed = status.purge_needed || buses_[b].purge_needed();
  }
  for (std::size_t j = 0; j < nodes_.size(); ++j) {
    status.drive[j] = nodes_[j].status(now_ns_);
    status.drive[j].following_error_rad = joints_[j].following_rad;
  }
}

}  // namespace glenoid::bridge
