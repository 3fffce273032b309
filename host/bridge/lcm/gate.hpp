#pragma once

// Bytes from outside become messages here, or nothing.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "glenoid/command_v1_t.hpp"
#include "glenoid/event_v1_t.hpp"
#include "glenoid/feedback_v1_t.hpp"
#include "glenoid/setpoint_v1_t.hpp"
#include "glenoid/status_v1_t.hpp"

namespace glenoid::lcm_port {

enum class Decoded : std::uint8_t {
  Ok,
  Size,   ///< not exactly as long as the type: cut off, with something behind it, or another type
  Type,   ///< as long, but with another fingerprint
  Value,  ///< a field that the type cannot have
};

[[nodiscard]] std::string_view words_of(Decoded result) noexcept;

/// Decodes a message of one of the types of lcm_types, all of which have one length. `into` is unchanged unless Ok.
template <class Message>
[[nodiscard]] Decoded decode(const void* bytes, std::size_t size, Message& into) noexcept {
  try {
    Message message;
    const int length = message.getEncodedSize();
    if (bytes == nullptr || size != static_cast<std::size_t>(length)) return Decoded::Size;
    if (message.decode(bytes, 0, length) != length) return Decoded::Type;
    into = message;
    return Decoded::Ok;
  } catch (...) {
    return Decoded::Value;  // generated decoders of types with variable length throw; ours have none
  }
}

}  // namespace glenoid::lcm_port
