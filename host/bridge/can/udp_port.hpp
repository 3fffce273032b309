#pragma once

#include <memory>
#include <string_view>

#include "host/bridge/can/open_port.hpp"

namespace glenoid::can {

/// A bus of python-can's kind udp_multicast on this machine: IPv4 group, time to live 0, datagrams of other hosts ignored.
/// Every frame reaches all ports of the group at once, so nothing is ever outstanding; the kernel drops what a slow reader
/// leaves lying (counted).
///
/// @param address  GROUP or GROUP:PORT, port 43113 if not given.
/// @throws std::invalid_argument  not a multicast address; std::runtime_error  sockets or routes are missing.
std::unique_ptr<Port> open_udp(std::string_view address, const PortOptions& options);

}  // namespace glenoid::can
