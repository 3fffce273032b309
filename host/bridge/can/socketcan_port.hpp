#pragma once

#include <memory>
#include <string_view>

#include "host/bridge/can/open_port.hpp"

namespace glenoid::can {

/// A CAN interface of this machine. Own frames are counted back by their echo, so `outstanding` is what still waits in the
/// queue of the interface or in the controller. ENOBUFS and EAGAIN alike: the frames are dropped. An interface that was
/// switched off or unplugged is Down or Gone until it is back; `receive` looks for it. `purge` switches the interface off
/// and on again (needs CAP_NET_ADMIN; takes the time the driver takes, milliseconds) and forgets what waits to be read.
///
/// @throws std::runtime_error  no CAN in this kernel, no such interface, or no CAN interface.
std::unique_ptr<Port> open_socketcan(std::string_view interface, const PortOptions& options);

/// Whether the kernel says that the interface is of kind vcan or vxcan.
[[nodiscard]] bool is_virtual_interface(std::string_view interface) noexcept;

}  // namespace glenoid::can
