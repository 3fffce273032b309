#include "host/bridge/can/udp_port.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <ctime>
#include <stdexcept>
#include <string>

#include "host/bridge/can/descriptor.hpp"
#include "host/bridge/can/filter.hpp"
#include "host/bridge/can/socket_port.hpp"
#include "host/bridge/can/udp_datagram.hpp"

namespace glenoid::can {
namespace {

constexpr std::uint16_t kDefaultPort = 43113;  // python-can's

sockaddr_in parse(std::string_view address) {
  const std::size_t colon = address.find(':');
  sockaddr_in out{};
  out.sin_family = AF_INET;
  std::uint16_t port = kDefaultPort;
  if (colon != std::string_view::npos) {
    const std::string_view digits = address.substr(colon + 1);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
    if (error != std::errc{} || end != digits.data() + digits.size() || port == 0) {
      throw std::invalid_argument("udp:" + std::string(address) + ": the port must be 1..65535");
    }
  }
  out.sin_port = htons(port);
  const std::string group(address.substr(0, colon));
  if (::inet_pton(AF_INET, group.c_str(), &out.sin_addr) != 1 || !IN_MULTICAST(ntohl(out.sin_addr.s_addr))) {
    throw std::invalid_argument("udp:" + std::string(address) + ": must be an IPv4 group, 224.0.0.0 to 239.255.255.255");
  }
  return out;
}

Descriptor open_socket() {
  Descriptor descriptor(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!descriptor.valid()) throw std::runtime_error(failure("UDP socket", errno));
  return descriptor;
}

void require(bool done, const char* what) {
  constexpr const char* kHint = "multicast needs a route: ip link set lo up; ip route add 224.0.0.0/4 dev lo";
  if (!done) throw std::runtime_error(failure(std::string("udp multicast, ") + what, errno, kHint));
}

Descriptor open_receiver(const sockaddr_in& group, int buffer_bytes) {
  Descriptor descriptor = open_socket();
  set_option(descriptor.get(), SOL_SOCKET, SO_REUSEADDR, 1);
  set_option(descriptor.get(), SOL_SOCKET, SO_REUSEPORT, 1);
  prepare_reception(descriptor.get(), buffer_bytes);
  require(::bind(descriptor.get(), reinterpret_cast<const sockaddr*>(&group), sizeof group) == 0, "bind");
  ip_mreq membership{group.sin_addr, {htonl(INADDR_ANY)}};
  require(::setsockopt(descriptor.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) == 0, "join");
  return descriptor;
}

// Its own socket, so that its address tells own frames from others.
Descriptor open_sender(const sockaddr_in& group) {
  Descriptor descriptor = open_socket();
  require(set_option(descriptor.get(), IPPROTO_IP, IP_MULTICAST_TTL, 0), "time to live");
  require(::connect(descriptor.get(), reinterpret_cast<const sockaddr*>(&group), sizeof group) == 0, "connect");
  return descriptor;
}

sockaddr_in address_of(const Descriptor& descriptor) {
  sockaddr_in out{};
  socklen_t size = sizeof out;
  require(::getsockname(descriptor.get(), reinterpret_cast<sockaddr*>(&out), &size) == 0, "getsockname");
  return out;
}

double wall_clock_s() noexcept {
  timespec time{};
  ::clock_gettime(CLOCK_REALTIME, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

class UdpPort final : public SocketPort {
 public:
  UdpPort(const sockaddr_in& group, const PortOptions& options)
      : filters_(options.filters),
        echo_(options.echo),
        receiver_(open_receiver(group, options.receive_buffer_bytes)),
        sender_(open_sender(group)),
        own_(address_of(sender_)) {}

  [[nodiscard]] std::size_t outstanding() const noexcept override { return 0; }
  bool purge() noexcept override { return true; }
  [[nodiscard]] int descriptor() const noexcept override { return receiver_.get(); }

 private:
  std::span<const char> write(std::size_t k, const Frame& frame) noexcept override {
    return encoders_[k].encode(frame, wall_clock_s());
  }

  std::size_t flush(std::size_t count) noexcept override {
    const int sent = outgoing_.send(sender_.get(), count);
    if (sent >= 0) {
      link_ = Link::Up;
      return static_cast<std::size_t>(sent);
    }
    if (sent != -EAGAIN && sent != -ENOBUFS && sent != -EINTR) link_ = Link::Down;
    return 0;
  }

  void note_failure(int) noexcept override {}  // of reception: a socket without connection has none that lasts

  bool read(std::size_t k, Received& into) noexcept override {
    const sockaddr_in& source = incoming_.source(k);
    if ((incoming_.flags(k) & MSG_TRUNC) != 0 || source.sin_addr.s_addr != own_.sin_addr.s_addr) return false;
    const std::optional<Frame> frame = decoder_.decode(incoming_.payload(k));
    if (!frame) return false;
    const bool own = source.sin_port == own_.sin_port;
    if (own) ++counters_.echoed;
    if ((own && !echo_) || !passes(filters_, *frame)) return false;
    if (!own) ++counters_.received;
    into = {*frame, incoming_.time_ns(k), own};
    return true;
  }

  std::vector<Filter> filters_;
  bool echo_;
  Descriptor receiver_, sender_;
  sockaddr_in own_;
  DatagramDecoder decoder_;
  std::array<DatagramEncoder, SendBatch::kSlots> encoders_;
};

}  // namespace

std::unique_ptr<Port> open_udp(std::string_view address, const PortOptions& options) {
  return std::make_unique<UdpPort>(parse(address), options);
}

}  // namespace glenoid::can
