#include "host/drives/pdo.hpp"

#include <algorithm>

namespace glenoid::drives {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kInhibitUnit_ns = 100'000;
constexpr std::size_t kMostBits = 64;
constexpr std::uint16_t kReceive = 0x1400, kTransmit = 0x1800, kToMapping = 0x200;
constexpr unsigned kLastCyclic = 240, kFirstEvent = 254;

std::size_t row_at(std::uint16_t base, int pdo, std::uint8_t sub) noexcept {
  return find_row(static_cast<std::uint16_t>(base + pdo), sub);
}

/// Mapping entry: index, sub-index, bits.
struct Entry {
  explicit Entry(std::int64_t value) noexcept
      : index(static_cast<std::uint16_t>(value >> 16)),
        sub(static_cast<std::uint8_t>(value >> 8)),
        bits(static_cast<std::size_t>(value & 0xFF)) {}
  std::uint16_t index;
  std::uint8_t sub;
  std::size_t bits;

  /// Data-type objects 0002h to 0007h fill a gap of their size.
  [[nodiscard]] bool is_dummy() const noexcept {
    return sub == 0 && index >= 2 && index <= 7 &&
           bits == 8U * static_cast<std::size_t>(size_of(Type{static_cast<std::uint8_t>(index)}));
  }
};

Abort check_entry(const Dictionary& objects, const Entry& entry, bool transmit, bool dummy_mapping) noexcept {
  if (entry.is_dummy() && dummy_mapping && !transmit) return Abort::None;
  Abort why = Abort::None;
  const std::size_t row = objects.find(entry.index, entry.sub, why);
  if (row == kObjects) return why;
  const Object& object = kObjectTable[row];
  const Mappable wanted = transmit ? Mappable::Tpdo : Mappable::Rpdo;
  if (object.mappable != wanted && object.mappable != Mappable::Both) return Abort::NotMappable;
  return entry.bits == 8U * static_cast<std::size_t>(size_of(object.type)) ? Abort::None : Abort::NotMappable;
}

Abort check_count(const Dictionary& objects, std::size_t row, std::int64_t count, bool transmit, bool dummies) noexcept {
  if (count > kMappedObjects) return Abort::PdoTooLong;
  std::size_t bits = 0;
  for (std::size_t k = 1; k <= static_cast<std::size_t>(count); ++k) {
    const Entry entry(objects.get(row + k));
    if (const Abort abort = check_entry(objects, entry, transmit, dummies); abort != Abort::None) return abort;
    bits += entry.bits;
  }
  return bits <= kMostBits ? Abort::None : Abort::PdoTooLong;
}

/// CAN identifiers that CiA 301 keeps for other services.
bool is_restricted(std::int64_t id) noexcept {
  return id <= 0x7F || id == 0x80 || (id >= 0x101 && id <= 0x180) || (id >= 0x581 && id <= 0x5FF) ||
         (id >= 0x601 && id <= 0x67F) || (id >= 0x6E0 && id <= 0x6FF) || id >= 0x701;
}

Abort check_communication(const Dictionary& objects, std::size_t row, std::int64_t value, std::int64_t cob_id,
                          bool transmit) noexcept {
  const bool valid = (cob_id & kPdoInvalid) == 0;
  switch (kObjectTable[row].sub) {
    case 1:
      if (transmit && (value & (kPdoInvalid | kPdoNoRemote)) == 0) return Abort::ValueRange;
      return check_cob_id(objects.get(row), value);
    case 2:
      return value <= kLastCyclic || value >= kFirstEvent ? Abort::None : Abort::ValueRange;
    case 3:
    case 6:
      return transmit && valid ? Abort::DeviceState : Abort::None;
    default:
      return Abort::None;
  }
}

PdoMap resolve(const Dictionary& objects, std::size_t row) noexcept {
  PdoMap map;
  map.count = std::min(static_cast<std::size_t>(objects.get(row)), map.fields.size());
  for (std::size_t k = 0; k < map.count; ++k) {
    const Entry entry(objects.get(row + 1 + k));
    const std::size_t bytes = entry.bits / 8;
    map.fields[k] = {entry.is_dummy() ? kObjects : find_row(entry.index, entry.sub), bytes};
    map.bytes += bytes;
  }
  return map;
}

}  // namespace

