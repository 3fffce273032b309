#include "host/bridge/core/canopen.hpp"

#include <algorithm>
#include <array>

#include "host/bridge/core/bytes.hpp"

namespace glenoid::bridge::canopen {
namespace {

can::Frame frame_of(std::uint32_t id, std::uint8_t size) noexcept {
  can::Frame frame;
  frame.id = id;
  frame.size = size;
  return frame;
}

can::Frame sdo(std::uint8_t node, std::uint8_t command, std::uint16_t index, std::uint8_t subindex,
               std::uint32_t value) noexcept {
  can::Frame frame = frame_of(kSdoRequestId + node, 8);
  frame.data[0] = command;
  put_u16(frame, 1, index);
  frame.data[3] = subindex;
  put_u32(frame, 4, value);
  return frame;
}

}  // namespace

can::Frame nmt(NmtCommand command, std::uint8_t node) noexcept {
  can::Frame frame = frame_of(kNmtId, 2);
  frame.data[0] = static_cast<std::uint8_t>(command);
  frame.data[1] = node;
  return frame;
}

can::Frame sync() noexcept { return frame_of(kSyncId, 0); }

can::Frame heartbeat(std::uint8_t node, Nmt state) noexcept {
  can::Frame frame = frame_of(kHeartbeatId + node, 1);
  frame.data[0] = static_cast<std::uint8_t>(state);
  return frame;
}

can::Frame sdo_download(std::uint8_t node, std::uint16_t index, std::uint8_t subindex, std::uint8_t bytes,
                        std::uint32_t value) noexcept {
  // 2Fh, 2Bh, 27h, 23h: expedited, size given, 4 - n bytes without data
  const auto command = static_cast<std::uint8_t>(0x23 | ((4 - bytes) << 2));
  const std::uint32_t mask = bytes == 4 ? 0xFFFF'FFFFU : (1U << (8 * bytes)) - 1U;
  return sdo(node, command, index, subindex, value & mask);
}

can::Frame sdo_upload(std::uint8_t node, std::uint16_t index, std::uint8_t subindex) noexcept {
  return sdo(node, 0x40, index, subindex, 0);
}

can::Frame sdo_abort(std::uint8_t node, std::uint16_t index, std::uint8_t subindex, std::uint32_t code) noexcept {
  return sdo(node, 0x80, index, subindex, code);
}

std::optional<SdoAnswer> sdo_answer(const can::Frame& frame) noexcept {
  if (frame.size != 8 || frame.extended || frame.remote || frame.error) return std::nullopt;
  SdoAnswer answer;
  answer.index = get_u16(frame, 1);
  answer.subindex = frame.data[3];
  answer.value = get_u32(frame, 4);
  const std::uint8_t command = frame.data[0];
  if (command == 0x60) {
    answer.kind = SdoAnswer::Kind::Downloaded;
  } else if (command == 0x80) {
    answer.kind = SdoAnswer::Kind::Aborted;
  } else if ((command & 0xE2) == 0x42) {  // upload, expedited
    answer.kind = SdoAnswer::Kind::Uploaded;
    answer.bytes = (command & 0x01) != 0 ? static_cast<std::uint8_t>(4 - ((command >> 2) & 0x03)) : std::uint8_t{4};
    if (answer.bytes < 4) answer.value &= (1U << (8 * answer.bytes)) - 1U;
  }
  return answer;
}

namespace {

struct Words {
  std::uint32_t code;
  std::string_view text;
};

// CiA 301, table of SDO abort codes.
constexpr std::array kAborts = std::to_array<Words>({
    {0x0503'0000, "toggle bit not alternated"},
    {0x0504'0000, "SDO protocol timed out"},
    {0x0504'0001, "command specifier not valid"},
    {0x0504'0002, "block size not valid"},
    {0x0504'0003, "sequence number not valid"},
    {0x0504'0004, "CRC error"},
    {0x0504'0005, "out of memory"},
    {0x0601'0000, "access not supported"},
    {0x0601'0001, "object is write-only"},
    {0x0601'0002, "object is read-only"},
    {0x0602'0000, "object does not exist"},
    {0x0604'0041, "object cannot be mapped to a PDO"},
    {0x0604'0042, "mapped objects exceed the PDO length"},
    {0x0604'0043, "parameter incompatible"},
    {0x0604'0047, "device incompatible internally"},
    {0x0606'0000, "hardware error"},
    {0x0607'0010, "length of the parameter does not match"},
    {0x0607'0012, "parameter too long"},
    {0x0607'0013, "parameter too short"},
    {0x0609'0011, "sub-index does not exist"},
    {0x0609'0030, "value out of range"},
    {0x0609'0031, "value too high"},
    {0x0609'0032, "value too low"},
    {0x0609'0036, "maximum is below minimum"},
    {0x060A'0023, "resource not available"},
    {0x0800'0000, "general error"},
    {0x0800'0020, "data cannot be stored"},
    {0x0800'0021, "data cannot be stored: local control"},
    {0x0800'0022, "data cannot be stored in the present device state"},
    {0x0800'0023, "no object dictionary"},
    {0x0800'0024, "no data available"},
});

// CiA 301 and CiA 402: exact codes first, then the classes they belong to.
constexpr std::array kEmergencies = std::to_array<Words>({
    {0x0000, "error reset"},
    {0x2310, "continuous over-current"},
    {0x2320, "short circuit or earth leakage"},
    {0x3210, "DC link over-voltage"},
    {0x3220, "DC link under-voltage"},
    {0x4210, "drive over-temperature"},
    {0x4310, "motor over-temperature"},
    {0x5113, "5 V supply low"},
    {0x5441, "emergency stop input"},
    {0x6320, "parameter error"},
    {0x7121, "motor blocked"},
    {0x7305, "encoder 1"},
    {0x7306, "encoder 2"},
    {0x7380, "position sensor"},
    {0x8110, "CAN overrun: frames lost"},
    {0x8120, "CAN error passive"},
    {0x8130, "heartbeat of the master lost"},
    {0x8140, "recovered from bus-off"},
    {0x8150, "CAN identifier collision"},
    {0x8210, "PDO too short"},
    {0x8220, "PDO too long"},
    {0x8240, "SYNC of unexpected length"},
    {0x8250, "receive PDO timed out"},
    {0x8700, "SYNC missing or out of time"},
    {0x8611, "following error"},
    {0x8612, "position limit"},
});

constexpr std::array kEmergencyClasses = std::to_array<Words>({
    {0x1000, "generic error"},
    {0x2000, "current"},
    {0x3000, "voltage"},
    {0x4000, "temperature"},
    {0x5000, "device hardware"},
    {0x6000, "device software"},
    {0x7000, "additional modules"},
    {0x8000, "monitoring"},
    {0x9000, "external error"},
    {0xF000, "additional functions or vendor"},
});

template <std::size_t N>
std::string_view find(const std::array<Words, N>& table, std::uint32_t code) noexcept {
  const auto* found = std::find_if(table.begin(), table.end(), [&](const Words& entry) { return entry.code == code; });
  return found == table.end() ? std::string_view{} : found->text;
}

}  // namespace

std::string_view abort_words(std::uint32_t code) noexcept {
  const std::string_view text = find(kAborts, code);
  return text.empty() ? "unlisted abort code" : text;
}

std::string_view emergency_words(std::uint16_t code) noexcept {
  std::string_view text = find(kEmergencies, code);
  if (text.empty()) text = find(kEmergencyClasses, code & 0xF000U);
  return text.empty() ? "unlisted error code" : text;
}

std::string_view words(Nmt state) noexcept {
  switch (state) {
    case Nmt::BootUp:
      return "boot-up";
    case Nmt::Stopped:
      return "stopped";
    case Nmt::Operational:
      return "operational";
    case Nmt::PreOperational:
      return "pre-operational";
    case Nmt::Unknown:
      break;
  }
  return "unknown";
}

}  // namespace glenoid::bridge::canopen
