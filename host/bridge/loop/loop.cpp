#include "host/bridge/loop/loop.hpp"

#include <sys/random.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "host/bridge/core/bytes.hpp"
#include "host/bridge/core/canopen.hpp"
#include "host/bridge/core/pdo_table.hpp"
#include "host/bridge/loop/realtime.hpp"

namespace glenoid::bridge {
namespace {

constexpr std::int64_t kReleaseWaitNs = 3'000'000'000;  // for drives that do not answer at the end
constexpr std::int64_t kDeadmanWaitNs = 1'000'000'000;  // beside the drives' own waiting time
constexpr std::uint16_t kHeartbeatLost = 0x8130;

bool is_sync(const can::Frame& frame) noexcept {
  return frame.id == canopen::kSyncId && !frame.extended && !frame.error;
}

bool has_function(const can::Frame& frame, std::uint32_t code) noexcept {
  return !frame.extended && !frame.error && (frame.id & 0x780U) == code && (frame.id & 0x7FU) != 0;
}

}  // namespace

Figures LoopFigures::in_short(std::int64_t now_ns) const noexcept {
  return {now_ns,
          static_cast<std::int64_t>(cycles.value()),
          static_cast<std::int64_t>(late_cycles.value()),
          static_cast<std::int64_t>(accepted.value()),
          static_cast<std::int64_t>(rejected.value()),
          {wake_up.figure(), sync_error.figure(), rpdo_after_sync.figure(), tpdo_after_sync.figure(),
           setpoint_to_wire.figure(), cycle_cpu.figure(), awake.figure(), core.figure(), port.figure(), lcm.figure()}};
}

Loop::Loop(const Config& config, std::vector<std::unique_ptr<can::Port>> ports, lcm_port::LcmPort* lcm, FrameLog* log,
           const LoopOptions& options)
    : settings_(config.settings),
      rpdo_phase_(config.rpdo_phase),
      ports_(std::move(ports)),
      lcm_(lcm),
      log_(log),
      options_(options),
      bridge_(config.settings),
      estop_input_(options.estop_descriptor),
      received_(ports_.size(), std::vector<can::Received>(kFrames)) {
  if (!options_.arming_obstacle.empty()) inputs_.arming_obstacle = options_.arming_obstacle.c_str();
}

void Loop::run() noexcept {
  const std::int64_t period_ns = settings_.period_ns;
  const auto awake_ns = static_cast<std::int64_t>(1e3 * options_.awake_us);
  start_ns_ = monotonic_ns() + 10 * period_ns;
  std::int64_t cpu_ns = thread_cpu_ns();
  for (std::int64_t number = 0;;) {
    const std::int64_t deadline_ns = start_ns_ + number * period_ns;
    figures_.awake.record(wait_until(deadline_ns, awake_ns));
    const std::int64_t now_ns = monotonic_ns();
    const std::int64_t late_ns = now_ns - deadline_ns;
    figures_.wake_up.record(late_ns);
    if (finished(now_ns)) return;
    if (late_ns >= period_ns / 2) {  // too late for its answers: leave out what is over, the grid stays
      const std::int64_t next = (now_ns - start_ns_) / period_ns + 1;
      figures_.late_cycles.add(static_cast<std::uint64_t>(next - number));
      number = next;
      continue;
    }
    cycle(number, deadline_ns);
    const std::int64_t before_ns = std::exchange(cpu_ns, thread_cpu_ns());
    figures_.cycle_cpu.record(cpu_ns - before_ns);
    figures_.cycles.add();
    ++number;
  }
}

void Loop::cycle(std::int64_t number, std::int64_t deadline_ns) noexcept {
  parts_ = {};
  lap_ns_ = monotonic_ns();
  bridge_.sync(number, deadline_ns, outputs_);
  lap(parts_.core_ns);
  transmit();
  lap(parts_.port_ns);
  tell();
  lap(parts_.lcm_ns);
  sleep_until(deadline_ns + static_cast<std::int64_t>(rpdo_phase_ * static_cast<double>(settings_.period_ns)));
  const std::int64_t now_ns = lap_ns_ = monotonic_ns();
  collect_frames();
  lap(parts_.port_ns);
  collect_messages();
  lap(parts_.lcm_ns);
  collect_wishes(now_ns);
  step_deadman(now_ns);
  bridge_.step(now_ns, inputs_, outputs_);
  lap(parts_.core_ns);
  transmit();
  lap(parts_.port_ns);
  for (const Setpoint& setpoint : inputs_.setpoints)
    if (setpoint.session == bridge_.session() && setpoint.session != 0 && setpoint.time_ns <= lap_ns_)
      figures_.setpoint_to_wire.record(lap_ns_ - setpoint.time_ns);
  tell();
  lap(parts_.lcm_ns);
  figures_.core.record(parts_.core_ns);
  figures_.port.record(parts_.port_ns);
  figures_.lcm.record(parts_.lcm_ns);
  state_.store(bridge_.state(), std::memory_order_relaxed);
}

/// What passed since the last lap belongs to this part.
void Loop::lap(std::int64_t& part_ns) noexcept {
  const std::int64_t now_ns = monotonic_ns();
  part_ns += now_ns - std::exchange(lap_ns_, now_ns);
}

void Loop::collect_frames() noexcept {
  for (std::size_t b = 0; b < ports_.size(); ++b) {
    const std::size_t count = ports_[b]->receive(received_[b]);
    const std::span<const can::Received> received(received_[b].data(), count);
    for (const can::Received& one : received) observe(b, one);
    inputs_.bus[b] = {received, ports_[b]->link(), ports_[b]->outstanding(), std::exchange(purge_failed_[b], false),
                      ports_[b]->counters()};
  }
}

void Loop::collect_messages() noexcept {
  std::size_t setpoints = 0, commands = 0;
  inputs_.undecodable = 0;
  if (lcm_ != nullptr) {
    setpoints = lcm_->take_setpoints(setpoints_);
    commands = lcm_->take_commands(commands_);
    inputs_.undecodable = lcm_->take_undecodable();
  }
  inputs_.setpoints = {setpoints_.data(), setpoints};
  inputs_.commands = {commands_.data(), commands};
  if (commands > 0 && getrandom(&inputs_.entropy, sizeof inputs_.entropy, GRND_NONBLOCK) < 0)
    inputs_.entropy ^= realtime_ns();  // cannot happen once the machine is up
}

/// What else is asked for: emergency stop and the end.
void Loop::collect_wishes(std::int64_t now_ns) noexcept {
  inputs_.local_estop = estop_input_.poll() | estop_.exchange(false, std::memory_order_relaxed);
  const bool over = options_.duration_s > 0.0 && 1e-9 * static_cast<double>(now_ns - start_ns_) >= options_.duration_s;
  inputs_.shutdown = over || deadman_done_ || stop_.load(std::memory_order_relaxed);
  if (inputs_.shutdown && stop_since_ns_ < 0) stop_since_ns_ = now_ns;
}

void Loop::observe(std::size_t bus, const can::Received& received) noexcept {
  if (deadman_since_ns_ >= 0 && !received.own && has_function(received.frame, canopen::kEmergencyId) &&
      get_u16(received.frame, 0) == kHeartbeatLost)
    for (std::size_t j = 0; j < settings_.joints.size(); ++j)
      if (settings_.joints[j].bus == bus && settings_.joints[j].node == (received.frame.id & 0x7FU))
        deadman_heard_ |= 1U << j;
  if (log_ != nullptr && !received.own) log_->add(received.time_ns, bus, received.frame);
  if (received.own && is_sync(received.frame)) {
    const std::int64_t since_ns = received.time_ns - sync_seen_ns_[bus];
    const std::int64_t whole = (since_ns + settings_.period_ns / 2) / settings_.period_ns;  // cycles may be left out
    if (sync_seen_ns_[bus] != 0 && whole >= 1)
      figures_.sync_error.record(std::abs(since_ns - whole * settings_.period_ns));
    sync_seen_ns_[bus] = received.time_ns;
  } else if (sync_seen_ns_[bus] != 0 && received.own && has_function(received.frame, kRpdo1.cob_id)) {
    figures_.rpdo_after_sync.record(received.time_ns - sync_seen_ns_[bus]);
  } else if (sync_seen_ns_[bus] != 0 && !received.own && has_function(received.frame, kTpdo1.cob_id)) {
    figures_.tpdo_after_sync.record(received.time_ns - sync_seen_ns_[bus]);
  }
}

void Loop::transmit() noexcept {
  for (std::size_t b = 0; b < ports_.size(); ++b) {
    if (outputs_.bus[b].purge && !options_.silent) purge_failed_[b] = !ports_[b]->purge();
    const std::span<const can::Frame> frames = outputs_.bus[b].frames.view();
    if (frames.empty()) continue;
    const std::int64_t now_ns = monotonic_ns();
    if (!options_.silent) ports_[b]->send(frames);
    if (log_ == nullptr) continue;
    for (const can::Frame& frame : frames) log_->add(now_ns, b, frame);
  }
}

void Loop::tell() noexcept {
  for (const Event& event : outputs_.events) {
    events_.push(event);
    if (lcm_ != nullptr) lcm_->tell(event);
  }
  if (outputs_.has_status) {
    status_ = outputs_.status;
    figures_.accepted.set(static_cast<std::uint64_t>(status_.setpoints_accepted));
    figures_.rejected.set(static_cast<std::uint64_t>(status_.setpoints_rejected));
  }
  if (lcm_ == nullptr) return;
  if (outputs_.has_feedback) lcm_->tell(outputs_.feedback, bridge_.state());
  if (outputs_.has_status) lcm_->tell(outputs_.status);
  lcm_->flush();
}

/// The master falls silent on purpose; every drive has to say 8130h.
void Loop::step_deadman(std::int64_t now_ns) noexcept {
  if (!options_.deadman_test || deadman_done_) return;
  if (deadman_since_ns_ < 0) {
    if (!bridge_.configured() || status_.cycles == 0) return;
    // Some heartbeats first: a consumer begins with the first one it hears.
    if (stop_since_ns_ < 0 && now_ns - start_ns_ > 10 * settings_.master_heartbeat_ns) deadman_since_ns_ = now_ns;
    return;
  }
  inputs_.suppress_heartbeat = true;
  deadman_passed_ = deadman_heard_ == (1U << settings_.joints.size()) - 1U;
  deadman_done_ = deadman_passed_ || now_ns - deadman_since_ns_ > settings_.consumer_heartbeat_ns + kDeadmanWaitNs;
}

bool Loop::finished(std::int64_t now_ns) noexcept {
  if (stop_since_ns_ < 0) return false;
  return bridge_.released() || now_ns - stop_since_ns_ > kReleaseWaitNs;
}

}  // namespace glenoid::bridge
