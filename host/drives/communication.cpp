// CiA 301 side of a drive: NMT, SYNC, PDO, SDO, heartbeat, and what the loss of them does.

#include <cmath>

#include "host/drives/parts.hpp"

namespace glenoid::drives {
namespace {

constexpr std::int64_t kMs = 1'000'000, kUs = 1'000;
constexpr double kNs = 1e-9;
constexpr std::uint16_t kHeartbeatLost = 0x8130, kPdoTooShort = 0x8210, kPdoTooLong = 0x8220, kSyncLength = 0x8240,
                        kRpdoTimeout = 0x8250, kSyncLost = 0x8700;
constexpr std::uint16_t kRemote = 1U << 9U;
constexpr double kMissed = 1.5;  // SYNC interval over period from which on one is missing

}  // namespace

void Drive::Parts::on_nmt(const can::Frame& frame) noexcept {
  if (frame.size != 2 || (frame.data[1] != 0 && frame.data[1] != placement.node)) return;
  switch (frame.data[0]) {
    case 0x01:
      return enter(Nmt::Operational);
    case 0x02:
      return enter(Nmt::Stopped);
    case 0x80:
      return enter(Nmt::PreOperational);
    case 0x81:
      return boot(now_ns);
    case 0x82:
      return reset_communication();
    default:
      return;
  }
}

void Drive::Parts::enter(Nmt state) noexcept {
  if (state == nmt) return;
  const bool was_operational = nmt == Nmt::Operational;
  nmt = state;
  last_sync_ns = -1;
  sync_lost = false;
  fresh_setpoint = false;
  if (state == Nmt::Operational || was_operational) {
    received.configure(objects);
    transmitted.configure(objects);
  }
  update_link_bits();
  if (state == Nmt::Stopped) {
    sdo.reset();
    connection_lost(0);
  }
}

void Drive::Parts::reset_communication() noexcept {
  connection_lost(0);
  const std::int64_t errors = motion.power().faulty() ? objects.get(row_of(0x1001)) : 0;
  objects.reset(true);
  objects.set(row_of(0x1001), errors);  // a fault is not over because the bus begins anew
  warned = false;
  sdo.reset();
  emergency.reset();
  consumers = {};
  nmt = Nmt::Initialising;
  boot_done_ns = now_ns;
}

void Drive::Parts::update_link_bits() noexcept {
  const bool in_step = nmt == Nmt::Operational && last_sync_ns >= 0 && !sync_lost;
  const auto bit = [](int number, bool set) { return number >= 0 && set ? 1U << static_cast<unsigned>(number) : 0U; };
  const unsigned bits = (nmt == Nmt::Operational ? kRemote : 0U) | bit(profile.synchronised_bit, in_step) |
                        bit(profile.sync_lost_bit, sync_lost);
  const auto reaction = static_cast<Reaction>(objects.get(row_of(0x2F10, 1)));
  motion.set_link_bits(static_cast<std::uint16_t>(bits), sync_lost && reaction == Reaction::Hold);
}

void Drive::Parts::on_sync(const can::Frame& frame, Outbox& out) noexcept {
  if (nmt != Nmt::Operational && nmt != Nmt::PreOperational) return;
  const unsigned expected = objects.get(row_of(0x1019)) != 0 ? 1 : 0;
  if (frame.size != expected) {
    if (!warned) report(kSyncLength);
    return;
  }
  motion.advance(objects, now_ns, true);
  count_sync();
  last_sync_ns = now_ns;
  sync_lost = false;
  update_link_bits();
  if (nmt != Nmt::Operational) return;
  good_news();
  motion.publish(objects);
  const unsigned due = transmitted.on_sync(objects, expected != 0 ? frame.data[0] : 0);
  for (int k = 0; k < kPdos; ++k) {
    if ((due >> static_cast<unsigned>(k) & 1U) == 0) continue;
    ++counters.answers_due;
    line.send(transmitted.sample(objects, k, now_ns), now_ns, out);
  }
  const int activated = received.activate(objects);
  if (activated > 0) motion.control(objects, now_ns);
  if (activated == 0 && !fresh_setpoint && motion.power().state() == PowerState::OperationEnabled) {
    ++counters.missing_setpoints;
  }
  counters.setpoints += static_cast<std::uint64_t>(activated);
  fresh_setpoint = false;
  motion.follow(objects);
}

void Drive::Parts::count_sync() noexcept {
  ++counters.syncs;
  if (nmt != Nmt::Operational || last_sync_ns < 0) return;
  const double periods = static_cast<double>(now_ns - last_sync_ns) * kNs / interpolation_period_s(objects);
  if (periods > kMissed) counters.missed_cycles += static_cast<std::uint64_t>(std::llround(periods)) - 1;
}

void Drive::Parts::on_pdo(const can::Frame& frame) noexcept {
  if (nmt != Nmt::Operational) return;
  using Outcome = ReceivePdos::Outcome;
  const Outcome outcome = received.receive(objects, frame, now_ns);
  if (outcome == Outcome::NotMine) return;
  if (outcome == Outcome::TooShort || outcome == Outcome::TooLong) {
    ++counters.bad_pdos;
    react(outcome == Outcome::TooShort ? kPdoTooShort : kPdoTooLong,
          static_cast<Reaction>(objects.get(row_of(0x2F10, 4))));
    return;
  }
  good_news();
  if (outcome != Outcome::Active) return;
  ++counters.setpoints;
  fresh_setpoint = true;
  motion.control(objects, now_ns);
  const double since_sync_s = static_cast<double>(now_ns - last_sync_ns) * kNs;
  if (last_sync_ns < 0 || since_sync_s > 2.0 * interpolation_period_s(objects)) {  // nobody sends SYNC
    motion.advance(objects, now_ns, true);
    motion.follow(objects);
  }
}

void Drive::Parts::on_sdo(const can::Frame& frame, Outbox& out) noexcept {
  if (nmt != Nmt::Operational && nmt != Nmt::PreOperational) return;
  if (frame.size != 8) return;
  can::Frame answer;
  answer.id = 0x580U + placement.node;
  answer.size = 8;
  if (sdo.respond(frame.data, *this, answer.data)) line.send(answer, now_ns, out);
  if (!request_waits) return;
  request_waits = false;
  inject(requested, now_ns, out);
}

void Drive::Parts::on_heartbeat(const can::Frame& frame) noexcept {
  if (frame.size != 1) return;
  const std::uint32_t producer = frame.id - 0x700U;
  for (std::size_t k = 0; k < consumers.size(); ++k) {
    const std::int64_t entry = objects.get(row_of(0x1016, 1) + k);
    if (producer == 0 || (entry >> 16) != producer) continue;
    consumers[k].last_ns = now_ns;
    good_news();
  }
}

void Drive::Parts::watch() noexcept {
  for (std::size_t k = 0; k < consumers.size(); ++k) {
    const std::int64_t limit_ns = (objects.get(row_of(0x1016, 1) + k) & 0xFFFF) * kMs;
    if (limit_ns == 0 || consumers[k].last_ns < 0 || now_ns - consumers[k].last_ns <= limit_ns) continue;
    consumers[k].last_ns = -1;
    connection_lost(kHeartbeatLost);
  }
  if (nmt != Nmt::Operational) return;
  if (received.expired(objects, now_ns) != 0)
    react(kRpdoTimeout, static_cast<Reaction>(objects.get(row_of(0x2F10, 3))));
  const std::int64_t period_ns = objects.has(row_of(0x1006)) ? objects.get(row_of(0x1006)) * kUs : 0;
  const std::int64_t tolerance_ns = objects.get(row_of(0x2F10, 2)) * kUs;
  if (period_ns == 0 || last_sync_ns < 0 || sync_lost || now_ns - last_sync_ns <= period_ns + tolerance_ns) return;
  sync_lost = true;
  update_link_bits();
  react(kSyncLost, static_cast<Reaction>(objects.get(row_of(0x2F10, 1))));
}

/// 1029h and 6007h; code 0: the master itself ended the connection, nothing to report.
void Drive::Parts::connection_lost(std::uint16_t code) noexcept {
  const std::int64_t option = objects.get(row_of(0x6007));
  const std::int64_t behaviour = objects.get(row_of(0x1029, 1));
  if (code != 0 && option != 1) report(code);
  if (option == 1) {
    motion.fail(objects, code != 0 ? code : kHeartbeatLost);
  } else if (option == 2) {
    motion.disable_voltage(objects);
  } else if (option == 3) {
    motion.quick_stop(objects);
  }
  if (code == 0) return;
  if (behaviour == 0 && nmt == Nmt::Operational) enter(Nmt::PreOperational);
  if (behaviour == 2) enter(Nmt::Stopped);
}

void Drive::Parts::react(std::uint16_t code, Reaction reaction) noexcept {
  if (reaction == Reaction::None) return;
  if (reaction == Reaction::Fault) return motion.fail(objects, code);
  if (!warned) report(code);
  if (reaction == Reaction::QuickStop) motion.quick_stop(objects);
  if (reaction == Reaction::DisableVoltage) motion.disable_voltage(objects);
}

void Drive::Parts::report(std::uint16_t code) noexcept {
  emergency.raise(objects, code);
  ++counters.emergencies;
  counters.last_emergency = code;
  warned = true;
}

/// What was only reported is over when the bus works again.
void Drive::Parts::good_news() noexcept {
  if (!warned || motion.power().faulty()) return;
  warned = false;
  emergency.clear(objects);
}

void Drive::Parts::send_heartbeat(Outbox& out) noexcept {
  can::Frame frame;
  frame.id = 0x700U + placement.node;
  frame.size = 1;
  frame.data[0] = static_cast<std::uint8_t>(nmt);
  line.send(frame, now_ns, out);
}

/// Everything that is sent because time passed.
void Drive::Parts::produce(Outbox& out) noexcept {
  can::Frame frame;
  if (nmt != Nmt::Stopped) {
    while (emergency.next(objects, now_ns, frame)) line.send(frame, now_ns, out);
  }
  if (nmt == Nmt::Operational && transmitted.event_driven()) {
    motion.publish(objects);
    const unsigned due = transmitted.on_time(objects, now_ns);
    for (int k = 0; k < kPdos; ++k) {
      if ((due >> static_cast<unsigned>(k) & 1U) != 0) line.send(transmitted.sample(objects, k, now_ns), now_ns, out);
    }
  }
  const std::int64_t period_ns = objects.get(row_of(0x1017)) * kMs;
  if (period_ns == 0 || now_ns < next_heartbeat_ns) return;
  send_heartbeat(out);
  next_heartbeat_ns += period_ns;
  if (next_heartbeat_ns <= now_ns) next_heartbeat_ns = now_ns + period_ns;
}

}  // namespace glenoid::drives
