#pragma once

#include <net/if.h>

#include <string_view>

#include "host/bridge/can/port.hpp"

namespace glenoid::can {

/// A network interface by name: what the kernel says of it, and its switch.
class Interface {
 public:
  /// @throws std::invalid_argument  the name is empty or longer than the kernel allows.
  explicit Interface(std::string_view name);

  /// Index, or 0 where there is none of this name.
  [[nodiscard]] int index(int socket) const noexcept;
  [[nodiscard]] Link link(int socket) const noexcept;
  /// Switches it on or off; false without the right to.
  bool set_up(int socket, bool up) const noexcept;
  /// Whether its driver is vcan or vxcan.
  [[nodiscard]] bool is_virtual(int socket) const noexcept;

 private:
  bool ask(int socket, unsigned long request, ifreq& answer) const noexcept;

  char name_[IFNAMSIZ] = {};
};

}  // namespace glenoid::can
