#pragma once

// What a controller reports about its bus: error frames (linux/can/error.h) as values and in words.

#include <cstdint>
#include <string>

#include "host/bridge/can/frame.hpp"

namespace glenoid::can {

/// Ordered from good to bad.
enum class ControllerState : std::uint8_t { Active, Warning, Passive, Off };

/// One error frame, taken apart. Fields that it does not speak of are as constructed.
struct ErrorReport {
  bool has_state = false;
  ControllerState state = ControllerState::Active;
  bool restarted = false;         ///< the controller is back on the bus after bus-off
  bool transmit_timeout = false;  ///< the driver gave a frame up
  bool receive_overflow = false;
  bool transmit_overflow = false;
  bool lost_arbitration = false;
  bool no_acknowledge = false;  ///< nobody else is on the bus
  bool bus_error = false;
  bool has_counters = false;
  std::uint8_t tx_errors = 0;
  std::uint8_t rx_errors = 0;
};

/// Takes an error frame apart; a frame that is none gives an empty report.
[[nodiscard]] ErrorReport decode_error(const Frame& frame) noexcept;

/// The same for people, such as "bus off; transmit error counter 248, receive error counter 0". Allocates.
[[nodiscard]] std::string describe_error(const Frame& frame);

/// The error frame of a controller that went to `state`, as a driver would report it: for simulated buses.
[[nodiscard]] Frame make_error(ControllerState state, std::uint8_t tx_errors, std::uint8_t rx_errors) noexcept;

}  // namespace glenoid::can
