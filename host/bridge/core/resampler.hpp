#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "host/bridge/core/messages.hpp"

namespace glenoid::bridge {

/// A position and a velocity of every joint at one instant.
struct Sample {
  JointValues position_rad{};
  JointValues velocity_rad_per_s{};
};

/// Keeps the last setpoints and reads the motion between them.
///
/// Equation  cubic Hermite through (t_i, q_i, v_i) and (t_i+1, q_i+1, v_i+1): exact for motions up to third order, error
///           h^4 |q''''| / 384 otherwise.
/// Beyond the newest setpoint it goes on at the newest velocity for at most `horizon_ns`, then stays.
class Resampler {
 public:
  /// Setpoints kept: those between the instant that is read and the newest must be among them.
  static constexpr std::size_t kCapacity = 256;
  enum class Result : std::uint8_t { Empty, TooEarly, Interpolated, Extrapolated };

  Resampler(std::size_t joints, std::int64_t horizon_ns) noexcept : joints_(joints), horizon_ns_(horizon_ns) {}

  void clear() noexcept { size_ = 0; }
  /// @pre stamps grow
  void push(const Setpoint& setpoint) noexcept;
  /// `sample` is unchanged unless Interpolated or Extrapolated.
  [[nodiscard]] Result sample(std::int64_t stamp_ns, Sample& sample) const noexcept;

 private:
  struct Point {
    std::int64_t time_ns = 0;
    Sample value;
  };

  /// k-th newest.
  [[nodiscard]] const Point& back(std::size_t k) const noexcept {
    return points_[(next_ + 2 * kCapacity - 1 - k) % kCapacity];
  }
  void interpolate(const Point& from, const Point& to, std::int64_t stamp_ns, Sample& sample) const noexcept;

  std::size_t joints_;
  std::int64_t horizon_ns_;
  std::array<Point, kCapacity> points_{};
  std::size_t next_ = 0;
  std::size_t size_ = 0;
};

}  // namespace glenoid::bridge
