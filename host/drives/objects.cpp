// SDO access to the dictionary: what a write means before and after it is done.

#include "host/drives/parts.hpp"

namespace glenoid::drives {
namespace {

constexpr std::int64_t kSave = 0x65766173, kLoad = 0x64616F6C;  // "save", "load"
constexpr std::int64_t kSyncBeyondId = 0x7FFFF800;              // producer, 29 bits: it neither sends nor takes such

bool is_pdo_parameter(const Object& object) noexcept { return object.index >= 0x1400 && object.index < 0x1C00; }

/// 1016h: each node once.
Abort check_consumer(const Dictionary& objects, std::size_t row, std::int64_t value) noexcept {
  const std::int64_t node = value >> 16;
  if (node > 0x7F) return Abort::ValueRange;
  for (std::size_t k = row_of(0x1016, 1); k < row_of(0x1016, 1) + kConsumers; ++k) {
    const bool both_used = (value & 0xFFFF) != 0 && (objects.get(k) & 0xFFFF) != 0;
    if (k != row && both_used && objects.get(k) >> 16 == node) return Abort::Incompatible;
  }
  return Abort::None;
}

}  // namespace

Abort Drive::Parts::read(std::uint16_t index, std::uint8_t sub, std::span<std::uint8_t> into,
                         std::size_t& size) noexcept {
  Abort why = Abort::None;
  const std::size_t row = objects.find(index, sub, why);
  if (row == kObjects) return why;
  if (kObjectTable[row].access == Access::Wo) return Abort::WriteOnly;
  if (index == 0x1003 && sub > objects.get(row_of(0x1003))) return Abort::NoData;
  motion.publish(objects);
  size = objects.encode(row, into);
  return Abort::None;
}

Abort Drive::Parts::writable(std::uint16_t index, std::uint8_t sub) noexcept {
  Abort why = Abort::None;
  const std::size_t row = objects.find(index, sub, why);
  if (row == kObjects) return why;
  const Access access = kObjectTable[row].access;
  return access == Access::Const || access == Access::Ro ? Abort::ReadOnly : Abort::None;
}

Abort Drive::Parts::write(std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> bytes,
                          bool size_known) noexcept {
  const std::size_t row = find_row(index, sub);
  const Type type = kObjectTable[row].type;
  if (type == Type::Text) {
    if (bytes.size() > kTextLength) return Abort::TooLong;
    std::array<char, kTextLength> characters{};
    for (std::size_t k = 0; k < bytes.size(); ++k) characters[k] = static_cast<char>(bytes[k]);
    objects.set_text(row, {characters.data(), bytes.size()});
    return Abort::None;
  }
  const auto size = static_cast<std::size_t>(size_of(type));
  if (size_known && bytes.size() > size) return Abort::TooLong;
  if (bytes.size() < size) return Abort::TooShort;
  const std::int64_t value = Dictionary::decode(type, bytes.first(size));
  if (const Abort abort = check(row, value); abort != Abort::None) return abort;
  objects.set(row, value);
  written(row);
  return Abort::None;
}

Abort Drive::Parts::check(std::size_t row, std::int64_t value) const noexcept {
  const Object& object = kObjectTable[row];
  const Range range = range_of(row);
  if (value < range.low || value > range.high) return Abort::ValueRange;
  if (is_pdo_parameter(object)) {
    return check_pdo_write(objects, row, value, nmt == Nmt::Operational, profile.dummy_mapping);
  }
  switch (object.index) {
    case 0x1005:
      return (value & kSyncBeyondId) == 0 ? Abort::None : Abort::ValueRange;
    case 0x1010:
      if (motion.power().powered()) return Abort::DeviceState;
      return value == kSave ? Abort::None : Abort::NotStored;
    case 0x1011:
      return value == kLoad ? Abort::None : Abort::NotStored;
    case 0x1014:
      return check_cob_id(objects.get(row), value);
    case 0x1016:
      return check_consumer(objects, row, value);
    case 0x1019:
      if (objects.get(row_of(0x1006)) != 0) return Abort::DeviceState;
      return value != 1 ? Abort::None : Abort::ValueRange;
    case 0x6060:
      return value == 0 || value == 8 ? Abort::None : Abort::ValueRange;
    case 0x605A:
      return value != 4 ? Abort::None : Abort::ValueRange;
    default:
      return Abort::None;
  }
}

void Drive::Parts::written(std::size_t row) noexcept {
  const Object& object = kObjectTable[row];
  if (is_pdo_parameter(object)) {
    const int pdo = object.index & (kPdos - 1);
    if (object.index < 0x1800) {
      received.configure(objects, pdo);
    } else {
      transmitted.configure(objects, pdo);
    }
    return;
  }
  switch (object.index) {
    case 0x1003:
      for (std::uint8_t k = 1; k <= kErrorHistory; ++k) objects.set(row + k, 0);
      break;
    case 0x1006:
      last_sync_ns = -1;
      break;
    case 0x1010:
      objects.set(row, kSaves);
      objects.store();
      break;
    case 0x1011:
      objects.set(row, kSaves);
      objects.forget_stored();
      break;
    case 0x1016:
      if (object.sub != 0) consumers[object.sub - 1U] = {};
      break;
    case 0x1017:
      next_heartbeat_ns = now_ns;
      break;
    case 0x2F00:
      request_waits = object.sub == 1;
      requested = {static_cast<FaultKind>(objects.get(row_of(0x2F00, 1))),
                   static_cast<std::uint32_t>(objects.get(row_of(0x2F00, 2))),
                   static_cast<std::uint32_t>(objects.get(row_of(0x2F00, 3)))};
      break;
    case 0x6040:
    case 0x6060:
      motion.control(objects, now_ns);
      break;
    default:
      break;
  }
}

}  // namespace glenoid::drives
