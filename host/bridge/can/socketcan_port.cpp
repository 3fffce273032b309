#include "host/bridge/can/socketcan_port.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

#include "host/bridge/can/descriptor.hpp"
#include "host/bridge/can/interface.hpp"
#include "host/bridge/can/socket_port.hpp"

namespace glenoid::can {
namespace {

can_frame to_kernel(const Frame& frame) noexcept {
  can_frame out{};
  out.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0u) | (frame.remote ? CAN_RTR_FLAG : 0u) |
               (frame.error ? CAN_ERR_FLAG : 0u);
  out.can_dlc = frame.size;
  std::memcpy(out.data, frame.data.data(), sizeof out.data);
  return out;
}

Frame from_kernel(const can_frame& in) noexcept {
  Frame out;
  out.error = (in.can_id & CAN_ERR_FLAG) != 0;
  out.extended = !out.error && (in.can_id & CAN_EFF_FLAG) != 0;
  out.remote = (in.can_id & CAN_RTR_FLAG) != 0;
  out.id = in.can_id & (out.extended || out.error ? CAN_EFF_MASK : CAN_SFF_MASK);
  out.size = std::min<std::uint8_t>(in.can_dlc, CAN_MAX_DLEN);
  if (!out.remote) std::memcpy(out.data.data(), in.data, out.size);
  return out;
}

Descriptor open_socket() {
  Descriptor descriptor(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (descriptor.valid()) return descriptor;
  const char* hint = errno == EAFNOSUPPORT || errno == EPROTONOSUPPORT
                         ? "this kernel has no CAN (modprobe can_raw, or use udp:239.74.163.2)"
                         : "";
  throw std::runtime_error(failure("CAN socket", errno, hint));
}

void require(bool done, std::string_view what) {
  if (!done) throw std::runtime_error(failure(std::string("SocketCAN, ") + std::string(what), errno));
}

std::vector<can_filter> to_kernel(const std::vector<Filter>& filters) {
  std::vector<can_filter> out;
  // The flags in the mask: neither extended nor remote frames of that number.
  for (const Filter& filter : filters) out.push_back({filter.id, filter.mask | CAN_EFF_FLAG | CAN_RTR_FLAG});
  if (out.empty()) out.push_back({0, 0});
  return out;
}

class SocketCanPort final : public SocketPort {
 public:
  SocketCanPort(std::string_view name, const PortOptions& options)
      : interface_(name), filters_(to_kernel(options.filters)), echo_(options.echo), socket_(open_socket()) {
    prepare_reception(socket_.get(), options.receive_buffer_bytes);
    require(set_filters(), "filters (at most 512)");
    require(set_option(socket_.get(), SOL_CAN_RAW, CAN_RAW_ERR_FILTER, static_cast<int>(CAN_ERR_MASK)), "error frames");
    require(set_option(socket_.get(), SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, 1), "echoes");
    if (!bind()) throw std::runtime_error(failure("socketcan:" + std::string(name), errno, "ip link show type can"));
    link_ = interface_.link(socket_.get());
  }

  std::size_t receive(std::span<Received> into) noexcept override {
    if (link_ != Link::Up) look_for_interface();
    return SocketPort::receive(into);
  }

  [[nodiscard]] std::size_t outstanding() const noexcept override {
    const std::uint64_t accounted = counters_.echoed + purged_;
    return counters_.sent > accounted ? static_cast<std::size_t>(counters_.sent - accounted) : 0;
  }

  bool purge() noexcept override {
    if (interface_.link(socket_.get()) == Link::Up) {
      if (!interface_.set_up(socket_.get(), false)) return false;
      drop_received();
      if (!interface_.set_up(socket_.get(), true)) link_ = Link::Down;
    } else {
      drop_received();
    }
    purged_ += outstanding();
    return true;
  }

  [[nodiscard]] int descriptor() const noexcept override { return socket_.get(); }

 private:
  static constexpr int kMostRounds = 1024;  // receive buffers end before

  bool set_filters() noexcept {
    const auto bytes = static_cast<socklen_t>(filters_.size() * sizeof filters_[0]);
    return ::setsockopt(socket_.get(), SOL_CAN_RAW, CAN_RAW_FILTER, filters_.data(), bytes) == 0;
  }

  bool bind() noexcept {
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = interface_.index(socket_.get());
    if (address.can_ifindex == 0) return false;  // 0 would bind to every interface
    return ::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }

  void write(std::size_t k, const Frame& frame) noexcept override {
    frames_[k] = to_kernel(frame);
    outgoing_.set(k, {reinterpret_cast<const char*>(&frames_[k]), sizeof frames_[k]});
  }

  std::size_t flush(std::size_t count) noexcept override {
    const int sent = outgoing_.send(socket_.get(), count);
    if (sent < 0) note_failure(-sent);
    return sent > 0 ? static_cast<std::size_t>(sent) : 0;
  }

  bool read(std::size_t k, Received& into) noexcept override {
    const std::span<const char> payload = incoming_.payload(k);
    if (payload.size() != CAN_MTU) return false;
    can_frame frame{};
    std::memcpy(&frame, payload.data(), sizeof frame);
    const bool own = (incoming_.flags(k) & MSG_CONFIRM) != 0;
    if (own) ++counters_.echoed;
    if (own && !echo_) return false;
    if (!own) ++counters_.received;
    into = {from_kernel(frame), incoming_.time_ns(k), own};
    return true;
  }

  void note_failure(int error) noexcept override {
    if (error == ENETDOWN) link_ = Link::Down;
    if (error == ENODEV || error == ENXIO || error == EADDRNOTAVAIL) link_ = Link::Gone;
  }

  void look_for_interface() noexcept {
    const Link now = interface_.link(socket_.get());
    // An interface that was unplugged and came back is a new one: the socket has to be bound to it again, and the kernel
    // forgot the filters with the old one.
    if (now == Link::Up && link_ == Link::Gone && !(set_filters() && bind())) return;
    link_ = now == Link::Down && link_ == Link::Gone ? Link::Gone : now;
  }

  /// What waits to be read, unread; own echoes count.
  void drop_received() noexcept {
    Received ignored;
    for (int round = 0; round < kMostRounds; ++round) {
      const int arrived = incoming_.receive(socket_.get(), ReceiveBatch::kSlots);
      for (int k = 0; k < arrived; ++k) read(static_cast<std::size_t>(k), ignored);
      if (arrived == 0) return;  // a failure is the word that the interface went off; frames may be left behind it
    }
  }

  Interface interface_;
  std::vector<can_filter> filters_;
  bool echo_;
  Descriptor socket_;
  std::array<can_frame, SendBatch::kSlots> frames_{};
  std::uint64_t purged_ = 0;
};

}  // namespace

std::unique_ptr<Port> open_socketcan(std::string_view interface, const PortOptions& options) {
  return std::make_unique<SocketCanPort>(interface, options);
}

bool is_virtual_interface(std::string_view interface) noexcept try {
  const Descriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  return Interface(interface).is_virtual(socket.get());
} catch (...) {
  return false;
}

}  // namespace glenoid::can