Abort check_cob_id(std::int64_t old, std::int64_t value) noexcept {
  if ((value & kPdoInvalid) != 0) return Abort::None;
  if ((value & 0x3FFFF800) != 0 || is_restricted(value & 0x7FF)) return Abort::ValueRange;
  const bool was_valid = (old & kPdoInvalid) == 0;
  return was_valid && (value & 0x7FF) != (old & 0x7FF) ? Abort::ValueRange : Abort::None;
}

Abort check_pdo_write(const Dictionary& objects, std::size_t row, std::int64_t value, bool operational,
                      bool dummy_mapping) noexcept {
  const Object& object = kObjectTable[row];
  const bool transmit = object.index >= kTransmit;
  const bool mapping = (object.index & kToMapping) != 0;
  const auto parameters = static_cast<std::uint16_t>(mapping ? object.index - kToMapping : object.index);
  const std::int64_t cob_id = objects.get(find_row(parameters, 1));
  if (!mapping) {
    if (operational && object.sub == 1 && value != cob_id) return Abort::DeviceState;
    return check_communication(objects, row, value, cob_id, transmit);
  }
  if (operational || (cob_id & kPdoInvalid) == 0) return Abort::DeviceState;
  if (object.sub == 0) return check_count(objects, row, value, transmit, dummy_mapping);
  if (objects.get(row - object.sub) != 0) return Abort::SubZeroFirst;
  return value == 0 ? Abort::None : check_entry(objects, Entry(value), transmit, dummy_mapping);
}

void ReceivePdos::configure(const Dictionary& objects) noexcept {
  for (int k = 0; k < kPdos; ++k) configure(objects, k);
}

void ReceivePdos::configure(const Dictionary& objects, int k) noexcept {
  Pdo& pdo = pdos_[static_cast<std::size_t>(k)];
  const std::int64_t id = objects.get(row_at(kReceive, k, 1));
  pdo = {};
  pdo.id = static_cast<std::uint32_t>(id & 0x7FF);
  pdo.valid = (id & kPdoInvalid) == 0;
  pdo.synchronous = objects.get(row_at(kReceive, k, 2)) <= kLastCyclic;
  pdo.map = resolve(objects, row_at(kReceive + kToMapping, k, 0));
}

bool ReceivePdos::takes(std::uint32_t id) const noexcept {
  return std::any_of(pdos_.begin(), pdos_.end(), [id](const Pdo& pdo) { return pdo.valid && pdo.id == id; });
}

ReceivePdos::Outcome ReceivePdos::receive(Dictionary& objects, const can::Frame& frame, std::int64_t now_ns) noexcept {
  for (Pdo& pdo : pdos_) {
    if (!pdo.valid || pdo.id != frame.id || frame.remote) continue;
    if (frame.size < pdo.map.bytes) return Outcome::TooShort;
    pdo.frame = frame;
    pdo.last_ns = now_ns;
    pdo.monitored = true;
    pdo.waits = pdo.synchronous;
    if (!pdo.synchronous) write(objects, pdo);
    if (frame.size > pdo.map.bytes) return Outcome::TooLong;
    return pdo.synchronous ? Outcome::Waits : Outcome::Active;
  }
  return Outcome::NotMine;
}

void ReceivePdos::write(Dictionary& objects, const Pdo& pdo) noexcept {
  std::size_t place = 0;
  for (std::size_t k = 0; k < pdo.map.count; ++k) {
    const PdoMap::Field& field = pdo.map.fields[k];
    const auto bytes = std::span(pdo.frame.data).subspan(place, field.bytes);
    if (field.row != kObjects) objects.set(field.row, Dictionary::decode(kObjectTable[field.row].type, bytes));
    place += field.bytes;
  }
}

int ReceivePdos::activate(Dictionary& objects) noexcept {
  int count = 0;
  for (Pdo& pdo : pdos_) {
    if (!pdo.waits) continue;
    pdo.waits = false;
    write(objects, pdo);
    ++count;
  }
  return count;
}

