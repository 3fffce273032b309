#pragma once

#include <cstddef>
#include <vector>

namespace glenoid::can {

/// First in, first out, of fixed capacity; allocates when constructed only. One thread.
template <class T>
class Queue {
 public:
  explicit Queue(std::size_t capacity) : items_(capacity) {}

  /// False where the queue is full: the item is not taken.
  bool push(const T& item) noexcept {
    if (size_ == items_.size()) return false;
    items_[(first_ + size_++) % items_.size()] = item;
    return true;
  }
  /// Call only where not empty.
  [[nodiscard]] const T& front() const noexcept { return items_[first_]; }
  T pop() noexcept {
    const T item = items_[first_];
    first_ = (first_ + 1) % items_.size();
    --size_;
    return item;
  }
  void clear() noexcept { size_ = 0; }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }

 private:
  std::vector<T> items_;
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace glenoid::can
