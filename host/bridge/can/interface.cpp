#include "host/bridge/can/interface.hpp"

#include <linux/ethtool.h>
#include <linux/sockios.h>
#include <sys/ioctl.h>

#include <cstring>
#include <stdexcept>
#include <string>

namespace glenoid::can {

Interface::Interface(std::string_view name) {
  if (name.empty() || name.size() >= sizeof name_) {
    throw std::invalid_argument("socketcan:" + std::string(name) + ": an interface's name has 1 to 15 characters");
  }
  name.copy(name_, name.size());
}

bool Interface::ask(int socket, unsigned long request, ifreq& answer) const noexcept {
  std::memcpy(answer.ifr_name, name_, sizeof name_);
  return ::ioctl(socket, request, &answer) == 0;
}

int Interface::index(int socket) const noexcept {
  ifreq answer{};
  return ask(socket, SIOCGIFINDEX, answer) ? answer.ifr_ifindex : 0;
}

Link Interface::link(int socket) const noexcept {
  ifreq answer{};
  if (!ask(socket, SIOCGIFFLAGS, answer)) return Link::Gone;
  return (answer.ifr_flags & IFF_UP) != 0 ? Link::Up : Link::Down;
}

bool Interface::set_up(int socket, bool up) const noexcept {
  ifreq request{};
  if (!ask(socket, SIOCGIFFLAGS, request)) return false;
  request.ifr_flags = static_cast<short>(up ? request.ifr_flags | IFF_UP : request.ifr_flags & ~IFF_UP);
  return ask(socket, SIOCSIFFLAGS, request);
}

bool Interface::is_virtual(int socket) const noexcept {
  ethtool_drvinfo info{};
  info.cmd = ETHTOOL_GDRVINFO;
  ifreq request{};
  request.ifr_data = reinterpret_cast<char*>(&info);
  if (!ask(socket, SIOCETHTOOL, request)) return false;
  const std::string_view driver(info.driver, ::strnlen(info.driver, sizeof info.driver));
  return driver == "vcan" || driver == "vxcan";
}

}  // namespace glenoid::can
