#pragma once

#include <array>
#include <cstdint>

#include "host/drives/outbox.hpp"

namespace glenoid::drives {

/// The drive's connection to the bus: loses or delays frames when told to.
class Line {
 public:
  explicit Line(std::uint64_t seed) noexcept : random_(seed) {}

  void lose(std::uint32_t per_mille) noexcept { loss_per_mille_ = per_mille; }
  void delay(std::int64_t ns) noexcept { delay_ns_ = ns; }
  void cut(bool is_cut) noexcept;

  /// A frame of the drive.
  void send(const can::Frame& frame, std::int64_t now_ns, Outbox& out) noexcept;
  /// Whether a frame of the bus reaches the drive; call once a frame.
  bool delivers() noexcept;
  /// Lets delayed frames go whose time has come.
  void advance(std::int64_t now_ns, Outbox& out) noexcept;

 private:
  bool loses() noexcept;

  struct Delayed {
    can::Frame frame;
    std::int64_t due_ns = 0;
  };
  std::array<Delayed, 128> waiting_{};
  std::size_t count_ = 0;
  std::uint64_t random_;
  std::uint32_t loss_per_mille_ = 0;
  std::int64_t delay_ns_ = 0;
  bool cut_ = false;
};

}  // namespace glenoid::drives
