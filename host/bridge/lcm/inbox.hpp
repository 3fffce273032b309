#pragma once

// From the thread that hears the network to the real-time loop: lock-free, latest wins for setpoints, nothing lost of commands.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "host/bridge/core/messages.hpp"
#include "host/bridge/lcm/gate.hpp"
#include "host/bridge/lcm/mailbox.hpp"
#include "host/bridge/lcm/ring.hpp"

namespace glenoid::lcm_port {

/// One thread hears (`hear_*`), another takes (`take_*`).
class Inbox {
 public:
  /// Setpoints that wait between two takes: the newest so many, so that jitter loses none and a flood none of the newest.
  static constexpr std::size_t kNewest = 8;

  /// Hearing thread: bytes that came on GLENOID_SETPOINT.
  /// @param arrival_ns  CLOCK_MONOTONIC
  Decoded hear_setpoint(const void* bytes, std::size_t size, std::int64_t arrival_ns) noexcept;
  /// Hearing thread: bytes that came on GLENOID_COMMAND.
  Decoded hear_command(const void* bytes, std::size_t size) noexcept;

  /// Loop: setpoints that arrived since the last call, oldest first; of more than kNewest the newest.
  std::size_t take_setpoints(std::span<bridge::Setpoint, kNewest> into) noexcept;
  /// Loop: requests since the last call, in order, an emergency stop before all others: it waits behind nothing. Where more
  /// requests came than could wait, that is one, too.
  std::size_t take_commands(std::span<bridge::Command> into) noexcept;
  /// Loop: setpoint messages since the last call that were none.
  std::int64_t take_undecodable() noexcept;

  /// Any thread: what was heard since construction, by result.
  [[nodiscard]] std::uint64_t heard(Decoded result) const noexcept {
    return heard_[static_cast<std::size_t>(result)].load(std::memory_order_relaxed);
  }

 private:
  struct Window {
    std::array<bridge::Setpoint, kNewest> setpoints{};  ///< number n is at n % kNewest
    std::uint64_t arrived = 0;                          ///< how many ever
  };
  Decoded count(Decoded result) noexcept;

  Window window_;
  Mailbox<Window> mailbox_;
  std::uint64_t taken_ = 0;
  Ring<bridge::Command, 64> commands_;
  std::atomic<bool> estop_ = false;
  std::atomic<std::int64_t> undecodable_ = 0;
  std::array<std::atomic<std::uint64_t>, 4> heard_{};
};

}  // namespace glenoid::lcm_port