int ReceivePdos::expired(const Dictionary& objects, std::int64_t now_ns) noexcept {
  for (int k = 0; k < kPdos; ++k) {
    Pdo& pdo = pdos_[static_cast<std::size_t>(k)];
    const std::size_t row = row_at(kReceive, k, 5);
    const std::int64_t deadline_ns = objects.has(row) ? objects.get(row) * kMs : 0;
    if (!pdo.valid || !pdo.monitored || deadline_ns == 0 || now_ns - pdo.last_ns <= deadline_ns) continue;
    pdo.monitored = false;
    return k + 1;
  }
  return 0;
}

void TransmitPdos::configure(const Dictionary& objects) noexcept {
  for (int k = 0; k < kPdos; ++k) configure(objects, k);
}

void TransmitPdos::configure(const Dictionary& objects, int k) noexcept {
  Pdo& pdo = pdos_[static_cast<std::size_t>(k)];
  const auto parameter = [&](std::uint8_t sub) { return objects.get(row_at(kTransmit, k, sub)); };
  pdo = {};
  pdo.id = static_cast<std::uint32_t>(parameter(1) & 0x7FF);
  pdo.valid = (parameter(1) & kPdoInvalid) == 0;
  pdo.type = static_cast<unsigned>(parameter(2));
  pdo.inhibit_ns = parameter(3) * kInhibitUnit_ns;
  pdo.event_ns = parameter(5) * kMs;
  pdo.start = static_cast<unsigned>(parameter(6));
  pdo.map = resolve(objects, row_at(kTransmit + kToMapping, k, 0));
}

bool TransmitPdos::event_driven() const noexcept {
  return std::any_of(pdos_.begin(), pdos_.end(), [](const Pdo& pdo) { return pdo.valid && pdo.type >= kFirstEvent; });
}

unsigned TransmitPdos::on_sync(const Dictionary& objects, unsigned counter) noexcept {
  unsigned due = 0;
  for (unsigned k = 0; k < kPdos; ++k) {
    Pdo& pdo = pdos_[k];
    if (!pdo.valid || pdo.type > kLastCyclic) continue;
    if (pdo.start != 0 && counter != 0) {
      if (counter != pdo.start) continue;
      pdo.elapsed = pdo.type;  // the first SYNC that is answered
    } else {
      ++pdo.elapsed;
    }
    pdo.start = 0;
    const bool changed = pdo.type == 0 && (!pdo.sent || !(encode(objects, pdo) == pdo.frame));
    if (changed || (pdo.type != 0 && pdo.elapsed >= pdo.type)) {
      pdo.elapsed = 0;
      due |= 1U << k;
    }
  }
  return due;
}

unsigned TransmitPdos::on_time(const Dictionary& objects, std::int64_t now_ns) noexcept {
  unsigned due = 0;
  for (unsigned k = 0; k < kPdos; ++k) {
    const Pdo& pdo = pdos_[k];
    if (!pdo.valid || pdo.type < kFirstEvent) continue;
    if (pdo.sent && now_ns - pdo.last_ns < pdo.inhibit_ns) continue;
    const bool timer = pdo.event_ns != 0 && now_ns - pdo.last_ns >= pdo.event_ns;
    if (!pdo.sent || timer || !(encode(objects, pdo) == pdo.frame)) due |= 1U << k;
  }
  return due;
}

can::Frame TransmitPdos::sample(const Dictionary& objects, int pdo, std::int64_t now_ns) noexcept {
  Pdo& chosen = pdos_[static_cast<std::size_t>(pdo)];
  chosen.frame = encode(objects, chosen);
  chosen.sent = true;
  chosen.last_ns = now_ns;
  return chosen.frame;
}

can::Frame TransmitPdos::encode(const Dictionary& objects, const Pdo& pdo) noexcept {
  can::Frame frame;
  frame.id = pdo.id;
  for (std::size_t k = 0; k < pdo.map.count; ++k) {
    const auto room = std::span(frame.data).subspan(frame.size, pdo.map.fields[k].bytes);
    frame.size = static_cast<std::uint8_t>(frame.size + objects.encode(pdo.map.fields[k].row, room));
  }
  return frame;
}

}  // namespace glenoid::drives
