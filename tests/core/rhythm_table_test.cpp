#include "glenoid/rhythm.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/matchers.hpp"

namespace glenoid::test {
namespace {

constexpr double kDegree = kPi / 180.0;

/// z_TU of an arm raised forwards by theta.
Vec3 raised(double theta) { return {0.0, -std::sin(theta), std::cos(theta)}; }

Rhythm with_smoothing(double smoothing_rad) {
  return Rhythm({RhythmModel::SoltaniZarrin2017, 1.0, smoothing_rad}, 0.17);
}

// The table of the smoothed curve (R6) against the polynomial as printed, which is evaluated as it stands.
TEST(RhythmTable, SmoothedCentreIsThePrintedOneAtTheSmoothedElevation) {
  const Rhythm printed = with_smoothing(0.0);
  for (const double smoothing : {0.01, 0.02, 0.1, 0.3}) {
    const Rhythm smooth = with_smoothing(smoothing);
    for (int k = 1; k <= 17900; ++k) {
      const double theta = 0.01 * k * kDegree, smoothed = theta * std::erf(theta / smoothing);
      const Vec3 expected = printed.position(raised(smoothed));
      // the cosine of a small angle holds it to 1e-16/angle, and the printed centre moves by 0.03 m/rad there
      ASSERT_TRUE(near(smooth.position(raised(theta)), expected, 2e-15 + 1e-17 / smoothed)) << theta;
    }
  }
}

TEST(RhythmTable, DerivativesAreThePrintedOnesBeyondTheSmoothing) {
  const Rhythm printed = with_smoothing(0.0), smooth = with_smoothing(0.1);
  for (int k = 6100; k <= 30000; ++k) {
    const Vec3 z = raised(1e-4 * k);
    RhythmJet a, b;
    printed.evaluate(z, a);
    smooth.evaluate(z, b);
    const double first = a.J_z.cwiseAbs().maxCoeff();
    ASSERT_TRUE(near(a.J_z, b.J_z, 1e-12 * first)) << 1e-4 * k;
    for (std::size_t i = 0; i < 3; ++i) ASSERT_TRUE(near(a.H_z[i], b.H_z[i], 1e-10 * first)) << 1e-4 * k;
  }
}

}  // namespace
}  // namespace glenoid::test
