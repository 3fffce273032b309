#pragma once

#include <array>
#include <cstdint>

#include "host/bridge/can/frame.hpp"
#include "host/drives/dictionary.hpp"

namespace glenoid::drives {

/// Error register 1001h, history 1003h and the EMCY frames that tell of them, no closer together than 1015h allows.
class Emergency {
 public:
  /// A new error: register, history, frame.
  void raise(Dictionary& objects, std::uint16_t code, std::uint32_t vendor = 0) noexcept;
  /// All errors are gone: register to 0, EMCY 0000h. Nothing happens if there was none.
  void clear(Dictionary& objects) noexcept;
  /// The next frame due. False: none, or the inhibit time runs.
  bool next(const Dictionary& objects, std::int64_t now_ns, can::Frame& frame) noexcept;
  /// Forgets what waits and the inhibit time.
  void reset() noexcept { count_ = 0; }

 private:
  struct Message {
    std::uint16_t code = 0;
    std::uint8_t error_register = 0;
    std::uint32_t vendor = 0;
  };
  void queue(const Message& message) noexcept;

  std::array<Message, 8> waiting_{};
  std::size_t count_ = 0;
  std::int64_t not_before_ns_ = 0;
};

}  // namespace glenoid::drives
