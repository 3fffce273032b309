#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <stdexcept>

#include "host/bridge/can/descriptor.hpp"
#include "host/bridge/lcm/lcm_port.hpp"

namespace glenoid::lcm_port {
namespace {

constexpr std::string_view kUdpm = "udpm://", kMemq = "memq://", kTtl = "ttl=";

/// Value of an option behind the question mark, empty where it is not given. The last one counts, as in LCM.
std::string_view option(std::string_view url, std::string_view name) {
  std::string_view value;
  std::size_t from = url.find('?');
  while (from != std::string_view::npos) {
    const std::size_t to = url.find('&', from + 1);
    const std::string_view entry = url.substr(from + 1, to == std::string_view::npos ? to : to - from - 1);
    if (entry.starts_with(name)) value = entry.substr(name.size());
    from = to;
  }
  return value;
}

}  // namespace

std::string checked_url(std::string_view url, bool allow_network) {
  if (url.starts_with(kMemq) || allow_network) return std::string(url);
  if (!url.starts_with(kUdpm)) {
    throw std::invalid_argument("LCM URL '" + std::string(url) +
                                "': only udpm:// and memq:// stay on this machine (--allow-network)");
  }
  const std::string_view ttl = option(url, kTtl);
  if (ttl.empty()) return std::string(url) + (url.find('?') == std::string_view::npos ? "?ttl=0" : "&ttl=0");
  if (ttl != "0") {
    throw std::invalid_argument("LCM URL '" + std::string(url) +
                                "': ttl must be 0, so that setpoints stay on this machine (--allow-network)");
  }
  return std::string(url);
}

std::string route_warning(std::string_view url) {
  if (!url.starts_with(kUdpm)) return {};
  const std::string group(url.substr(kUdpm.size(), url.find_first_of(":?", kUdpm.size()) - kUdpm.size()));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(7667);
  if (::inet_pton(AF_INET, group.c_str(), &address.sin_addr) != 1) return {};
  const can::Descriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  socklen_t size = sizeof address;
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  if (::connect(socket.get(), generic, size) != 0 || ::getsockname(socket.get(), generic, &size) != 0) return {};
  // lo lends a multicast of scope link no address of its own.
  const std::uint32_t source = ntohl(address.sin_addr.s_addr);
  if (source == 0 || source >> 24 == 127) return {};
  return "the route of " + group +
         " does not go to lo: messages could leave this machine when its interfaces change; "
         "ip route add 224.0.0.0/4 dev lo";
}

}  // namespace glenoid::lcm_port
