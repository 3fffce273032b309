#include "host/bridge/can/memory_bus.hpp"

#include <algorithm>

#include "host/bridge/can/filter.hpp"
#include "host/bridge/can/queue.hpp"

namespace glenoid::can {

class MemoryBus::Endpoint final : public Port {
 public:
  Endpoint(MemoryBus& bus, const PortOptions& options)
      : bus_(bus),
        filters_(options.filters),
        echo_(options.echo),
        waiting_(bus.settings_.transmit_queue),
        arrived_(bus.settings_.receive_queue) {
    bus_.endpoints_.push_back(this);
  }
  ~Endpoint() override { std::erase(bus_.endpoints_, this); }
  Endpoint(const Endpoint&) = delete;
  Endpoint& operator=(const Endpoint&) = delete;

  std::size_t send(std::span<const Frame> frames) noexcept override {
    std::size_t taken = 0;
    while (taken < frames.size() && take(frames[taken])) ++taken;
    counters_.sent += taken;
    counters_.refused += frames.size() - taken;
    return taken;
  }

  std::size_t receive(std::span<Received> into) noexcept override {
    std::size_t count = 0;
    while (count < into.size() && !arrived_.empty()) into[count++] = arrived_.pop();
    return count;
  }

  [[nodiscard]] std::size_t outstanding() const noexcept override { return waiting_.size(); }
  bool purge() noexcept override {
    if (bus_.settings_.can_purge) waiting_.clear();
    return waiting_.empty();
  }
  [[nodiscard]] Link link() const noexcept override { return bus_.link_; }
  [[nodiscard]] PortCounters counters() const noexcept override { return counters_; }
  [[nodiscard]] int descriptor() const noexcept override { return -1; }

  /// A frame that reached the bus, from this port or another.
  void hear(const Received& received) noexcept {
    if (received.own) ++counters_.echoed;
    if ((received.own && !echo_) || !passes(filters_, received.frame)) return;
    if (!arrived_.push(received)) {
      ++counters_.overruns;
    } else if (!received.own) {
      ++counters_.received;
    }
  }
  void let_out() noexcept {
    while (!waiting_.empty()) bus_.deliver(waiting_.pop(), *this);
  }
  void drop() noexcept { waiting_.clear(); }

 private:
  bool take(const Frame& frame) noexcept {
    if (bus_.link_ != Link::Up) return false;
    if (bus_.stalled_) return waiting_.push(frame);
    bus_.deliver(frame, *this);
    return true;
  }

  MemoryBus& bus_;
  std::vector<Filter> filters_;
  bool echo_;
  Queue<Frame> waiting_;
  Queue<Received> arrived_;
  PortCounters counters_;
};

MemoryBus::MemoryBus(const Settings& settings) : settings_(settings) {}
MemoryBus::~MemoryBus() = default;

std::unique_ptr<Port> MemoryBus::connect(const PortOptions& options) {
  return std::make_unique<Endpoint>(*this, options);
}

void MemoryBus::stall(bool on) noexcept {
  stalled_ = on;
  if (on) return;
  for (Endpoint* endpoint : endpoints_) endpoint->let_out();
}

void MemoryBus::set_link(Link link) noexcept {
  link_ = link;
  if (link == Link::Up) return;
  for (Endpoint* endpoint : endpoints_) endpoint->drop();
}

void MemoryBus::deliver(const Frame& frame, const Endpoint& from) noexcept {
  for (Endpoint* endpoint : endpoints_) endpoint->hear({frame, time_ns_, endpoint == &from});
}

}  // namespace glenoid::can
