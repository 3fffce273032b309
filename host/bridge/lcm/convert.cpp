#include "host/bridge/lcm/convert.hpp"

#include <algorithm>
#include <cstddef>

namespace glenoid::lcm_port {
namespace {

using bridge::BusState;
using bridge::Rejection;
using bridge::State;

// One numbering for the core, the wire and the logs.
template <class Enumerator>
constexpr bool is_number(Enumerator value, int number) {
  return static_cast<int>(value) == number;
}
static_assert(is_number(State::Idle, status_v1_t::IDLE) && is_number(State::Ready, status_v1_t::READY) &&
              is_number(State::Run, status_v1_t::RUN) && is_number(State::Hold, status_v1_t::HOLD) &&
              is_number(State::Stop, status_v1_t::STOP) && is_number(State::Fault, status_v1_t::FAULT));
static_assert(is_number(BusState::Active, status_v1_t::BUS_ACTIVE) &&
              is_number(BusState::Warning, status_v1_t::BUS_WARNING) &&
              is_number(BusState::Passive, status_v1_t::BUS_PASSIVE) &&
              is_number(BusState::Off, status_v1_t::BUS_OFF) && is_number(BusState::Down, status_v1_t::BUS_DOWN));
static_assert(is_number(Rejection::Size, status_v1_t::REJECTED_SIZE) &&
              is_number(Rejection::Type, status_v1_t::REJECTED_TYPE) &&
              is_number(Rejection::NotFinite, status_v1_t::REJECTED_NOT_FINITE) &&
              is_number(Rejection::Count, status_v1_t::REJECTED_COUNT) &&
              is_number(Rejection::Mask, status_v1_t::REJECTED_MASK) &&
              is_number(Rejection::Session, status_v1_t::REJECTED_SESSION) &&
              is_number(Rejection::Sequence, status_v1_t::REJECTED_SEQUENCE) &&
              is_number(Rejection::Age, status_v1_t::REJECTED_AGE) &&
              is_number(Rejection::Future, status_v1_t::REJECTED_FUTURE) &&
              is_number(Rejection::Position, status_v1_t::REJECTED_POSITION) &&
              is_number(Rejection::Velocity, status_v1_t::REJECTED_VELOCITY) &&
              is_number(Rejection::Step, status_v1_t::REJECTED_STEP) &&
              is_number(Rejection::StartDistance, status_v1_t::REJECTED_START_DISTANCE) &&
              is_number(Rejection::NotArmed, status_v1_t::REJECTED_NOT_ARMED));
static_assert(is_number(bridge::Severity::Info, event_v1_t::INFO) &&
              is_number(bridge::Severity::Warning, event_v1_t::WARNING) &&
              is_number(bridge::Severity::Error, event_v1_t::ERROR));
static_assert(is_number(bridge::Request::Arm, command_v1_t::ARM) &&
              is_number(bridge::Request::Start, command_v1_t::START) &&
              is_number(bridge::Request::Stop, command_v1_t::STOP) &&
              is_number(bridge::Request::EStop, command_v1_t::ESTOP) &&
              is_number(bridge::Request::ResetFault, command_v1_t::RESET_FAULT) &&
              is_number(bridge::Request::Disarm, command_v1_t::DISARM));

static_assert(bridge::kFigures == figures_v1_t::CYCLE_LCM + 1);

constexpr std::int32_t kFollowsTarget = 1 << 12;  // 6041h in cyclic synchronous position mode

template <class From, class To>
void copy(const From& from, To& to) noexcept {
  std::copy(std::begin(from), std::end(from), std::begin(to));
}

/// Bytes of a text into an array that ends with at least one zero, cut between two characters of UTF-8.
template <class Text, std::size_t N>
void copy_text(const Text& text, std::size_t size, std::int8_t (&to)[N]) noexcept {
  std::size_t kept = std::min(size, N - 1);
  if (kept < size) {
    while (kept > 0 && (static_cast<unsigned char>(text[kept]) & 0xC0u) == 0x80u) --kept;
  }
  std::fill(std::begin(to), std::end(to), std::int8_t{0});
  for (std::size_t k = 0; k < kept; ++k) to[k] = static_cast<std::int8_t>(text[k]);
}

void copy_buses(const bridge::Status& status, status_v1_t& out) noexcept {
  for (std::size_t b = 0; b < status.bus.size(); ++b) {
    const bridge::BusStatus& bus = status.bus[b];
    out.bus_state[b] = static_cast<std::int32_t>(bus.state);
    out.bus_tx_errors[b] = bus.tx_errors;
    out.bus_rx_errors[b] = bus.rx_errors;
    out.bus_refused[b] = bus.refused;
    out.bus_outstanding[b] = bus.outstanding;
    out.bus_overruns[b] = bus.overruns;
    out.bus_load[b] = bus.load;
  }
}

void copy_drives(const bridge::Status& status, status_v1_t& out) noexcept {
  for (std::size_t k = 0; k < status.drive.size(); ++k) {
    const bridge::DriveStatus& drive = status.drive[k];
    out.node_id[k] = drive.node_id;
    out.nmt_state[k] = static_cast<std::int32_t>(drive.nmt);
    out.drive_state[k] = static_cast<std::int32_t>(drive.state);
    out.statusword[k] = drive.statusword;
    out.error_code[k] = drive.error_code;
    out.heartbeat_age_ns[k] = drive.heartbeat_age_ns;
    out.missed_feedback[k] = drive.missed_feedback;
    out.following_error_rad[k] = drive.following_error_rad;
  }
}

void copy_device(const Device& device, status_v1_t& out) noexcept {
  copy_text(device.exoskeleton, device.exoskeleton.size(), out.exoskeleton);
  out.period_ns = device.period_ns;
  out.real_bus_mask = device.real_bus_mask;
  for (std::size_t k = 0; k < bridge::kMaxJoints; ++k) {
    out.velocity_limit_rad_per_s[k] = static_cast<float>(device.velocity_limit_rad_per_s[k]);
    out.acceleration_limit_rad_per_s2[k] = static_cast<float>(device.acceleration_limit_rad_per_s2[k]);
  }
}

}  // namespace

bridge::Setpoint to_core(const setpoint_v1_t& message) noexcept {
  bridge::Setpoint out;
  out.time_ns = message.time_mono_ns;
  out.sequence = message.sequence;
  out.session = message.session;
  out.count = message.count;
  out.valid_mask = message.valid_mask;
  copy(message.position_rad, out.position_rad);
  copy(message.velocity_rad_per_s, out.velocity_rad_per_s);
  copy(message.effort_feedforward_Nm, out.effort_feedforward_Nm);
  return out;
}

std::optional<bridge::Command> to_core(const command_v1_t& message) noexcept {
  if (message.command < command_v1_t::ARM || message.command > command_v1_t::DISARM) return std::nullopt;
  bridge::Command out;
  out.time_ns = message.time_mono_ns;
  out.sequence = message.sequence;
  out.session = message.session;
  out.request = static_cast<bridge::Request>(message.command);
  return out;
}

feedback_v1_t to_wire(const bridge::Feedback& feedback, bridge::State state) noexcept {
  feedback_v1_t out{};
  out.time_mono_ns = feedback.time_ns;
  out.sequence = feedback.sequence;
  out.session = feedback.session;
  out.sync_count = feedback.sync_count;
  out.setpoint_sequence = feedback.setpoint_sequence;
  out.state = static_cast<std::int32_t>(state);
  out.count = feedback.count;
  out.valid_mask = feedback.valid_mask;
  copy(feedback.position_rad, out.position_rad);
  copy(feedback.velocity_rad_per_s, out.velocity_rad_per_s);
  copy(feedback.effort_Nm, out.effort_Nm);
  copy(feedback.command_rad, out.command_rad);
  copy(feedback.statusword, out.statusword);
  for (std::size_t k = 0; k < bridge::kMaxJoints; ++k) {
    const bool answered = (feedback.valid_mask >> k & 1) != 0;
    if (answered && (feedback.statusword[k] & kFollowsTarget) != 0) out.tracking_mask |= 1 << k;
  }
  return out;
}

event_v1_t to_wire(const bridge::Event& event) noexcept {
  event_v1_t out{};
  out.time_mono_ns = event.time_ns;
  out.sequence = event.sequence;
  out.severity = static_cast<std::int32_t>(event.severity);
  out.code = event.code;
  out.bus = event.bus;
  out.node = event.node;
  out.joint = event.joint;
  out.value = event.value;
  out.limit = event.limit;
  const auto end = std::find(event.text.begin(), event.text.end(), '\0');
  copy_text(event.text, static_cast<std::size_t>(end - event.text.begin()), out.text);
  return out;
}

figures_v1_t to_wire(const bridge::Figures& figures) noexcept {
  figures_v1_t out{};
  out.time_mono_ns = figures.time_ns;
  out.cycles = figures.cycles;
  out.cycles_left_out = figures.cycles_left_out;
  out.count = static_cast<std::int32_t>(figures.figure.size());
  for (std::size_t k = 0; k < figures.figure.size(); ++k) {
    out.values[k] = figures.figure[k].values;
    out.p50_us[k] = figures.figure[k].p50_us;
    out.p99_us[k] = figures.figure[k].p99_us;
    out.p999_us[k] = figures.figure[k].p999_us;
    out.largest_us[k] = figures.figure[k].largest_us;
  }
  return out;
}

device_v1_t to_wire(const Device& device, std::int64_t time_ns) noexcept {
  device_v1_t out{};
  out.time_mono_ns = time_ns;
  copy_text(device.exoskeleton, device.exoskeleton.size(), out.exoskeleton);
  copy_text(device.device, device.device.size(), out.device);
  std::copy_n(device.config_sha256.begin(), std::min(device.config_sha256.size(), sizeof out.config_sha256),
              out.config_sha256);
  std::copy_n(device.device_sha256.begin(), std::min(device.device_sha256.size(), sizeof out.device_sha256),
              out.device_sha256);
  out.side = device.side;
  const std::size_t count = std::min(device.joint_names.size(), bridge::kMaxJoints);
  out.joint_count = static_cast<std::int32_t>(count);
  for (std::size_t k = 0; k < count; ++k)
    copy_text(device.joint_names[k], device.joint_names[k].size(), out.joint_name[k]);
  copy(device.lower_rad, out.lower_rad);
  copy(device.upper_rad, out.upper_rad);
  return out;
}

status_v1_t to_wire(const bridge::Status& status, const Device& device, std::int64_t time_utc_ns) noexcept {
  status_v1_t out{};
  out.time_mono_ns = status.time_ns;
  out.time_utc_ns = time_utc_ns;
  out.sequence = status.sequence;
  out.session = status.session;
  out.state = static_cast<std::int32_t>(status.state);
  out.fault = static_cast<std::int32_t>(status.fault);
  out.joint_count = status.joint_count;
  out.bus_count = status.bus_count;
  out.configured = status.configured ? 1 : 0;
  out.purge_needed = status.purge_needed ? 1 : 0;
  out.cycles = status.cycles;
  out.cycles_skipped = status.cycles_skipped;
  out.setpoints_accepted = status.setpoints_accepted;
  out.setpoints_rejected = status.setpoints_rejected;
  out.last_rejection = static_cast<std::int32_t>(status.last_rejection);
  copy_buses(status, out);
  copy_drives(status, out);
  copy_device(device, out);
  return out;
}

}  // namespace glenoid::lcm_port
