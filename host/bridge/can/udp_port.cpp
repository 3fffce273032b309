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

#include "host/bridge/can/batch.hpp"
#include "host/bridge/can/descriptor.hpp"
#include "host/bridge/can/filter.hpp"
#include "host/bridge/can/udp_datagram.hpp"

namespace glenoid::can {
namespace {

constexpr std::uint16_t kDefaultPort = 43113;  // python-can's
constexpr int kMostRounds = 32;  // recvmmsg calls of one receive(): a flood of foreign datagrams must not hold it

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

class UdpPort final : public Port {
 public:
  UdpPort(const sockaddr_in& group, const PortOptions& options)
      : filters_(options.filters),
        echo_(options.echo),
        receiver_(open_receiver(group, options.receive_buffer_bytes)),
        sender_(open_sender(group)),
        own_(address_of(sender_)) {}

  std::size_t send(std::span<const Frame> frames) noexcept override {
    std::size_t taken = 0;
    while (taken < frames.size()) {
      const std::size_t count = std::min(frames.size() - taken, kBatch);
      const std::size_t done = send_batch(frames.subspan(taken, count));
      taken += done;
      if (done < count) break;
    }
    counters_.sent += taken;
    counters_.refused += frames.size() - taken;
    return taken;
  }

  std::size_t receive(std::span<Received> into) noexcept override {
    std::size_t count = 0;
    for (int round = 0; round < kMostRounds && count < into.size(); ++round) {
      const std::size_t most = std::min(into.size() - count, ReceiveBatch::kSlots);
      const int arrived = batch_.receive(receiver_.get(), most);
      for (int k = 0; k < arrived; ++k) count += read(static_cast<std::size_t>(k), into[count]) ? 1u : 0u;
      if (arrived < static_cast<int>(most)) break;
    }
    counters_.overruns = batch_.dropped();
    return count;
  }

  [[nodiscard]] std::size_t outstanding() const noexcept override { return 0; }
  bool purge() noexcept override { return true; }
  [[nodiscard]] Link link() const noexcept override { return link_; }
  [[nodiscard]] PortCounters counters() const noexcept override { return counters_; }
  [[nodiscard]] int descriptor() const noexcept override { return receiver_.get(); }

 private:
  static constexpr std::size_t kBatch = 32;

  std::size_t send_batch(std::span<const Frame> frames) noexcept {
    const double time_s = wall_clock_s();
    for (std::size_t k = 0; k < frames.size(); ++k) {
      const std::span<const char> datagram = encoders_[k].encode(frames[k], time_s);
      vectors_[k] = {const_cast<char*>(datagram.data()), datagram.size()};
      messages_[k] = {};
      messages_[k].msg_hdr.msg_iov = &vectors_[k];
      messages_[k].msg_hdr.msg_iovlen = 1;
    }
    const int sent = ::sendmmsg(sender_.get(), messages_.data(), static_cast<unsigned>(frames.size()), MSG_DONTWAIT);
    if (sent >= 0) {
      link_ = Link::Up;
      return static_cast<std::size_t>(sent);
    }
    if (errno != EAGAIN && errno != ENOBUFS && errno != EINTR) link_ = Link::Down;
    return 0;
  }

  /// False where the datagram is not for us.
  bool read(std::size_t k, Received& into) noexcept {
    const sockaddr_in& source = batch_.source(k);
    if ((batch_.flags(k) & MSG_TRUNC) != 0 || source.sin_addr.s_addr != own_.sin_addr.s_addr) return false;
    const std::optional<Frame> frame = decoder_.decode(batch_.payload(k));
    if (!frame) return false;
    const bool own = source.sin_port == own_.sin_port;
    if (own) ++counters_.echoed;
    if ((own && !echo_) || !passes(filters_, *frame)) return false;
    if (!own) ++counters_.received;
    into = {*frame, batch_.time_ns(k), own};
    return true;
  }

  std::vector<Filter> filters_;
  bool echo_;
  Descriptor receiver_, sender_;
  sockaddr_in own_;
  ReceiveBatch batch_;
  DatagramDecoder decoder_;
  std::array<DatagramEncoder, kBatch> encoders_;
  std::array<iovec, kBatch> vectors_{};
  std::array<mmsghdr, kBatch> messages_{};
  PortCounters counters_;
  Link link_ = Link::Up;
};

}  // namespace

std::unique_ptr<Port> open_udp(std::string_view address, const PortOptions& options) {
  return std::make_unique<UdpPort>(parse(address), options);
}

}  // namespace glenoid::can
