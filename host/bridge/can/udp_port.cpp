#include "host/bridge/can/udp_port.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/udp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <ctime>
#include <stdexcept>
#include <string>
#include <utility>

#include "host/bridge/can/descriptor.hpp"
#include "host/bridge/can/filter.hpp"
#include "host/bridge/can/multicast.hpp"
#include "host/bridge/can/queue.hpp"
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
  if (!done) throw std::runtime_error(failure(std::string("udp multicast, ") + what, errno, kMulticastHint));
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

/// Whether the kernel cuts one call's bytes into datagrams (Linux 4.18): a third of the work of sending each by itself.
bool can_segment(const Descriptor& descriptor) noexcept {
  int size = 0;
  socklen_t length = sizeof size;
  return ::getsockopt(descriptor.get(), SOL_UDP, UDP_SEGMENT, &size, &length) == 0;
}

std::int64_t clock_ns(clockid_t clock) noexcept {
  timespec time{};
  ::clock_gettime(clock, &time);
  return time.tv_sec * 1'000'000'000 + time.tv_nsec;
}

/// Own frames are taken for echoed when the kernel took them: it delivers a datagram to all listeners in the same call.
class UdpPort final : public SocketPort {
 public:
  UdpPort(const sockaddr_in& group, const PortOptions& options)
      : filters_(options.filters),
        echoes_(options.echo ? kMostEchoes : 0),
        receiver_(open_receiver(group, options.receive_buffer_bytes)),
        sender_(open_sender(group)),
        own_(address_of(sender_)),
        segments_(can_segment(sender_)) {
    require(drop_from(receiver_.get(), ntohs(own_.sin_port)), "filter");
  }

  std::size_t receive(std::span<Received> into) noexcept override {
    std::size_t own = std::min(echoes_.size(), into.size());
    const std::size_t end = own + SocketPort::receive(into.subspan(own));
    // Merged by time: the place to write is never ahead of the others' frames that still have to move.
    for (std::size_t k = 0, other = own; own > 0; ++k) {
      if (other < end && into[other].time_ns < echoes_.front().time_ns) {
        into[k] = into[other++];
      } else {
        into[k] = echoes_.pop();
        --own;
      }
    }
    return end;
  }

  [[nodiscard]] std::size_t outstanding() const noexcept override { return 0; }
  bool purge() noexcept override { return true; }
  [[nodiscard]] int descriptor() const noexcept override { return receiver_.get(); }

 private:
  static constexpr std::size_t kMostEchoes = 1024;  // what nobody read by then is not missed

  void write(std::size_t k, const Frame& frame) noexcept override {
    frames_[k] = frame;
    const std::span<const char> datagram = encoder_.encode(frame, 1e-9 * static_cast<double>(clock_ns(CLOCK_REALTIME)));
    const std::size_t begin = k == 0 ? 0 : ends_[k - 1];
    std::copy(datagram.begin(), datagram.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(begin));
    ends_[k] = begin + datagram.size();
  }

  std::size_t flush(std::size_t count) noexcept override {
    const std::int64_t time_ns = clock_ns(CLOCK_MONOTONIC);
    int sent = send_runs(count);
    if (sent == -EIO && std::exchange(segments_, false)) sent = send_runs(count);  // the device computes no checksums
    if (sent < 0) {
      if (sent != -EAGAIN && sent != -ENOBUFS && sent != -EINTR) link_ = Link::Down;
      return 0;
    }
    link_ = Link::Up;
    const std::size_t taken = sent > 0 ? last_of_run_[static_cast<std::size_t>(sent) - 1] + 1 : 0;
    counters_.echoed += taken;
    for (std::size_t k = 0; k < taken; ++k)
      if (passes(filters_, frames_[k])) echoes_.push({frames_[k], time_ns, true});
    return taken;
  }

  /// Datagrams of one size that follow each other, and a shorter one behind them, go as one message.
  int send_runs(std::size_t count) noexcept {
    std::size_t runs = 0;
    for (std::size_t first = 0; first < count; first = last_of_run_[runs++] + 1) {
      std::size_t last = first;
      while (segments_ && last + 1 < count && size(last) == size(first) && size(last + 1) <= size(first)) ++last;
      last_of_run_[runs] = last;
      const std::span<const char> bytes(bytes_.data() + (first == 0 ? 0 : ends_[first - 1]),
                                        bytes_.data() + ends_[last]);
      outgoing_.set(runs, bytes, last == first ? std::uint16_t{0} : static_cast<std::uint16_t>(size(first)));
    }
    return outgoing_.send(sender_.get(), runs);
  }
  [[nodiscard]] std::size_t size(std::size_t k) const noexcept { return ends_[k] - (k == 0 ? 0 : ends_[k - 1]); }

  void note_failure(int) noexcept override {}  // of reception: a socket without connection has none that lasts

  /// False where the datagram is not for us.
  bool read(std::size_t k, Received& into) noexcept override {
    const sockaddr_in& source = incoming_.source(k);
    if ((incoming_.flags(k) & MSG_TRUNC) != 0 || source.sin_addr.s_addr != own_.sin_addr.s_addr) return false;
    const std::optional<Frame> frame = decoder_.decode(incoming_.payload(k));
    if (!frame) return false;
    if (!passes(filters_, *frame)) return false;
    ++counters_.received;
    into = {*frame, incoming_.time_ns(k), false};
    return true;
  }

  std::vector<Filter> filters_;
  Queue<Received> echoes_;
  Descriptor receiver_, sender_;
  sockaddr_in own_;
  bool segments_;
  DatagramDecoder decoder_;
  DatagramEncoder encoder_;
  std::array<Frame, SendBatch::kSlots> frames_{};
  std::array<char, SendBatch::kSlots * DatagramEncoder::kCapacity> bytes_{};
  std::array<std::size_t, SendBatch::kSlots> ends_{};  // of each datagram in bytes_
  std::array<std::size_t, SendBatch::kSlots> last_of_run_{};
};

}  // namespace

std::unique_ptr<Port> open_udp(std::string_view address, const PortOptions& options) {
  return std::make_unique<UdpPort>(parse(address), options);
}

}  // namespace glenoid::can
