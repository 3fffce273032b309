#include "glenoid/timing.hpp"

#include <algorithm>
#include <cmath>

namespace glenoid {

ScalarJet minimum_jerk(double t, double start, double duration) noexcept {
  const double u = std::clamp((t - start) / duration, 0.0, 1.0);
  const double r = 1.0 - u;
  return {u * u * u * (10.0 + u * (6.0 * u - 15.0)), 30.0 * u * u * r * r / duration,
          60.0 * u * r * (r - u) / (duration * duration)};
}

ScalarJet homing_minimum_jerk(double t, double start, double duration, double tail) noexcept {
  constexpr double kMostTail = 0.6;
  const double b = std::clamp(tail * std::log(duration), 0.0, kMostTail);
  const double u = std::clamp((t - start) / duration, 0.0, 1.0);
  const ScalarJet s = minimum_jerk(u + b * u * (1.0 - u), 0.0, 1.0);
  const double rate = (1.0 + b * (1.0 - 2.0 * u)) / duration, bend = -2.0 * b / (duration * duration);
  return {s.value, s.d1 * rate, s.d2 * rate * rate + s.d1 * bend};
}

ScalarJet fading_motion(double t, double start, double duration, double v, double a) noexcept {
  // Quintic with value 0, rate v and acceleration a at u = 0, all zero at u = 1:
  // duration v (u - 6u^3 + 8u^4 - 3u^5) + duration^2 a (u^2 - 3u^3 + 3u^4 - u^5) / 2
  const double u = std::clamp((t - start) / duration, 0.0, 1.0);
  const double r = 1.0 - u;
  const double V = duration * v, A = 0.5 * duration * duration * a;
  const double value = u * r * r * r * (V * (1.0 + 3.0 * u) + A * u);
  const double d1 = V * r * r * (1.0 + u * (2.0 - 15.0 * u)) + A * u * r * r * (2.0 - 5.0 * u);
  const double d2 = V * u * r * (60.0 * u - 36.0) + A * r * (2.0 + u * (20.0 * u - 16.0));
  return {value, d1 / duration, d2 / (duration * duration)};
}

ScalarJet stopping_clock(double t, double start, double duration) noexcept {
  if (t <= start) return {t, 1.0, 0.0};
  // rate 1 - 3u^2 + 2u^3
  const double u = std::min((t - start) / duration, 1.0);
  const double r = 1.0 - u;
  return {start + duration * u * (1.0 + u * u * (0.5 * u - 1.0)), r * r * (1.0 + 2.0 * u), -6.0 * u * r / duration};
}

}  // namespace glenoid
