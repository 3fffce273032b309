#include "host/bridge/lcm/publisher.hpp"

#include <algorithm>
#include <cmath>
#include <lcm/lcm-cpp.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "host/bridge/can/multicast.hpp"
#include "host/bridge/lcm/gate.hpp"

namespace glenoid::lcm_port {
namespace {

constexpr int kQueueCapacity = 4096;  // drained at once: LCM's queue keeps the oldest and drops the newest
constexpr std::chrono::milliseconds kAskAgain{500};

bool finite(std::span<const double> values) noexcept {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

}  // namespace

class Publisher::Implementation {
 public:
  Implementation(std::string_view url, bool allow_network) : lcm_(checked_url(url, allow_network)) {
    if (!lcm_.good())
      throw std::runtime_error("LCM " + std::string(url) + ": cannot be opened; " + std::string(can::kMulticastHint));
    lcm_.subscribeFunction(kStatusChannel, &on_status, this)->setQueueCapacity(kQueueCapacity);
    lcm_.subscribeFunction(kFeedbackChannel, &on_feedback, this)->setQueueCapacity(kQueueCapacity);
  }

  bool poll(std::chrono::milliseconds longest) {
    bool any = false;
    for (int wait = static_cast<int>(longest.count()); lcm_.handleTimeout(wait) > 0; wait = 0) any = true;
    return any;
  }

  bool request(std::int32_t command) {
    command_v1_t message{};
    message.time_mono_ns = now_ns();
    message.sequence = ++command_sequence_;
    message.session = session();
    message.command = command;
    return lcm_.publish(kCommandChannel, &message) == 0;
  }

  bool publish(std::int64_t time_ns, std::span<const double> position, std::span<const double> velocity) {
    const std::size_t count = position.size();
    if (session() == 0 || count == 0 || count > bridge::kMaxJoints || velocity.size() != count) return false;
    if (!finite(position) || !finite(velocity)) return false;
    if (std::exchange(last_session_, session()) != session()) sequence_ = 0;
    setpoint_v1_t message{};
    message.time_mono_ns = time_ns;
    message.sequence = ++sequence_;
    message.session = session();
    message.count = static_cast<std::int32_t>(count);
    message.valid_mask = static_cast<std::int32_t>((1u << count) - 1u);
    std::copy(position.begin(), position.end(), message.position_rad);
    std::copy(velocity.begin(), velocity.end(), message.velocity_rad_per_s);
    return lcm_.publish(kSetpointChannel, &message) == 0;
  }

  [[nodiscard]] std::int64_t session() const noexcept { return status_ ? status_->session : 0; }

  std::optional<status_v1_t> status_;
  std::optional<feedback_v1_t> feedback_;

 private:
  static void on_status(const lcm::ReceiveBuffer* buffer, const std::string&, Implementation* self) {
    status_v1_t message;
    if (decode(buffer->data, buffer->data_size, message) == Decoded::Ok) self->status_ = message;
  }
  static void on_feedback(const lcm::ReceiveBuffer* buffer, const std::string&, Implementation* self) {
    feedback_v1_t message;
    if (decode(buffer->data, buffer->data_size, message) == Decoded::Ok) self->feedback_ = message;
  }

  lcm::LCM lcm_;
  std::int64_t sequence_ = 0, command_sequence_ = 0, last_session_ = 0;
};

Publisher::Publisher(std::string_view url, bool allow_network)
    : implementation_(std::make_unique<Implementation>(url, allow_network)) {}
Publisher::~Publisher() = default;

bool Publisher::poll(std::chrono::milliseconds longest) { return implementation_->poll(longest); }

bool Publisher::arm(std::chrono::milliseconds longest) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end = Clock::now() + longest;
  Clock::time_point ask = Clock::now();
  implementation_->status_.reset();  // what was said before we asked does not count
  while (Clock::now() < end) {
    if (Clock::now() >= ask) {
      request(command_v1_t::ARM);
      ask += kAskAgain;
    }
    poll(std::chrono::milliseconds(20));
    if (!status()) continue;
    if (status()->state == status_v1_t::READY && session() != 0) return true;
    if (status()->state == status_v1_t::FAULT || status()->state == status_v1_t::STOP) return false;
  }
  return false;
}

bool Publisher::request(std::int32_t command) { return implementation_->request(command); }

bool Publisher::publish(std::int64_t time_ns, std::span<const double> position_rad,
                        std::span<const double> velocity_rad_per_s) {
  return implementation_->publish(time_ns, position_rad, velocity_rad_per_s);
}

std::int64_t Publisher::session() const noexcept { return implementation_->session(); }
const std::optional<status_v1_t>& Publisher::status() const noexcept { return implementation_->status_; }
const std::optional<feedback_v1_t>& Publisher::feedback() const noexcept { return implementation_->feedback_; }

std::int64_t Publisher::now_ns() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace glenoid::lcm_port
