#include "host/bridge/lcm/inbox.hpp"

#include <algorithm>
#include <optional>

#include "host/bridge/lcm/convert.hpp"

namespace glenoid::lcm_port {

Decoded Inbox::count(Decoded result) noexcept {
  heard_[static_cast<std::size_t>(result)].fetch_add(1, std::memory_order_relaxed);
  return result;
}

Decoded Inbox::hear_setpoint(const void* bytes, std::size_t size, std::int64_t arrival_ns) noexcept {
  setpoint_v1_t message;
  const Decoded result = decode(bytes, size, message);
  if (result != Decoded::Ok) {
    undecodable_.fetch_add(1, std::memory_order_relaxed);
    return count(result);
  }
  bridge::Setpoint& setpoint = window_.setpoints[window_.arrived++ % kNewest];
  setpoint = to_core(message);
  setpoint.arrival_ns = arrival_ns;
  mailbox_.draft() = window_;
  mailbox_.post();
  return count(result);
}

Decoded Inbox::hear_command(const void* bytes, std::size_t size) noexcept {
  command_v1_t message;
  const Decoded result = decode(bytes, size, message);
  if (result != Decoded::Ok) return count(result);
  const std::optional<bridge::Command> command = to_core(message);
  if (!command) return count(Decoded::Value);
  if (command->request == bridge::Request::EStop || !commands_.push(*command))
    estop_.store(true, std::memory_order_release);
  return count(result);
}

std::size_t Inbox::take_setpoints(std::span<bridge::Setpoint, kNewest> into) noexcept {
  if (!mailbox_.take()) return 0;
  const Window& window = mailbox_.value();
  const std::uint64_t fresh = std::min<std::uint64_t>(window.arrived - taken_, kNewest);
  for (std::uint64_t k = 0; k < fresh; ++k) into[k] = window.setpoints[(window.arrived - fresh + k) % kNewest];
  taken_ = window.arrived;
  return static_cast<std::size_t>(fresh);
}

std::size_t Inbox::take_commands(std::span<bridge::Command> into) noexcept {
  std::size_t count = 0;
  if (!into.empty() && estop_.exchange(false, std::memory_order_acquire)) {
    into[count] = {};
    into[count++].request = bridge::Request::EStop;
  }
  while (count < into.size() && commands_.pop(into[count])) ++count;
  return count;
}

std::int64_t Inbox::take_undecodable() noexcept { return undecodable_.exchange(0, std::memory_order_relaxed); }

}  // namespace glenoid::lcm_port
