#pragma once

// The route of multicast, which udp: buses and LCM share.

#include <netinet/in.h>

#include <string_view>

namespace glenoid::can {

/// What helps where there is no route.
inline constexpr std::string_view
    kMulticastHint = "multicast needs a route: ip link set lo up; ip route add 224.0.0.0/4 dev lo";

/// Whether the kernel sends datagrams for this group over the loopback interface. False where it has no route for it or
/// cannot be asked.
[[nodiscard]] bool stays_on_loopback(in_addr group) noexcept;

}  // namespace glenoid::can
