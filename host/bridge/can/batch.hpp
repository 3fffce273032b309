#pragma once

// Many messages of a socket by one call into the kernel, with the time each arrived.

#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace glenoid::can {

/// Reads up to kSlots messages at once. Allocates nothing; large, keep one.
class ReceiveBatch {
 public:
  static constexpr std::size_t kSlots = 64;
  static constexpr std::size_t kPayload = 512;  ///< longer messages come with MSG_TRUNC

  ReceiveBatch() noexcept;
  ReceiveBatch(const ReceiveBatch&) = delete;
  ReceiveBatch& operator=(const ReceiveBatch&) = delete;

  /// How many arrived, at most `most` and kSlots; 0 where nothing waits; -errno of any other failure.
  int receive(int descriptor, std::size_t most) noexcept;

  [[nodiscard]] std::span<const char> payload(std::size_t k) const noexcept {
    return {payloads_[k].data(), messages_[k].msg_len};
  }
  [[nodiscard]] int flags(std::size_t k) const noexcept { return messages_[k].msg_hdr.msg_flags; }
  [[nodiscard]] const sockaddr_in& source(std::size_t k) const noexcept { return sources_[k]; }
  /// Reception on CLOCK_MONOTONIC: the kernel's stamp, or now where there is none.
  [[nodiscard]] std::int64_t time_ns(std::size_t k) const noexcept { return times_ns_[k]; }
  /// Messages that the kernel dropped since the socket was opened because nobody read them.
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }

 private:
  void read_control(std::size_t k, std::int64_t monotonic_minus_real_ns, std::int64_t now_ns) noexcept;

  std::array<mmsghdr, kSlots> messages_{};
  std::array<iovec, kSlots> vectors_{};
  std::array<std::array<char, kPayload>, kSlots> payloads_{};
  std::array<sockaddr_in, kSlots> sources_{};
  struct alignas(cmsghdr) Control {
    std::array<char, 128> bytes;
  };
  std::array<Control, kSlots> controls_{};
  std::array<std::int64_t, kSlots> times_ns_{};
  std::uint64_t dropped_ = 0;
  std::uint32_t dropped_before_ = 0;
};

/// Sends up to kSlots messages at once. Allocates nothing; large, keep one.
class SendBatch {
 public:
  static constexpr std::size_t kSlots = 64;

  SendBatch() noexcept;
  SendBatch(const SendBatch&) = delete;
  SendBatch& operator=(const SendBatch&) = delete;

  /// Message `k`; its bytes are not copied and must stay until `send`.
  /// @param segment  of a UDP socket: the kernel cuts the bytes into datagrams of this size, the last may be shorter; 0: one
  void set(std::size_t k, std::span<const char> bytes, std::uint16_t segment = 0) noexcept;
  /// Messages 0 .. count - 1, without waiting. How many the kernel took, at least one; -errno where none.
  int send(int descriptor, std::size_t count) noexcept;

 private:
  std::array<mmsghdr, kSlots> messages_{};
  std::array<iovec, kSlots> vectors_{};
  struct alignas(cmsghdr) Control {
    std::array<char, CMSG_SPACE(sizeof(std::uint16_t))> bytes;
  };
  std::array<Control, kSlots> controls_{};
};

/// setsockopt for an int. False where the kernel refuses.
bool set_option(int descriptor, int level, int option, int value) noexcept;

/// Receive buffer (as root beyond the system's limit), stamps and drop counter.
void prepare_reception(int descriptor, int buffer_bytes) noexcept;

/// The kernel drops UDP datagrams from this port before it queues them, so that nobody has to read and decode his own. False
/// where it refuses.
bool drop_from(int descriptor, std::uint16_t port) noexcept;

/// "what: words of errno", with a hint behind it if not empty.
[[nodiscard]] std::string failure(std::string_view what, int error, std::string_view hint = {});

}  // namespace glenoid::can
