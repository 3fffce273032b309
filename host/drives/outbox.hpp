#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "host/bridge/can/frame.hpp"

namespace glenoid::drives {

/// Frames that wait to be sent, oldest first. Fixed room: what does not fit is dropped and counted.
class Outbox {
 public:
  static constexpr std::size_t kCapacity = 256;

  void push(const can::Frame& frame) noexcept {
    if (size_ < kCapacity) {
      frames_[size_++] = frame;
    } else {
      ++dropped_;
    }
  }
  [[nodiscard]] std::span<const can::Frame> frames() const noexcept { return {frames_.data(), size_}; }
  /// Frames that found no room since the last call.
  std::uint64_t take_dropped() noexcept {
    const std::uint64_t count = dropped_;
    dropped_ = 0;
    return count;
  }
  void clear() noexcept { size_ = 0; }

 private:
  std::array<can::Frame, kCapacity> frames_{};
  std::size_t size_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace glenoid::drives
