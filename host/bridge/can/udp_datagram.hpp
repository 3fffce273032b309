#pragma once

// The wire format of python-can's udp_multicast bus: one frame a datagram, a MessagePack map of eleven keys.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "host/bridge/can/frame.hpp"

namespace glenoid::can {

/// Bytes of a datagram. Allocates nothing.
class DatagramEncoder {
 public:
  static constexpr std::size_t kCapacity = 256;

  /// @param frame    id in range, at most 8 bytes.
  /// @param time_s   seconds since 1970, for the readers' logs.
  /// @return the datagram, valid until the next call.
  std::span<const char> encode(const Frame& frame, double time_s) noexcept;

  /// For the packer.
  void write(const char* data, std::size_t size) noexcept;

 private:
  std::array<char, kCapacity> bytes_{};
  std::size_t size_ = 0;
};

/// Frames out of datagrams. Allocates when constructed only, unless a datagram is malformed.
class DatagramDecoder {
 public:
  DatagramDecoder();
  ~DatagramDecoder();
  DatagramDecoder(const DatagramDecoder&) = delete;
  DatagramDecoder& operator=(const DatagramDecoder&) = delete;

  /// Empty for anything but one whole map of the known keys with a classic CAN frame in it: id in the range of its format,
  /// at most 8 bytes, as many as "dlc" says (none in a remote frame).
  std::optional<Frame> decode(std::span<const char> datagram) noexcept;

 private:
  class Parser;
  std::unique_ptr<Parser> parser_;
};

}  // namespace glenoid::can
