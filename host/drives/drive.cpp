#include "host/drives/drive.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "host/drives/parts.hpp"

namespace glenoid::drives {
namespace {

constexpr std::int64_t kMs = 1'000'000, kUs = 1'000;
constexpr double kNs = 1e-9;
constexpr std::uint16_t kOverCurrent = 0x2310, kRecoveredFromBusOff = 0x8140;

}  // namespace

Drive::Parts::Parts(const Profile& wanted, const Placement& place)
    : profile(wanted),
      placement(place),
      objects(wanted, place.node),
      motion(wanted, place.position_rad),
      line(place.seed ^ std::uint64_t{place.node} << 56U) {
  if (place.node < 1 || place.node > 127) {
    throw std::invalid_argument("node = " + std::to_string(place.node) + ": must be 1 to 127");
  }
}

std::int64_t Drive::Parts::forward(std::int64_t time_ns) noexcept {
  if (now_ns < 0) {
    now_ns = time_ns;
    motion.advance(objects, now_ns, false);
    boot(now_ns);
    counters.reboots = 0;
  }
  now_ns = std::max(now_ns, time_ns);
  return now_ns;
}

void Drive::Parts::boot(std::int64_t time_ns) noexcept {
  nmt = Nmt::Initialising;
  objects.reset(false);
  const Mechanics& mechanics = profile.mechanics;
  objects.set(row_of(0x6076), std::llround(mechanics.rated_torque_Nm * 1000.0));
  objects.set(row_of(0x6072), std::llround(mechanics.peak_torque_Nm / mechanics.rated_torque_Nm * 1000.0));
  objects.set(row_of(0x608F, 1), mechanics.encoder_counts_per_motor_rev);
  objects.set(row_of(0x6091, 1), mechanics.gear_ratio);
  sdo.reset();
  emergency.reset();
  consumers = {};
  warned = false;
  last_sync_ns = -1;
  sync_lost = false;
  update_link_bits();
  motion.restart(objects);
  boot_done_ns = time_ns + std::llround(profile.boot_s / kNs);
  ++counters.reboots;
}

bool Drive::Parts::deaf() const noexcept {
  return nmt == Nmt::Initialising || fault.kind == FaultKind::Stall || fault.kind == FaultKind::BusOff;
}

void Drive::Parts::advance(std::int64_t time_ns, Outbox& out) noexcept {
  forward(time_ns);
  if (fault.kind != FaultKind::None && fault_end_ns >= 0 && now_ns >= fault_end_ns) end_fault();
  motion.advance(objects, now_ns, false);
  if (nmt == Nmt::Initialising && now_ns >= boot_done_ns) {
    send_heartbeat(out);  // state 0 is the boot-up message
    nmt = Nmt::PreOperational;
    next_heartbeat_ns = now_ns;
    received.configure(objects);
    transmitted.configure(objects);
    update_link_bits();
  }
  if (fault.kind != FaultKind::Stall && nmt != Nmt::Initialising) watch();
  if (const std::uint16_t code = motion.take_fault(); code != 0) report(code);
  if (motion.take_reset()) {
    warned = false;
    emergency.clear(objects);
  }
  counters.worst_following_error_rad = motion.worst_following_error_rad();
  if (!deaf()) produce(out);
  line.advance(now_ns, out);
}

/// Whether a frame is for this drive at all; most on the bus are not.
bool Drive::Parts::concerns(const can::Frame& frame) const noexcept {
  if (frame.error || frame.extended || frame.remote) return false;
  return frame.id == 0 || frame.id == 0x600U + placement.node || (frame.id > 0x700 && frame.id <= 0x77F) ||
         frame.id == (objects.get(row_of(0x1005)) & 0x7FF) || received.takes(frame.id);
}

void Drive::Parts::receive(const can::Frame& frame, std::int64_t time_ns, Outbox& out) noexcept {
  if (!concerns(frame)) return;
  advance(time_ns, out);
  if (deaf() || !line.delivers()) return;
  if (frame.id == 0) {
    on_nmt(frame);
  } else if (frame.id == (objects.get(row_of(0x1005)) & 0x7FF)) {
    on_sync(frame, out);
  } else if (frame.id == 0x600U + placement.node) {
    on_sdo(frame, out);
  } else if (frame.id > 0x700 && frame.id <= 0x77F) {
    on_heartbeat(frame);
  } else {
    on_pdo(frame);
  }
  advance(time_ns, out);
}

void Drive::Parts::inject(const Fault& wanted, std::int64_t time_ns, Outbox& out) noexcept {
  forward(time_ns);
  end_fault();
  fault = wanted;
  fault_end_ns = wanted.duration_ms != 0 ? now_ns + wanted.duration_ms * kMs : -1;
  switch (wanted.kind) {
    case FaultKind::None:
    case FaultKind::Stall:
      break;
    case FaultKind::Drop:
      line.lose(std::min<std::uint32_t>(wanted.amount, 1000));
      break;
    case FaultKind::Delay:
      line.delay(wanted.amount * kUs);
      break;
    case FaultKind::Emergency:
      motion.fail(objects, wanted.amount != 0 ? static_cast<std::uint16_t>(wanted.amount) : kOverCurrent);
      fault = {};
      break;
    case FaultKind::Reboot:
      boot(now_ns);
      fault = {};
      break;
    case FaultKind::StuckEncoder:
      motion.servo().stick_encoder(true);
      break;
    case FaultKind::BusOff:
      line.cut(true);
      connection_lost(kRecoveredFromBusOff);
      break;
    case FaultKind::Jam:
      motion.servo().jam(true);
      break;
  }
  advance(now_ns, out);
}

void Drive::Parts::end_fault() noexcept {
  line.lose(0);
  line.delay(0);
  line.cut(false);
  motion.servo().stick_encoder(false);
  motion.servo().jam(false);
  fault = {};
  fault_end_ns = -1;
}

Drive::Drive(const Profile& profile, const Placement& placement)
    : parts_(std::make_unique<Parts>(profile, placement)) {}
Drive::~Drive() = default;
Drive::Drive(Drive&&) noexcept = default;
Drive& Drive::operator=(Drive&&) noexcept = default;

void Drive::receive(const can::Frame& frame, std::int64_t now_ns, Outbox& out) noexcept {
  parts_->receive(frame, now_ns, out);
}

void Drive::advance(std::int64_t now_ns, Outbox& out) noexcept { parts_->advance(now_ns, out); }

void Drive::inject(const Fault& fault, std::int64_t now_ns, Outbox& out) noexcept {
  parts_->inject(fault, now_ns, out);
}

void Drive::set_load(const JointLoad& load) noexcept { parts_->motion.servo().load(load); }

JointState Drive::joint_state() const noexcept { return parts_->motion.servo().state(); }

std::uint8_t Drive::node() const noexcept { return parts_->placement.node; }

double Drive::counts_per_rad() const noexcept { return parts_->motion.counts_per_rad(); }

const DriveCounters& Drive::counters() const noexcept { return parts_->counters; }

DriveView Drive::view() const noexcept {
  const Motion& motion = parts_->motion;
  DriveView view;
  view.nmt = parts_->nmt;
  view.state = motion.power().state();
  view.statusword = motion.statusword(parts_->objects);
  view.demand_rad = motion.reference().position();
  view.position_rad = motion.servo().position();
  view.velocity_rad_per_s = motion.servo().velocity();
  view.torque_Nm = motion.servo().torque();
  view.powered = motion.power().powered();
  view.fault = parts_->fault;
  return view;
}

}  // namespace glenoid::drives
