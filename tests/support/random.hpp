#pragma once

#include <cstdint>
#include <random>

#include "glenoid/types.hpp"

namespace glenoid::test {

/// Reproducible random numbers: the same on every platform (std distributions are not).
class Random {
 public:
  /// @param stream  tells the tests of one program apart, so that one does not shift the numbers of the next
  explicit Random(std::uint64_t stream = 0);

  /// Uniform in [lower, upper).
  double uniform(double lower, double upper);
  /// exp of a uniform logarithm: every order of magnitude equally often.
  double log_uniform(double lower, double upper);
  Vec3 vector(double half_width);
  Vec4 vector4(double half_width);
  Vec3 unit_vector();
  Mat3 rotation();

 private:
  std::mt19937_64 engine_;
};

/// Ranges of random arm angles q = (theta, eta, zeta, phi), rad.
struct AngleRange {
  double theta_lower, theta_upper;
  double phi_lower, phi_upper;
};

/// Everything that a shoulder can do and more: theta 0..175 deg, phi 0..150 deg.
inline constexpr AngleRange kWholeRange = {0.0, 175.0 * kPi / 180.0, 0.0, 150.0 * kPi / 180.0};

/// eta and zeta uniform in [-pi, pi); theta and phi uniform in their range.
Vec4 random_angles(Random& random, const AngleRange& range = kWholeRange);

}  // namespace glenoid::test
