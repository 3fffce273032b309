#include "host/bridge/core/resampler.hpp"

#include <algorithm>

namespace glenoid::bridge {

void Resampler::push(const Setpoint& setpoint) noexcept {
  Point& point = points_[next_];
  point.time_ns = setpoint.time_ns;
  point.value.position_rad = setpoint.position_rad;
  point.value.velocity_rad_per_s = setpoint.velocity_rad_per_s;
  next_ = (next_ + 1) % kCapacity;
  size_ = std::min(size_ + 1, kCapacity);
}

void Resampler::interpolate(const Point& from, const Point& to, std::int64_t stamp_ns, Sample& sample) const noexcept {
  const double h = 1e-9 * static_cast<double>(to.time_ns - from.time_ns);
  const double s = static_cast<double>(stamp_ns - from.time_ns) / static_cast<double>(to.time_ns - from.time_ns);
  const double r = 1.0 - s;
  for (std::size_t j = 0; j < joints_; ++j) {
    const double q0 = from.value.position_rad[j];
    const double q1 = to.value.position_rad[j];
    const double m0 = h * from.value.velocity_rad_per_s[j];
    const double m1 = h * to.value.velocity_rad_per_s[j];
    sample.position_rad[j] = r * r * ((1.0 + 2.0 * s) * q0 + s * m0) + s * s * ((1.0 + 2.0 * r) * q1 - r * m1);
    sample.velocity_rad_per_s[j] = (6.0 * s * r * (q1 - q0) + r * (1.0 - 3.0 * s) * m0 + s * (1.0 - 3.0 * r) * m1) / h;
  }
}

Resampler::Result Resampler::sample(std::int64_t stamp_ns, Sample& sample) const noexcept {
  if (size_ == 0) return Result::Empty;
  const Point& newest = back(0);
  if (stamp_ns >= newest.time_ns) {
    const std::int64_t beyond_ns = stamp_ns - newest.time_ns;
    const double ahead_s = 1e-9 * static_cast<double>(std::min(beyond_ns, horizon_ns_));
    const double moving = beyond_ns < horizon_ns_ ? 1.0 : 0.0;
    for (std::size_t j = 0; j < joints_; ++j) {
      const double v = newest.value.velocity_rad_per_s[j];
      sample.position_rad[j] = newest.value.position_rad[j] + ahead_s * v;
      sample.velocity_rad_per_s[j] = moving * v;
    }
    return beyond_ns == 0 ? Result::Interpolated : Result::Extrapolated;
  }
  for (std::size_t k = 1; k < size_; ++k) {
    if (back(k).time_ns <= stamp_ns) {
      interpolate(back(k), back(k - 1), stamp_ns, sample);
      return Result::Interpolated;
    }
  }
  return Result::TooEarly;
}

}  // namespace glenoid::bridge
