#include "host/drives/emergency.hpp"

#include <algorithm>

namespace glenoid::drives {
namespace {

constexpr std::size_t kRegister = row_of(0x1001);
constexpr std::size_t kCount = row_of(0x1003, 0);
constexpr std::size_t kFirst = row_of(0x1003, 1);
constexpr std::int64_t kInhibitUnit_ns = 100'000;

/// Bits of 1001h for an error code; bit 0 is always set.
constexpr std::int64_t register_bits(std::uint16_t code) noexcept {
  switch (code >> 12U) {
    case 1:
      return 0x01;  // generic
    case 2:
      return 0x03;  // current
    case 3:
      return 0x05;  // voltage
    case 4:
      return 0x09;  // temperature
    case 5:
    case 6:
    case 7:
      return 0x21;  // hardware, software, modules of the device profile
    case 8:
      return (code & 0xFF00U) <= 0x8200 ? 0x11 : 0x21;  // communication, device profile
    default:
      return 0x81;  // manufacturer
  }
}

}  // namespace

void Emergency::raise(Dictionary& objects, std::uint16_t code, std::uint32_t vendor) noexcept {
  objects.set(kRegister, objects.get(kRegister) | register_bits(code));
  for (std::size_t k = kErrorHistory - 1; k > 0; --k) objects.set(kFirst + k, objects.get(kFirst + k - 1));
  objects.set(kFirst, code | static_cast<std::int64_t>(vendor & 0xFFFFU) << 16);
  objects.set(kCount, std::min<std::int64_t>(objects.get(kCount) + 1, kErrorHistory));
  queue({code, static_cast<std::uint8_t>(objects.get(kRegister)), vendor});
}

void Emergency::clear(Dictionary& objects) noexcept {
  if (objects.get(kRegister) == 0) return;
  objects.set(kRegister, 0);
  queue({});
}

void Emergency::queue(const Message& message) noexcept {
  if (count_ == waiting_.size()) return;  // the history has it
  waiting_[count_++] = message;
}

bool Emergency::next(const Dictionary& objects, std::int64_t now_ns, can::Frame& frame) noexcept {
  const std::int64_t id = objects.get(row_of(0x1014));
  if (count_ == 0 || now_ns < not_before_ns_) return false;
  const Message message = waiting_[0];
  std::copy(waiting_.begin() + 1, waiting_.end(), waiting_.begin());
  --count_;
  if ((id & kPdoInvalid) != 0) return false;
  not_before_ns_ = now_ns + objects.get(row_of(0x1015)) * kInhibitUnit_ns;
  frame = {};
  frame.id = static_cast<std::uint32_t>(id & 0x7FF);
  frame.size = 8;
  const auto low = [](std::uint32_t value, unsigned shift) { return static_cast<std::uint8_t>(value >> shift); };
  frame.data = {low(message.code, 0),   low(message.code, 8),    message.error_register,  low(message.vendor, 0),
                low(message.vendor, 8), low(message.vendor, 16), low(message.vendor, 24), 0};
  return true;
}

}  // namespace glenoid::drives
