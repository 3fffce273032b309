#pragma once

#include <array>
#include <atomic>
#include <cstddef>

namespace glenoid::lcm_port {

/// Every value in order from one writing thread to one reading thread, without locks; at most N wait.
template <class T, std::size_t N>
class Ring {
 public:
  /// Writer: false where N wait; the value is not taken.
  bool push(const T& value) noexcept {
    const std::size_t written = written_.load(std::memory_order_relaxed);
    if (written - read_.load(std::memory_order_acquire) == N) return false;
    items_[written % N] = value;
    written_.store(written + 1, std::memory_order_release);
    return true;
  }
  /// Reader: false where nothing waits.
  bool pop(T& into) noexcept {
    const std::size_t read = read_.load(std::memory_order_relaxed);
    if (read == written_.load(std::memory_order_acquire)) return false;
    into = items_[read % N];
    read_.store(read + 1, std::memory_order_release);
    return true;
  }

 private:
  static_assert((N & (N - 1)) == 0, "indices wrap at a power of two");

  std::array<T, N> items_{};
  alignas(64) std::atomic<std::size_t> written_ = 0;
  alignas(64) std::atomic<std::size_t> read_ = 0;
};

}  // namespace glenoid::lcm_port
