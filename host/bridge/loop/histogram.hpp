#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "host/bridge/core/messages.hpp"

namespace glenoid::bridge {

/// A number that one thread counts up and others may read at any time; without the price of an atomic addition.
class Counter {
 public:
  void add(std::uint64_t more = 1) noexcept { set(value() + more); }
  void set(std::uint64_t value) noexcept { value_.store(value, std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t value() const noexcept { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_ = 0;
};

/// Durations in ns, counted in buckets of 3 % width: no allocation, constant time. One thread records, any may read: what it
/// sees may lack the last values.
class Histogram {
 public:
  void record(std::int64_t ns) noexcept {
    const auto value = static_cast<std::uint64_t>(std::max<std::int64_t>(0, ns));
    buckets_[bucket(value)].add();
    count_.add();
    largest_.set(std::max(largest_.value(), value));
  }

  [[nodiscard]] std::uint64_t count() const noexcept { return count_.value(); }
  [[nodiscard]] double largest_us() const noexcept { return 1e-3 * static_cast<double>(largest_.value()); }
  /// Smallest value that is not exceeded by this share of all, to 3 %; 0 where nothing was recorded.
  [[nodiscard]] double quantile_us(double share) const noexcept {
    const std::uint64_t count = count_.value(), largest = largest_.value();
    const auto wanted = static_cast<std::uint64_t>(share * static_cast<double>(count));
    std::uint64_t seen = 0;
    for (std::size_t k = 0; k < kBuckets; ++k) {
      seen += buckets_[k].value();
      if (seen > wanted || (seen >= count && count > 0)) return 1e-3 * static_cast<double>(std::min(upper(k), largest));
    }
    return 0.0;
  }
  /// Its values in short.
  [[nodiscard]] Figure figure() const noexcept {
    return {static_cast<std::int64_t>(count()), quantile_us(0.5), quantile_us(0.99), quantile_us(0.999), largest_us()};
  }

 private:
  static constexpr std::uint64_t kSteps = 32;  // per power of two
  static constexpr std::size_t kBuckets = kSteps * 36;

  static std::size_t bucket(std::uint64_t value) noexcept {
    if (value < kSteps) return static_cast<std::size_t>(value);
    const int shift = static_cast<int>(std::bit_width(value)) - 6;  // value >> shift is in [32, 64)
    const std::size_t at = kSteps * static_cast<std::size_t>(shift + 1) + static_cast<std::size_t>(value >> shift) -
                           kSteps;
    return std::min(at, kBuckets - 1);
  }
  static std::uint64_t upper(std::size_t k) noexcept {
    if (k < kSteps) return k;
    const std::size_t shift = k / kSteps - 1;
    return ((k % kSteps + kSteps + 1) << shift) - 1;
  }

  std::array<Counter, kBuckets> buckets_{};
  Counter count_;
  Counter largest_;
};

}  // namespace glenoid::bridge
