#include <arpa/inet.h>

#include <stdexcept>

#include "host/bridge/can/multicast.hpp"
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
  in_addr address{};
  if (::inet_pton(AF_INET, group.c_str(), &address) != 1 || can::stays_on_loopback(address)) return {};
  return "the route of " + group +
         " does not go to lo: messages could leave this machine when its interfaces change; "
         "ip route add 224.0.0.0/4 dev lo, before programs that are to hear it start";
}

}  // namespace glenoid::lcm_port
