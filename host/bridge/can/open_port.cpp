#include "host/bridge/can/open_port.hpp"

#include <array>
#include <stdexcept>
#include <string>

#include "host/bridge/can/memory_bus.hpp"
#include "host/bridge/can/socketcan_port.hpp"
#include "host/bridge/can/udp_port.hpp"

namespace glenoid::can {
namespace {

constexpr std::string_view kSocketCan = "socketcan:", kUdp = "udp:", kMemory = "memory:";

// CiA 301, predefined connection set.
constexpr std::uint32_t kNmt = 0x000, kSync = 0x080, kEmergency = 0x080, kSdoAnswer = 0x580, kSdoRequest = 0x600;
constexpr std::uint32_t kHeartbeat = 0x700;
constexpr std::array<std::uint32_t, 4> kTpdo = {0x180, 0x280, 0x380, 0x480};
constexpr std::array<std::uint32_t, 4> kRpdo = {0x200, 0x300, 0x400, 0x500};

std::vector<Filter> common(std::uint8_t master_id) { return {{kNmt}, {kSync}, {kHeartbeat + master_id}}; }

void add_received_by_drive(std::vector<Filter>& filters, std::uint8_t node) {
  for (const std::uint32_t base : kRpdo) filters.push_back({base + node});
  filters.push_back({kSdoRequest + node});
}

}  // namespace

std::vector<Filter> drive_filters(std::span<const std::uint8_t> nodes, std::uint8_t master_id) {
  std::vector<Filter> filters = common(master_id);
  for (const std::uint8_t node : nodes) add_received_by_drive(filters, node);
  return filters;
}

std::vector<Filter> master_filters(std::span<const std::uint8_t> nodes, std::uint8_t master_id) {
  std::vector<Filter> filters = drive_filters(nodes, master_id);
  for (const std::uint8_t node : nodes) {
    for (const std::uint32_t base : kTpdo) filters.push_back({base + node});
    for (const std::uint32_t base : {kEmergency, kSdoAnswer, kHeartbeat}) filters.push_back({base + node});
  }
  return filters;
}

std::unique_ptr<Port> open_port(std::string_view url, const PortOptions& options) {
  if (url.starts_with(kSocketCan)) return open_socketcan(url.substr(kSocketCan.size()), options);
  if (url.starts_with(kUdp)) return open_udp(url.substr(kUdp.size()), options);
  if (url == kMemory) {
    if (options.memory != nullptr) return options.memory->connect(options);
    throw std::invalid_argument("memory: is a bus inside one program; it has to be given one");
  }
  throw std::invalid_argument("bus '" + std::string(url) +
                              "': must be socketcan:INTERFACE, udp:GROUP[:PORT] or memory:");
}

bool is_virtual(std::string_view url) noexcept {
  if (url.starts_with(kSocketCan)) return is_virtual_interface(url.substr(kSocketCan.size()));
  return url.starts_with(kUdp) || url.starts_with(kMemory);
}

}  // namespace glenoid::can
