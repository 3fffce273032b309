#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace glenoid::lcm_port {

/// The newest value from one writing thread to one reading thread: three buffers that change hands, so that neither waits for
/// the other and the reader never sees half a value. Older values that nobody took are overwritten.
template <class T>
class Mailbox {
 public:
  /// Writer: the buffer to fill. Its content is of two or three posts ago.
  T& draft() noexcept { return buffers_[writing_]; }
  /// Writer: hands the draft over.
  void post() noexcept {
    writing_ = middle_.exchange(static_cast<std::uint8_t>(writing_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }
  /// Reader: true where something was posted since the last call; then `value` is the newest.
  bool take() noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    reading_ = middle_.exchange(reading_, std::memory_order_acq_rel) & kIndex;
    return true;
  }
  /// Reader: what the last successful `take` brought.
  [[nodiscard]] const T& value() const noexcept { return buffers_[reading_]; }

 private:
  static constexpr std::uint8_t kIndex = 3, kFresh = 4;

  std::array<T, 3> buffers_{};
  alignas(64) std::uint8_t writing_ = 0;
  alignas(64) std::atomic<std::uint8_t> middle_ = 1;
  alignas(64) std::uint8_t reading_ = 2;
};

}  // namespace glenoid::lcm_port
