#include "host/bridge/can/multicast.hpp"

#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstring>

#include "host/bridge/can/descriptor.hpp"

namespace glenoid::can {
namespace {

/// Index of the interface on the route to `destination`, 0 where there is none. The address that a connected socket gets does
/// not tell: the loopback interface lends a route of scope link the address of another one.
unsigned outgoing_interface(in_addr destination) noexcept {
  struct {
    nlmsghdr head;
    rtmsg route;
    rtattr attribute;
    in_addr destination;
  } request{};
  request.head = {sizeof request, RTM_GETROUTE, NLM_F_REQUEST, 0, 0};
  request.route.rtm_family = AF_INET;
  request.route.rtm_dst_len = 32;
  request.attribute = {RTA_LENGTH(sizeof destination), RTA_DST};
  request.destination = destination;

  const Descriptor socket(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE));
  alignas(nlmsghdr) char answer[1024];
  if (::send(socket.get(), &request, sizeof request, 0) != sizeof request) return 0;
  const ssize_t size = ::recv(socket.get(), answer, sizeof answer, 0);
  const auto* head = reinterpret_cast<const nlmsghdr*>(answer);
  if (size <= 0 || !NLMSG_OK(head, static_cast<std::size_t>(size)) || head->nlmsg_type != RTM_NEWROUTE) return 0;

  std::size_t at = NLMSG_SPACE(sizeof(rtmsg));
  while (at + RTA_LENGTH(0) <= head->nlmsg_len) {
    const auto* attribute = reinterpret_cast<const rtattr*>(answer + at);
    unsigned index = 0;
    if (attribute->rta_type == RTA_OIF && at + RTA_LENGTH(sizeof index) <= head->nlmsg_len) {
      std::memcpy(&index, answer + at + RTA_LENGTH(0), sizeof index);
      return index;
    }
    at += RTA_ALIGN(std::max(attribute->rta_len, static_cast<unsigned short>(RTA_LENGTH(0))));
  }
  return 0;
}

}  // namespace

bool stays_on_loopback(in_addr group) noexcept {
  ifreq device{};
  if (::if_indextoname(outgoing_interface(group), device.ifr_name) == nullptr) return false;
  const Descriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  return ::ioctl(socket.get(), SIOCGIFFLAGS, &device) == 0 && (device.ifr_flags & IFF_LOOPBACK) != 0;
}

}  // namespace glenoid::can
