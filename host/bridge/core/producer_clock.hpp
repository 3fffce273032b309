#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "host/bridge/core/settings.hpp"

namespace glenoid::bridge {

/// Tells which instant of the producer's clock belongs to an instant of ours.
///
/// Stamp: the clocks are one. Estimated: a phase-locked loop over (stamp, arrival) pairs follows offset and drift; the
/// jitter of a single arrival moves the estimate by at most kProportional * kLargestError = 10 us per setpoint.
class ProducerClock {
 public:
  explicit ProducerClock(TimeBase base) noexcept : base_(base) {}

  void reset() noexcept { known_ = false; }

  /// A setpoint stamped `stamp_ns` arrived.
  void observe(std::int64_t stamp_ns, std::int64_t arrival_ns) noexcept {
    if (base_ == TimeBase::Stamp) return;
    const double error_ns = known_ ? static_cast<double>(arrival_ns - local(stamp_ns)) : 0.0;
    if (!known_ || std::abs(error_ns) > kRestart) {
      offset_ns_ = arrival_ns - stamp_ns;
      fine_ns_ = drift_ = 0.0;
      known_ = true;
    } else {
      const double bounded = std::clamp(error_ns, -kLargestError, kLargestError);
      const double elapsed = static_cast<double>(stamp_ns - reference_ns_);
      fine_ns_ += drift_ * elapsed + kProportional * bounded;
      drift_ = std::clamp(drift_ + kIntegral * bounded / std::max(elapsed, 1e5), -kLargestDrift, kLargestDrift);
    }
    reference_ns_ = stamp_ns;
  }

  /// Our instant of a stamp.
  [[nodiscard]] std::int64_t local(std::int64_t stamp_ns) const noexcept {
    if (base_ == TimeBase::Stamp) return stamp_ns;
    return stamp_ns + offset_ns_ + static_cast<std::int64_t>(fine_ns_ + drift_ * elapsed(stamp_ns));
  }

  /// The stamp of our instant: the inverse of `local` to first order in the drift.
  [[nodiscard]] std::int64_t stamp(std::int64_t local_ns) const noexcept {
    if (base_ == TimeBase::Stamp) return local_ns;
    const std::int64_t coarse = local_ns - offset_ns_;
    return coarse - static_cast<std::int64_t>(fine_ns_ + drift_ * elapsed(coarse));
  }

 private:
  static constexpr double kProportional = 0.005;
  static constexpr double kIntegral = 6e-6;      // critically damped: kProportional^2 / 4
  static constexpr double kLargestError = 2e6;   // ns: later arrivals are queueing, not clock
  static constexpr double kLargestDrift = 1e-3;  // ten times a bad quartz: a source cannot wind it up
  static constexpr double kRestart = 100e6;      // ns: another clock

  [[nodiscard]] double elapsed(std::int64_t stamp_ns) const noexcept {
    return static_cast<double>(stamp_ns - reference_ns_);
  }

  TimeBase base_;
  bool known_ = false;
  std::int64_t offset_ns_ = 0;     // arrival minus stamp, coarse
  std::int64_t reference_ns_ = 0;  // stamp of the last observation
  double fine_ns_ = 0.0;           // correction of the offset at the reference
  double drift_ = 0.0;             // ns per ns
};

}  // namespace glenoid::bridge
