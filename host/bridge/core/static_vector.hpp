#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace glenoid::bridge {

/// A list of at most N values that never allocates. What does not fit is dropped and `push` says so.
template <class T, std::size_t N>
class StaticVector {
 public:
  bool push(const T& value) noexcept {
    if (size_ == N) return false;
    items_[size_++] = value;
    return true;
  }
  void clear() noexcept { size_ = 0; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] bool full() const noexcept { return size_ == N; }
  [[nodiscard]] T* begin() noexcept { return items_.data(); }
  [[nodiscard]] T* end() noexcept { return items_.data() + size_; }
  [[nodiscard]] const T* begin() const noexcept { return items_.data(); }
  [[nodiscard]] const T* end() const noexcept { return items_.data() + size_; }
  [[nodiscard]] T& operator[](std::size_t k) noexcept { return items_[k]; }
  [[nodiscard]] const T& operator[](std::size_t k) const noexcept { return items_[k]; }
  [[nodiscard]] std::span<const T> view() const noexcept { return {items_.data(), size_}; }

 private:
  std::array<T, N> items_{};
  std::size_t size_ = 0;
};

}  // namespace glenoid::bridge
