#pragma once

// Little-endian numbers in the data of a frame. Positions are the caller's responsibility: 0 <= at, at + bytes <= 8.

#include <cstddef>
#include <cstdint>

#include "host/bridge/can/frame.hpp"

namespace glenoid::bridge {

inline void put_u16(can::Frame& frame, std::size_t at, std::uint16_t value) noexcept {
  frame.data[at] = static_cast<std::uint8_t>(value);
  frame.data[at + 1] = static_cast<std::uint8_t>(value >> 8);
}

inline void put_u32(can::Frame& frame, std::size_t at, std::uint32_t value) noexcept {
  put_u16(frame, at, static_cast<std::uint16_t>(value));
  put_u16(frame, at + 2, static_cast<std::uint16_t>(value >> 16));
}

inline std::uint16_t get_u16(const can::Frame& frame, std::size_t at) noexcept {
  return static_cast<std::uint16_t>(frame.data[at] | (frame.data[at + 1] << 8));
}

inline std::uint32_t get_u32(const can::Frame& frame, std::size_t at) noexcept {
  return get_u16(frame, at) | (static_cast<std::uint32_t>(get_u16(frame, at + 2)) << 16);
}

}  // namespace glenoid::bridge
