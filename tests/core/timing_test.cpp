#include "glenoid/timing.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/environment.hpp"
#include "support/random.hpp"

namespace glenoid::test {
namespace {

struct Differences {
  double d1, d2;
};

/// Polynomials of degree 5 in t/duration: a fourth-order difference leaves rounding only, eps scale/h and eps scale/h^2.
template <class Law>
Differences differences(const Law& law, double t, double h) {
  const auto value = [&](int k) { return law(t + k * h).value; };
  const auto rate = [&](int k) { return law(t + k * h).d1; };
  return {(8.0 * (value(1) - value(-1)) - (value(2) - value(-2))) / (12.0 * h),
          (8.0 * (rate(1) - rate(-1)) - (rate(2) - rate(-2))) / (12.0 * h)};
}

constexpr double kDuration = 1.75, kStart = 0.5;  // exact in binary: start + duration is the end, to the last bit
constexpr double kStep = 1e-3 * kDuration;
// h^4 f^(5)/30 with f^(5) = 720/duration^5, and rounding of 1e-15/h; in units of value per duration.
constexpr double kDifferenceError = 3e-11;

TEST(MinimumJerk, GoesFromRestToRest) {
  for (const double t : {kStart - 5.0, kStart, kStart + kDuration, kStart + 99.0}) {
    const ScalarJet s = minimum_jerk(t, kStart, kDuration);
    EXPECT_EQ(s.value, t > kStart ? 1.0 : 0.0);
    EXPECT_EQ(s.d1, 0.0);
    EXPECT_EQ(s.d2, 0.0);
  }
}

TEST(MinimumJerk, IsSymmetricAndRises) {
  double before = 0.0;
  for (int k = 1; k < 1000; ++k) {
    const double t = 0.001 * k * kDuration;
    const ScalarJet s = minimum_jerk(kStart + t, kStart, kDuration);
    const ScalarJet mirrored = minimum_jerk(kStart + kDuration - t, kStart, kDuration);
    EXPECT_GT(s.value, before);
    EXPECT_NEAR(s.value + mirrored.value, 1.0, 1e-14);
    EXPECT_NEAR(s.d1, mirrored.d1, 1e-13);
    EXPECT_NEAR(s.d2, -mirrored.d2, 1e-12);
    before = s.value;
  }
  EXPECT_NEAR(minimum_jerk(kStart + 0.5 * kDuration, kStart, kDuration).d1, 1.875 / kDuration, 1e-15)
      << "peak to mean speed";
}

TEST(MinimumJerk, DerivativesAreThoseOfTheValue) {
  for (int k = 1; k < 100; ++k) {
    const double t = kStart + 0.01 * k * kDuration;
    const auto law = [](double at) { return minimum_jerk(at, kStart, kDuration); };
    const Differences expected = differences(law, t, kStep);
    EXPECT_NEAR(law(t).d1, expected.d1, kDifferenceError);
    EXPECT_NEAR(law(t).d2, expected.d2, 10.0 * kDifferenceError);
  }
}

TEST(FadingMotion, StartsWithTheOldMotionAndEndsAtRest) {
  Random random(1);
  for (int n = 0; n < 1000; ++n) {
    const double v = random.uniform(-3.0, 3.0), a = random.uniform(-20.0, 20.0);
    const ScalarJet start = fading_motion(kStart, kStart, kDuration, v, a);
    EXPECT_EQ(start.value, 0.0);
    EXPECT_NEAR(start.d1, v, 1e-15 * std::abs(v));
    EXPECT_NEAR(start.d2, a, 4e-15 * std::abs(a));
    for (const double t : {kStart + kDuration, kStart + 50.0}) {
      const ScalarJet end = fading_motion(t, kStart, kDuration, v, a);
      EXPECT_EQ(end.value, 0.0);
      EXPECT_EQ(end.d1, 0.0);
      EXPECT_EQ(end.d2, 0.0);
    }
  }
}

TEST(FadingMotion, DerivativesAreThoseOfTheValue) {
  for (int k = 1; k < 100; ++k) {
    const double t = kStart + 0.01 * k * kDuration;
    const auto law = [](double at) { return fading_motion(at, kStart, kDuration, 1.0, -3.0); };
    const Differences expected = differences(law, t, kStep);
    EXPECT_NEAR(law(t).d1, expected.d1, 10.0 * kDifferenceError);
    EXPECT_NEAR(law(t).d2, expected.d2, 100.0 * kDifferenceError);
  }
}

TEST(FadingMotion, WithMinimumJerkIsTheMinimumJerkMotionFromAMovingState) {
  // The minimum of the squared jerk between given ends is the one quintic with those ends: its third derivative at the ends
  // may be anything, its sixth is zero. Six conditions fix it; here they are solved by Hermite's formula.
  Random random(2);
  for (int n = 0; n < 1000; ++n) {
    const double v = random.uniform(-3.0, 3.0), a = random.uniform(-20.0, 20.0), goal = random.uniform(-2.0, 2.0);
    const double T = random.uniform(0.1, 3.0);
    const double c3 = (20.0 * goal - 12.0 * v * T - 3.0 * a * T * T) / (2.0 * T * T * T);
    const double c4 = (-30.0 * goal + 16.0 * v * T + 3.0 * a * T * T) / (2.0 * std::pow(T, 4));
    const double c5 = (12.0 * goal - 6.0 * v * T - a * T * T) / (2.0 * std::pow(T, 5));
    for (const double u : {0.1, 0.35, 0.6, 0.9}) {
      const double t = u * T;
      const double expected = v * t + 0.5 * a * t * t + c3 * std::pow(t, 3) + c4 * std::pow(t, 4) + c5 * std::pow(t, 5);
      const double scale = std::abs(goal) + std::abs(v) * T + std::abs(a) * T * T;
      EXPECT_NEAR(goal * minimum_jerk(t, 0.0, T).value + fading_motion(t, 0.0, T, v, a).value, expected, 1e-14 * scale);
    }
  }
}

TEST(StoppingClock, RunsBeforeAndHaltsForGood) {
  const ScalarJet before = stopping_clock(kStart - 0.2, kStart, kDuration);
  EXPECT_EQ(before.value, kStart - 0.2);
  EXPECT_EQ(before.d1, 1.0);
  EXPECT_EQ(before.d2, 0.0);
  const ScalarJet end = stopping_clock(kStart + kDuration, kStart, kDuration);
  const ScalarJet later = stopping_clock(kStart + 1000.0, kStart, kDuration);
  EXPECT_EQ(end.value, later.value);
  EXPECT_EQ(later.d1, 0.0);
  EXPECT_EQ(later.d2, 0.0);
}

TEST(StoppingClock, NeverRunsBackAndNeverFast) {
  double before = stopping_clock(kStart, kStart, kDuration).value;
  for (int k = 1; k <= 1000; ++k) {
    const ScalarJet clock = stopping_clock(kStart + 0.001 * k * kDuration, kStart, kDuration);
    EXPECT_GE(clock.value, before);
    EXPECT_GE(clock.d1, 0.0);
    EXPECT_LE(clock.d1, 1.0);
    EXPECT_LE(clock.d2, 0.0);
    before = clock.value;
  }
}

TEST(StoppingClock, HasNoStepInValueRateOrAccelerationAtItsEnds) {
  constexpr double h = 1e-9;
  for (const double t : {kStart, kStart + kDuration}) {
    const ScalarJet left = stopping_clock(t - h, kStart, kDuration), right = stopping_clock(t + h, kStart, kDuration);
    EXPECT_NEAR(left.value, right.value, 2.1 * h);
    EXPECT_NEAR(left.d1, right.d1, 6.0 * h / kDuration);
    EXPECT_NEAR(left.d2, right.d2, 12.0 * h / (kDuration * kDuration));
  }
}

TEST(StoppingClock, DerivativesAreThoseOfTheValue) {
  for (int k = 1; k < 100; ++k) {
    const double t = kStart + 0.01 * k * kDuration;
    const auto law = [](double at) { return stopping_clock(at, kStart, kDuration); };
    const Differences expected = differences(law, t, kStep);
    EXPECT_NEAR(law(t).d1, expected.d1, kDifferenceError);
    EXPECT_NEAR(law(t).d2, expected.d2, kDifferenceError);
  }
}

}  // namespace
}  // namespace glenoid::test
