#pragma once

#include <cstddef>
#include <cstdint>

#include "host/bridge/can/frame.hpp"
#include "host/bridge/core/bridge.hpp"
#include "host/bridge/core/messages.hpp"

namespace glenoid::bridge {

/// State of one CAN controller and of what is queued in front of it.
class BusMonitor {
 public:
  BusMonitor(double bit_rate_bit_per_s, int transmit_skips) noexcept
      : bit_rate_(bit_rate_bit_per_s), transmit_skips_(transmit_skips) {}

  /// Takes the state of the port at the beginning of a step.
  void observe(const BusInput& input) noexcept;
  /// Takes a frame of somebody else, or one that is being sent; error frames change the state.
  void receive(const can::Frame& frame) noexcept;
  /// Closes the second over which load is measured.
  void measure_load(std::int64_t now_ns) noexcept;

  /// Frames may be written: link up, not bus-off.
  [[nodiscard]] bool writable() const noexcept { return link_up_ && !off_; }
  /// This cycle may carry process data: writable, and nothing of the last cycle is still queued.
  [[nodiscard]] bool clear() const noexcept { return writable() && outstanding_ == 0; }
  /// What was sent since the last step left in whole: the next command may go a step further. Otherwise a drive that missed
  /// one would be told two steps at once.
  [[nodiscard]] bool carries() const noexcept { return clear() && !refuses_; }
  [[nodiscard]] bool stalled() const noexcept { return failures_ >= transmit_skips_; }
  [[nodiscard]] bool off() const noexcept { return off_; }
  [[nodiscard]] bool link_up() const noexcept { return link_up_; }

  /// Asks that nothing queued may reach the bus any more. Until `observe` has seen that, `purge_needed`.
  void request_purge() noexcept;
  /// To be given to the port with the next output.
  [[nodiscard]] bool take_purge() noexcept;
  [[nodiscard]] bool purge_needed() const noexcept { return purge_needed_; }
  /// A purge also restarts a controller that is bus-off: leaves that state until the next error frame.
  void restart() noexcept;

  [[nodiscard]] BusStatus status() const noexcept;

 private:
  double bit_rate_;
  int transmit_skips_;
  bool link_up_ = true;
  bool off_ = false;
  bool purge_pending_ = false;  // to be handed out
  bool purge_asked_ = false;    // handed out, the answer is due
  bool purge_needed_ = false;
  bool refuses_ = false;  // frames were not taken since the last step
  int failures_ = 0;      // steps in a row that began with frames unsent or refused
  std::size_t outstanding_ = 0;
  std::uint64_t refused_ = 0;
  std::uint64_t sent_ = 0;
  BusStatus status_{};
  std::int64_t load_since_ns_ = 0;
  double load_bits_ = 0.0;
};

}  // namespace glenoid::bridge
