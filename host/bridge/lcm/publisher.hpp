#pragma once

// For programs that make setpoints: the handshake with the bridge, stamps and sequence numbers.

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "glenoid/command_v1_t.hpp"
#include "glenoid/feedback_v1_t.hpp"
#include "glenoid/status_v1_t.hpp"
#include "host/bridge/lcm/lcm_port.hpp"

namespace glenoid::lcm_port {

/// A source of setpoints, for one thread:
///
///     Publisher source;
///     if (!source.arm(5s)) ...                              // drives enabled; source.status() says why not
///     source.publish(t, q, dq); ...                         // begins where the arm is: source.feedback()
///     source.request(command_v1_t::START);                  // the bridge follows from now on; go on publishing
///     source.request(command_v1_t::DISARM);
///
/// The bridge holds when the stream pauses for three periods and stops when it ends, so publish at a steady rate.
class Publisher {
 public:
  /// @throws as LcmPort.
  explicit Publisher(std::string_view url = kDefaultUrl, bool allow_network = false);
  ~Publisher();
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  /// Takes in what arrived; waits at most so long for the first message. False where none came.
  bool poll(std::chrono::milliseconds longest);

  /// Asks for arming and waits until the bridge is READY. False: not within `longest`, or it went to FAULT or STOP.
  bool arm(std::chrono::milliseconds longest);
  /// Sends one of the constants of command_v1_t with the token of the session. False where LCM did not take it.
  bool request(std::int32_t command);
  /// Where the joints shall be at `time_ns` of CLOCK_MONOTONIC, rad and rad/s in the order of exo.q.
  /// False and not sent: no session, no joints or more than 16, sizes differ, a value that is not finite.
  bool publish(std::int64_t time_ns, std::span<const double> position_rad, std::span<const double> velocity_rad_per_s);

  /// Token of the session, 0 before arming and when the bridge ended it.
  [[nodiscard]] std::int64_t session() const noexcept;
  /// Newest of each; empty before the first.
  [[nodiscard]] const std::optional<status_v1_t>& status() const noexcept;
  [[nodiscard]] const std::optional<feedback_v1_t>& feedback() const noexcept;

  /// CLOCK_MONOTONIC, ns.
  [[nodiscard]] static std::int64_t now_ns() noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace glenoid::lcm_port
