// Laws of the resampler, the producer's clock and the limiter.

#include <gtest/gtest.h>

#include <cmath>

#include "bridge_rig.hpp"
#include "host/bridge/core/limits.hpp"
#include "host/bridge/core/producer_clock.hpp"
#include "host/bridge/core/resampler.hpp"
#include "support/environment.hpp"
#include "support/random.hpp"

namespace glenoid::bridge::test {
namespace {

using glenoid::test::Random;
using glenoid::test::test_count;

Setpoint point(std::int64_t time_ns, double q, double v) {
  Setpoint setpoint;
  setpoint.time_ns = time_ns;
  setpoint.position_rad[0] = q;
  setpoint.velocity_rad_per_s[0] = v;
  return setpoint;
}

TEST(BridgeResampler, CubicMotionsAreReproduced) {
  Random random(51);
  for (int k = test_count(500); k > 0; --k) {
    const Vec4 c = random.vector4(1.0);
    const auto q = [&](double t) { return c[0] + t * (c[1] + t * (c[2] + t * c[3])); };
    const auto v = [&](double t) { return c[1] + t * (2 * c[2] + t * 3 * c[3]); };
    Resampler resampler(1, 6 * kMs);
    std::int64_t at = 0;
    for (int i = 0; i < 40; ++i) {  // any spacing
      resampler.push(point(at, q(1e-9 * static_cast<double>(at)), v(1e-9 * static_cast<double>(at))));
      at += static_cast<std::int64_t>(random.uniform(0.2, 30.0) * kMs);
    }
    Sample sample;
    for (int i = 0; i < 20; ++i) {
      const auto t = static_cast<std::int64_t>(random.uniform(0.5, 0.9) * static_cast<double>(at));
      const auto result = resampler.sample(t, sample);
      if (result != Resampler::Result::Interpolated) continue;
      // Rounding: positions below 10, the velocity divides by spacings above 0.2 ms.
      ASSERT_NEAR(sample.position_rad[0], q(1e-9 * static_cast<double>(t)), 1e-13);
      ASSERT_NEAR(sample.velocity_rad_per_s[0], v(1e-9 * static_cast<double>(t)), 1e-10);
    }
  }
}

TEST(BridgeResampler, HalvingThePeriodDividesTheErrorBySixteen) {
  const auto worst = [](std::int64_t h) {
    Resampler resampler(1, 100 * kMs);
    const auto q = [](std::int64_t t) { return std::sin(5e-9 * static_cast<double>(t)); };
    for (std::int64_t t = 0; t <= 20 * h; t += h)
      resampler.push(point(t, q(t), 5 * std::cos(5e-9 * static_cast<double>(t))));
    double error = 0.0;
    Sample sample;
    for (std::int64_t t = 0; t < 20 * h; t += h / 16)
      if (resampler.sample(t, sample) == Resampler::Result::Interpolated)
        error = std::max(error, std::abs(sample.position_rad[0] - q(t)));
    return error;
  };
  EXPECT_NEAR(std::log2(worst(40 * kMs) / worst(20 * kMs)), 4.0, 0.3);
}

TEST(BridgeResampler, NeverGoesBeyondTheHorizon) {
  Resampler resampler(1, 6 * kMs);
  resampler.push(point(0, 1.0, 2.0));
  Sample sample;
  for (const std::int64_t t : {6 * kMs, 7 * kMs, 1000 * kMs, std::int64_t{1} << 60}) {
    ASSERT_EQ(resampler.sample(t, sample), Resampler::Result::Extrapolated);
    EXPECT_DOUBLE_EQ(sample.position_rad[0], 1.0 + 2.0 * 0.006);
    EXPECT_EQ(sample.velocity_rad_per_s[0], 0.0);
  }
  ASSERT_EQ(resampler.sample(3 * kMs, sample), Resampler::Result::Extrapolated);
  EXPECT_DOUBLE_EQ(sample.position_rad[0], 1.0 + 2.0 * 0.003);
}

TEST(BridgeResampler, SaysWhenItHasNothing) {
  Resampler resampler(1, 6 * kMs);
  Sample sample;
  EXPECT_EQ(resampler.sample(0, sample), Resampler::Result::Empty);
  resampler.push(point(10 * kMs, 1.0, 0.0));
  EXPECT_EQ(resampler.sample(9 * kMs, sample), Resampler::Result::TooEarly);
}

TEST(BridgeClock, StampsOfThisMachineAreTaken) {
  ProducerClock clock(TimeBase::Stamp);
  clock.observe(100, 5000);
  EXPECT_EQ(clock.local(100), 100);
  EXPECT_EQ(clock.stamp(123), 123);
}

/// A producer whose clock runs fast and starts anywhere, whose messages arrive late by a random time.
TEST(BridgeClock, DriftAndJitterDoNotShow) {
  Random random(52);
  for (int k = test_count(20); k > 0; --k) {
    const double drift = random.uniform(-2e-4, 2e-4);
    const auto offset = static_cast<std::int64_t>(random.uniform(-1e15, 1e15));
    ProducerClock clock(TimeBase::Estimated);
    std::int64_t stamp = offset;
    std::int64_t last = 0;
    double worst_rate = 0.0, worst_age = 0.0;
    constexpr int kCount = 10000;
    for (int i = 0; i < kCount; ++i) {
      const std::int64_t sent = std::int64_t{2} * kMs * i;
      stamp = offset + static_cast<std::int64_t>((1.0 + drift) * static_cast<double>(sent));
      clock.observe(stamp, sent + static_cast<std::int64_t>(random.uniform(0.1, 1.1) * kMs));
      const std::int64_t read = clock.stamp(sent + 2 * kMs);
      if (i > kCount / 2) {
        // How unevenly the producer's time passes on the wire, against its true rate.
        worst_rate = std::max(worst_rate, std::abs(static_cast<double>(read - last) - (1.0 + drift) * 2 * kMs));
        worst_age = std::max(worst_age, std::abs(static_cast<double>(clock.local(stamp) - sent)));
      }
      last = read;
    }
    // 0.5 ms either way enters with the proportional gain of 0.005, and a little from the integral: 4 us of 2 ms.
    EXPECT_LT(worst_rate, 4e3) << drift;
    // Settled: the estimate is the mean delay of 0.6 ms, give or take what the gain lets through.
    EXPECT_NEAR(worst_age, 0.6e6, 0.2e6) << drift;
  }
}

/// Stamps and arrivals of a source that lies: the clock it makes us believe in keeps the pace of a clock.
TEST(BridgeClock, NoSourceMakesItRunFastOrSlow) {
  Random random(57);
  for (int k = test_count(20); k > 0; --k) {
    ProducerClock clock(TimeBase::Estimated);
    std::int64_t stamp = 0, arrival = 0;
    const double late = random.uniform(-1.0, 1.0);
    for (int i = 0; i < 20000; ++i) {
      stamp += 1 + static_cast<std::int64_t>(random.uniform(0.0, 1e5));
      arrival = clock.local(stamp) + static_cast<std::int64_t>(late * 90e6);
      clock.observe(stamp, arrival);
    }
    // Over a second without setpoints: the drift of at most 1e-3 alone counts, over it and over the 0.2 s by which 20,000
    // steps of at most 10 us moved the offset; and second order of it.
    const double passed = static_cast<double>(clock.stamp(clock.local(stamp) + 1000 * kMs) - stamp);
    EXPECT_NEAR(passed, 1e9, 1e-3 * 1.2e9 + 1e-6 * 2e9);
  }
}

struct Followed {
  CommandLimiter limiter;
  JointLimits limits;
  double period_s;
};

Followed random_limiter(Random& random) {
  Followed followed;
  followed.limits.lower_rad = random.uniform(-3, -0.1);
  followed.limits.upper_rad = random.uniform(0.1, 3);
  followed.limits.velocity_rad_per_s = random.log_uniform(0.05, 10);
  followed.limits.acceleration_rad_per_s2 = random.log_uniform(0.5, 200);
  followed.limits.blend_rad_per_s = followed.limits.velocity_rad_per_s * random.uniform(0.05, 1);
  followed.period_s = random.uniform(0.0005, 0.01);
  followed.limiter = CommandLimiter(followed.limits, followed.period_s);
  return followed;
}

TEST(BridgeLimiter, NoTargetMakesItLeaveItsLimits) {
  Random random(53);
  for (int k = test_count(2000); k > 0; --k) {
    Followed f = random_limiter(random);
    f.limiter.reset(random.uniform(f.limits.lower_rad, f.limits.upper_rad));
    double target = 0.0, speed = 0.0;
    for (int i = 0; i < 300; ++i) {
      if (i % 30 == 0) {
        target = random.uniform(-5, 5);
        speed = random.uniform(-2, 2) * f.limits.velocity_rad_per_s;
      }
      const double q = f.limiter.position_rad();
      const double v = f.limiter.velocity_rad_per_s();
      if (i % 70 > 60)
        f.limiter.brake();
      else
        static_cast<void>(f.limiter.follow(target + speed * f.period_s * (i % 30), speed, i % 90 > 45));
      // Sums of 300 steps: their rounding.
      const double slack = 1e-9 * (1.0 + f.limits.velocity_rad_per_s);
      ASSERT_GE(f.limiter.position_rad(), f.limits.lower_rad - slack);
      ASSERT_LE(f.limiter.position_rad(), f.limits.upper_rad + slack);
      ASSERT_LE(std::abs(f.limiter.velocity_rad_per_s()), f.limits.velocity_rad_per_s + slack);
      ASSERT_LE(std::abs(f.limiter.velocity_rad_per_s() - v),
                f.limits.acceleration_rad_per_s2 * f.period_s + 2 * slack + 1e-9 * f.limits.velocity_rad_per_s);
      ASSERT_NEAR(f.limiter.position_rad() - q, f.limiter.velocity_rad_per_s() * f.period_s, slack);
    }
  }
}

TEST(BridgeLimiter, StandingTargetIsReachedAndHeldExactly) {
  Random random(54);
  for (int k = test_count(500); k > 0; --k) {
    Followed f = random_limiter(random);
    f.limiter.reset(random.uniform(f.limits.lower_rad, f.limits.upper_rad));
    const double target = random.uniform(f.limits.lower_rad, f.limits.upper_rad);
    const double blend = f.limits.blend_rad_per_s;
    // Twice the time of the straight way and of the ramps.
    const double time_s = 2 * (6.0 / blend + 4 * f.limits.velocity_rad_per_s / f.limits.acceleration_rad_per_s2) + 0.5;
    for (double t = 0; t < time_s; t += f.period_s) static_cast<void>(f.limiter.follow(target, 0.0, true));
    ASSERT_EQ(f.limiter.position_rad(), target);
    ASSERT_EQ(f.limiter.velocity_rad_per_s(), 0.0);
  }
}

TEST(BridgeLimiter, SmoothMotionWithinTheLimitsPassesUnchanged) {
  JointLimits limits{-1, 1, 2.0, 20.0, 0.5};
  CommandLimiter limiter(limits, 0.002);
  limiter.reset(0.0);
  for (int i = 1; i < 5000; ++i) {
    const double t = 0.002 * i;
    const double q = 0.5 * (1 - std::cos(2 * t));
    const std::uint8_t limited = limiter.follow(q, std::sin(2 * t), false);
    ASSERT_EQ(limited, kWithinLimits) << i;
    ASSERT_EQ(limiter.position_rad(), q);
  }
}

TEST(BridgeLimiter, FromOutsideItComesBackAndGoesNoFurther) {
  JointLimits limits{-1, 1, 2.0, 20.0, 0.5};
  CommandLimiter limiter(limits, 0.002);
  limiter.reset(1.3);
  for (int i = 0; i < 500; ++i) {
    static_cast<void>(limiter.follow(2.0, 0.0, false));
    ASSERT_LE(limiter.position_rad(), 1.3);
  }
  for (int i = 0; i < 2000; ++i) static_cast<void>(limiter.follow(0.5, 0.0, false));
  EXPECT_EQ(limiter.position_rad(), 0.5);
}

}  // namespace
}  // namespace glenoid::bridge::test
