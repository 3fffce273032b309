#pragma once

// The bridge without its wires: frames and messages in, frames and messages out, time and chance passed in.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "host/bridge/can/frame.hpp"
#include "host/bridge/can/port.hpp"
#include "host/bridge/core/messages.hpp"
#include "host/bridge/core/settings.hpp"
#include "host/bridge/core/static_vector.hpp"

namespace glenoid::bridge {

/// What happened on one bus since the last step.
struct BusInput {
  std::span<const can::Received> received;  ///< own echoes included, oldest first
  can::Link link = can::Link::Up;
  std::size_t outstanding = 0;  ///< frames sent whose echo is missing
  bool purge_failed = false;    ///< the purge asked for by the last output could not be done
  can::PortCounters counters{};
};

/// Everything that happened since the last step.
struct Inputs {
  std::array<BusInput, kMaxBuses> bus{};
  std::span<const Setpoint> setpoints;  ///< oldest first
  std::span<const Command> commands;
  std::int64_t undecodable = 0;           ///< setpoint messages of wrong size or type
  std::int64_t entropy = 0;               ///< fresh random bits, used for the token when arming
  bool local_estop = false;               ///< level of the local input
  bool shutdown = false;                  ///< come to rest, disarm and stay so
  const char* arming_obstacle = nullptr;  ///< why arming is not permitted here, null: it is
  bool suppress_heartbeat = false;        ///< dead-man self-test: the master falls silent
};

struct BusOutput {
  StaticVector<can::Frame, 64> frames;
  bool purge = false;  ///< drop what is queued before sending `frames`
};

/// What is to be done now. Large: keep one and reuse it.
struct Outputs {
  std::array<BusOutput, kMaxBuses> bus{};
  StaticVector<Event, 64> events;
  bool has_feedback = false;
  bool has_status = false;
  Feedback feedback{};
  Status status{};
};

/// The bridge of one exoskeleton.
///
/// Call order, once per SYNC period n at time t_n = t_0 + n * period:
///
///     bridge.sync(n, t_n, outputs);        // send outputs.bus[*].frames at once
///     ... part of the period passes, the drives answer ...
///     bridge.step(now, inputs, outputs);   // send outputs.bus[*].frames
///
/// A caller that overran its deadline leaves numbers out instead of catching up; the bridge counts them.
/// Deterministic: equal calls give equal outputs. Does not check its settings. One thread owns it.
class Bridge {
 public:
  /// @throws std::invalid_argument no joint, too many joints or buses.
  explicit Bridge(const Settings& settings);
  ~Bridge();
  Bridge(Bridge&&) noexcept;
  Bridge& operator=(Bridge&&) noexcept;

  /// The SYNC of cycle `cycle`. Clears `outputs` first.
  /// @param cycle    number of the SYNC, growing
  /// @param time_ns  CLOCK_MONOTONIC at which it is due
  /// @alloc none
  void sync(std::int64_t cycle, std::int64_t time_ns, Outputs& outputs) noexcept;

  /// Everything else of the cycle: answers of the drives in, RPDOs for the next SYNC, heartbeat, SDO and NMT out.
  /// Clears `outputs` first.
  /// @alloc none
  void step(std::int64_t time_ns, const Inputs& inputs, Outputs& outputs) noexcept;

  [[nodiscard]] State state() const noexcept;
  [[nodiscard]] Fault fault() const noexcept;
  [[nodiscard]] std::int64_t session() const noexcept;
  /// Every drive is configured and operational.
  [[nodiscard]] bool configured() const noexcept;
  /// After Inputs::shutdown: the drives are without power and no longer miss the master's heartbeat.
  [[nodiscard]] bool released() const noexcept;
  /// What was last commanded, rad; NaN before the first command.
  [[nodiscard]] std::span<const double> command_rad() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace glenoid::bridge
