#include "bus/wires_network.hpp"

#include <arpa/inet.h>
#include <net/if.h>
#include <net/route.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>

#include "host/bridge/can/descriptor.hpp"
#include "host/bridge/can/multicast.hpp"

namespace glenoid::test {
namespace {

bool loopback_up(int socket) {
  ifreq request{};
  std::strcpy(request.ifr_name, "lo");
  if (::ioctl(socket, SIOCGIFFLAGS, &request) != 0) return false;
  request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP);
  return ::ioctl(socket, SIOCSIFFLAGS, &request) == 0;
}

sockaddr address(const char* text) {
  sockaddr_in in{};
  in.sin_family = AF_INET;
  ::inet_pton(AF_INET, text, &in.sin_addr);
  sockaddr out{};
  std::memcpy(&out, &in, sizeof out);
  return out;
}

/// Multicast by the loopback interface then comes from an address that is not of 127.0.0.0/8, as where there is a network card.
bool address_of_a_network(int socket) {
  ifreq request{};
  std::strcpy(request.ifr_name, "lo:1");
  request.ifr_addr = address("192.0.2.1");
  return ::ioctl(socket, SIOCSIFADDR, &request) == 0;
}

/// 224.0.0.0/4 dev lo
bool multicast_route(int socket) {
  char device[] = "lo";
  rtentry route{};
  route.rt_dst = address("224.0.0.0");
  route.rt_genmask = address("240.0.0.0");
  route.rt_flags = RTF_UP;
  route.rt_dev = device;
  return ::ioctl(socket, SIOCADDRT, &route) == 0 || errno == EEXIST;
}

std::string make_network() {
  in_addr group{};
  ::inet_pton(AF_INET, "239.255.76.67", &group);
  if (can::stays_on_loopback(group)) return {};  // as in a network that somebody made for this
  if (::unshare(CLONE_NEWNET) != 0 && ::unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) {
    return std::string("no network namespace: ") + std::strerror(errno);
  }
  const can::Descriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!loopback_up(socket.get())) return std::string("lo cannot be switched on: ") + std::strerror(errno);
  if (!address_of_a_network(socket.get())) return std::string("lo gets no second address: ") + std::strerror(errno);
  if (!multicast_route(socket.get())) return std::string("no multicast route on lo: ") + std::strerror(errno);
  return {};
}

}  // namespace

std::string own_network() {
  static const std::string obstacle = make_network();
  return obstacle;
}

}  // namespace glenoid::test
