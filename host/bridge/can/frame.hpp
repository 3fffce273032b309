#pragma once

// Classic CAN frames as the bridge and the drives exchange them, whatever carries them.

#include <array>
#include <cstdint>

namespace glenoid::can {

/// A classic CAN 2.0 frame. `data` beyond `size` is zero.
struct Frame {
  std::uint32_t id = 0;   ///< 11 bit, or 29 bit when `extended`; for error frames the CAN_ERR_* class bits
  std::uint8_t size = 0;  ///< 0..8 bytes
  bool extended = false;
  bool remote = false;
  bool error = false;  ///< a report of the controller, never on the wire; `id` and `data` as in linux/can/error.h
  std::array<std::uint8_t, 8> data{};

  friend bool operator==(const Frame&, const Frame&) = default;
};

/// A frame as it arrived.
struct Received {
  Frame frame;
  std::int64_t time_ns = 0;  ///< CLOCK_MONOTONIC at reception, from the kernel where it stamps
  bool own = false;          ///< the echo of a frame this port sent: it left the queue and reached the bus
};

}  // namespace glenoid::can
