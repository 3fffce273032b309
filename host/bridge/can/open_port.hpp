#pragma once

// Buses by name.

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "host/bridge/can/port.hpp"

namespace glenoid::can {

class MemoryBus;

/// Frames with (id & mask) == (Filter::id & mask) pass. 11-bit data frames only.
struct Filter {
  std::uint32_t id = 0;
  std::uint32_t mask = 0x7FF;
  friend bool operator==(const Filter&, const Filter&) = default;
};

/// What a master of these CANopen nodes has to hear: SYNC, EMCY, TPDO1..4, SDO answers and heartbeats of them, and the
/// echoes of what it sends to them itself.
std::vector<Filter> master_filters(std::span<const std::uint8_t> nodes, std::uint8_t master_id);
/// What these nodes have to hear: NMT, SYNC, their RPDO1..4 and SDO requests, and the master's heartbeat.
std::vector<Filter> drive_filters(std::span<const std::uint8_t> nodes, std::uint8_t master_id);

struct PortOptions {
  std::vector<Filter> filters{};  ///< empty: everything; error frames always pass
  bool echo = true;               ///< own frames come back through `receive`, marked, when they reached the bus
  int receive_buffer_bytes = 1024 * 1024;  ///< of the kernel; it may grant less
  MemoryBus* memory = nullptr;             ///< the bus that `memory:` joins; must outlive the port
};

/// Opens a bus:
///
///     socketcan:vcan0         a CAN interface of this machine
///     udp:239.74.163.2        python-can's udp_multicast; port 43113, or udp:GROUP:PORT. Frames stay on this machine.
///     memory:                 a bus inside this thread, PortOptions::memory
///
/// @throws std::invalid_argument  the URL is none of these.
/// @throws std::runtime_error     the bus cannot be opened; the text says what is missing.
std::unique_ptr<Port> open_port(std::string_view url, const PortOptions& options = {});

/// Whether no frame of this bus can reach hardware: memory:, udp:, or a SocketCAN interface of kind vcan or vxcan.
/// False where it cannot be found out.
[[nodiscard]] bool is_virtual(std::string_view url) noexcept;

}  // namespace glenoid::can
