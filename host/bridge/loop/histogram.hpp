#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace glenoid::bridge {

/// Durations in ns, counted in buckets of 3 % width: no allocation, constant time.
class Histogram {
 public:
  void record(std::int64_t ns) noexcept {
    const auto value = static_cast<std::uint64_t>(std::max<std::int64_t>(0, ns));
    ++buckets_[bucket(value)];
    ++count_;
    largest_ = std::max(largest_, value);
  }

  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  [[nodiscard]] double largest_us() const noexcept { return 1e-3 * static_cast<double>(largest_); }
  /// Smallest value that is not exceeded by this share of all, to 3 %; 0 where nothing was recorded.
  [[nodiscard]] double quantile_us(double share) const noexcept {
    const auto wanted = static_cast<std::uint64_t>(share * static_cast<double>(count_));
    std::uint64_t seen = 0;
    for (std::size_t k = 0; k < kBuckets; ++k) {
      seen += buckets_[k];
      if (seen > wanted || (seen == count_ && count_ > 0))
        return 1e-3 * static_cast<double>(std::min(upper(k), largest_));
    }
    return 0.0;
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

  std::array<std::uint64_t, kBuckets> buckets_{};
  std::uint64_t count_ = 0;
  std::uint64_t largest_ = 0;
};

}  // namespace glenoid::bridge
