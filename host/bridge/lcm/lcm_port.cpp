#include "host/bridge/lcm/lcm_port.hpp"

#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <ctime>
#include <lcm/lcm-cpp.hpp>
#include <stdexcept>
#include <thread>
#include <utility>

#include "host/bridge/can/descriptor.hpp"
#include "host/bridge/can/multicast.hpp"
#include "host/bridge/lcm/ring.hpp"

namespace glenoid::lcm_port {
namespace {

// LCM's own queue keeps the oldest messages and drops the newest. It is drained at once, so this is only what a thread that
// gets no processor for a while may be behind.
constexpr int kQueueCapacity = 4096;
constexpr int kPollTimeout_ms = 200;
constexpr std::int64_t kStatusesPerDevice = 5;  // ten statuses a second

std::int64_t clock_ns(clockid_t clock) noexcept {
  timespec time{};
  ::clock_gettime(clock, &time);
  return time.tv_sec * 1'000'000'000 + time.tv_nsec;
}

can::Descriptor make_bell() {
  can::Descriptor bell(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
  if (!bell.valid()) throw std::runtime_error("eventfd failed");
  return bell;
}

void ring(const can::Descriptor& bell) noexcept {
  const std::uint64_t one = 1;
  // Fails only where 2^64 - 2 rings were not heard, and then it is heard anyway.
  [[maybe_unused]] const auto written = ::write(bell.get(), &one, sizeof one);
}

void silence(const can::Descriptor& bell) noexcept {
  std::uint64_t rings = 0;
  [[maybe_unused]] const auto read = ::read(bell.get(), &rings, sizeof rings);
}

struct ToldFeedback {
  bridge::Feedback feedback;
  bridge::State state = bridge::State::Idle;
};

}  // namespace

class LcmPort::Implementation {
 public:
  explicit Implementation(const LcmOptions& options)
      : device_(options.device), lcm_(checked_url(options.url, options.allow_network)) {
    if (!lcm_.good()) {
      throw std::runtime_error("LCM " + options.url + ": cannot be opened; " + std::string(can::kMulticastHint));
    }
    hearing_ = std::thread([this, priority = options.hearing_priority] { hear(priority); });
    telling_ = std::thread([this] { tell(); });
  }

  ~Implementation() {
    stop_.store(true);
    ring(hearing_bell_);
    ring(telling_bell_);
    hearing_.join();
    telling_.join();
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  Inbox inbox_;
  Ring<ToldFeedback, 256> feedback_;
  Ring<bridge::Status, 16> status_;
  Ring<bridge::Event, 256> events_;
  Ring<bridge::Figures, 4> figures_;
  LcmCounters dropped_;
  std::atomic<std::uint64_t> publish_failed_ = 0;
  bool queued_ = false;
  can::Descriptor telling_bell_ = make_bell();

 private:
  static void on_setpoint(const lcm::ReceiveBuffer* buffer, const std::string&, Implementation* self) {
    self->inbox_.hear_setpoint(buffer->data, buffer->data_size, clock_ns(CLOCK_MONOTONIC));
  }
  static void on_command(const lcm::ReceiveBuffer* buffer, const std::string&, Implementation* self) {
    self->inbox_.hear_command(buffer->data, buffer->data_size);
  }

  // LCM starts a thread of its own at the first subscription, with the scheduling of the one that subscribes.
  void hear(int priority) {
    if (priority > 0) {
      const sched_param parameters{priority};
      ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters);
    }
    lcm_.subscribeFunction(kSetpointChannel, &on_setpoint, this)->setQueueCapacity(kQueueCapacity);
    lcm_.subscribeFunction(kCommandChannel, &on_command, this)->setQueueCapacity(kQueueCapacity);
    std::array<pollfd, 2> wait = {{{lcm_.getFileno(), POLLIN, 0}, {hearing_bell_.get(), POLLIN, 0}}};
    while (!stop_.load()) {
      ::poll(wait.data(), wait.size(), kPollTimeout_ms);
      while (!stop_.load() && lcm_.handleTimeout(0) > 0) {
      }
    }
  }

  void tell() {
    pollfd wait = {telling_bell_.get(), POLLIN, 0};
    while (!stop_.load()) {
      ::poll(&wait, 1, kPollTimeout_ms);
      silence(telling_bell_);
      publish_all();
    }
    publish_all();
  }

  void publish_all() {
    ToldFeedback told;
    while (feedback_.pop(told)) publish(kFeedbackChannel, to_wire(told.feedback, told.state));
    bridge::Event event;
    while (events_.pop(event)) publish(kEventChannel, to_wire(event));
    bridge::Figures figures;
    while (figures_.pop(figures)) publish(kFiguresChannel, to_wire(figures));
    bridge::Status status;
    while (status_.pop(status)) {
      const std::int64_t shift_ns = clock_ns(CLOCK_REALTIME) - clock_ns(CLOCK_MONOTONIC);
      publish(kStatusChannel, to_wire(status, device_, status.time_ns + shift_ns));
      if (status.sequence % kStatusesPerDevice == 1) publish(kDeviceChannel, to_wire(device_, status.time_ns));
    }
  }

  template <class Message>
  void publish(const char* channel, const Message& message) {
    if (lcm_.publish(channel, &message) != 0) publish_failed_.fetch_add(1, std::memory_order_relaxed);
  }

  Device device_;
  lcm::LCM lcm_;
  can::Descriptor hearing_bell_ = make_bell();
  std::atomic<bool> stop_ = false;
  std::thread hearing_, telling_;
};

LcmPort::LcmPort(const LcmOptions& options) : implementation_(std::make_unique<Implementation>(options)) {}
LcmPort::~LcmPort() = default;

std::size_t LcmPort::take_setpoints(std::span<bridge::Setpoint, Inbox::kNewest> into) noexcept {
  return implementation_->inbox_.take_setpoints(into);
}
std::size_t LcmPort::take_commands(std::span<bridge::Command> into) noexcept {
  return implementation_->inbox_.take_commands(into);
}
std::int64_t LcmPort::take_undecodable() noexcept { return implementation_->inbox_.take_undecodable(); }

bool LcmPort::tell(const bridge::Feedback& feedback, bridge::State state) noexcept {
  implementation_->queued_ = true;
  const bool taken = implementation_->feedback_.push({feedback, state});
  implementation_->dropped_.feedback_dropped += taken ? 0 : 1;
  return taken;
}

bool LcmPort::tell(const bridge::Status& status) noexcept {
  implementation_->queued_ = true;
  const bool taken = implementation_->status_.push(status);
  implementation_->dropped_.status_dropped += taken ? 0 : 1;
  return taken;
}

bool LcmPort::tell(const bridge::Event& event) noexcept {
  implementation_->queued_ = true;
  const bool taken = implementation_->events_.push(event);
  implementation_->dropped_.events_dropped += taken ? 0 : 1;
  return taken;
}

void LcmPort::tell(const bridge::Figures& figures) noexcept {
  implementation_->figures_.push(figures);  // where the telling thread cannot keep up, the next one says it all again
  ring(implementation_->telling_bell_);
}

void LcmPort::flush() noexcept {
  if (!std::exchange(implementation_->queued_, false)) return;
  ring(implementation_->telling_bell_);
}

LcmCounters LcmPort::counters() const noexcept {
  LcmCounters out = implementation_->dropped_;
  out.publish_failed = implementation_->publish_failed_.load(std::memory_order_relaxed);
  return out;
}

const Inbox& LcmPort::inbox() const noexcept { return implementation_->inbox_; }

}  // namespace glenoid::lcm_port
