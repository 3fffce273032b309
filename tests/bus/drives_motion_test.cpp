// CiA 402 side of the simulated drive: states, cyclic synchronous position, stops, limits; and the motor behind it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "bus/drives_bench.hpp"

namespace glenoid::test {
namespace {

using drives::FaultKind;

constexpr double kPeriod_s = 2e-3;

/// Smooth motion to a target and back to rest: quintic, rad.
double quintic(double from, double to, double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return from + (to - from) * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
}

int emergency_code(DriveBench& bench) {
  const auto frames = bench.take(0x080U + bench.drive.node());
  return frames.empty() ? -1 : frames.front().data[0] | frames.front().data[1] << 8;
}

TEST(DriveStates, FollowTheControlwords) {
  struct Step {
    unsigned controlword, state;
  };
  DriveBench bench;
  bench.prepare();
  ASSERT_EQ(bench.download(0x605A, 0, 6, 2), 0U);
  const Step steps[] = {{0x0F, 0x40}, {0x07, 0x40}, {0x06, 0x21}, {0x00, 0x40}, {0x06, 0x21},
                        {0x07, 0x23}, {0x06, 0x21}, {0x07, 0x23}, {0x02, 0x40}, {0x06, 0x21},
                        {0x0F, 0x27}, {0x07, 0x23}, {0x0F, 0x27}, {0x06, 0x21}, {0x0F, 0x27},
                        {0x02, 0x07}, {0x06, 0x07}, {0x0F, 0x27}, {0x02, 0x07}, {0x00, 0x40}};
  int number = 0;
  for (const Step& step : steps) {
    for (int k = 0; k < 10; ++k) bench.cycle(step.controlword, bench.counts(bench.drive.view().position_rad));
    EXPECT_EQ(bench.state(), step.state) << "step " << number;
    ++number;
  }
}

TEST(DriveStates, FaultIsLeftOnTheRisingEdgeOfBit7Alone) {
  DriveBench bench;
  bench.prepare();
  bench.setpoint(0x80, 0);
  bench.sync();
  bench.download(0x2F00, 1, 4, 1);
  bench.wait(1 * kMs);
  EXPECT_EQ(bench.state() & 0x4F, 0x08U);
  EXPECT_EQ(bench.upload(0x603F).value, 0x2310);
  EXPECT_EQ(bench.upload(0x1001).value & 1, 1);
  bench.cycle(0x80, 0);  // still high: no edge
  EXPECT_EQ(bench.state() & 0x4F, 0x08U);
  bench.cycle(0x00, 0);
  bench.take();
  bench.cycle(0x80, 0);
  bench.cycle(0x80, 0);
  EXPECT_EQ(bench.state(), 0x40U);
  EXPECT_EQ(bench.upload(0x603F).value, 0);
  EXPECT_EQ(emergency_code(bench), 0);  // error reset
}

TEST(DriveCsp, Bit12IsSetOnlyWhileTheTargetIsFollowed) {
  DriveBench bench;
  bench.prepare();
  const auto follows = [&] { return (bench.drive.view().statusword >> 12U & 1U) != 0; };
  bench.setpoint(0x06, 0);
  EXPECT_FALSE(follows());
  bench.enable();
  EXPECT_TRUE(follows());
  bench.cycle(0x10F, 0);  // halt
  bench.cycle(0x10F, 0);
  EXPECT_FALSE(follows());
  bench.cycle(0x0F, 0);
  bench.cycle(0x0F, 0);
  EXPECT_TRUE(follows());
  bench.cycle(0x02, 0);
  bench.cycle(0x02, 0);
  EXPECT_FALSE(follows());
}

TEST(DriveCsp, DemandGoesEvenlyToTheTargetWithinOnePeriodAndStaysThere) {
  DriveBench bench;
  bench.prepare();
  bench.enable();
  const double step_rad = 0.002;  // 1 rad/s
  const double from = bench.drive.view().demand_rad;
  bench.setpoint(0x0F, bench.counts(from + step_rad));
  bench.sync();
  const double target = static_cast<double>(bench.counts(from + step_rad)) / bench.drive.counts_per_rad();
  for (int k = 1; k <= 8; ++k) {
    bench.wait(250'000);
    // rounding of one sum of eight
    EXPECT_NEAR(bench.drive.view().demand_rad, from + (target - from) * k / 8.0, 1e-12);
  }
  bench.wait(20 * kMs);
  EXPECT_EQ(bench.drive.view().demand_rad, target);
}

TEST(DriveCsp, FollowsASmoothMotionWithinTheVelocityLoopsDelay) {
  DriveBench bench;
  bench.prepare();
  bench.enable();
  const double duration_s = 1.0, way_rad = 1.0;
  const double most_rad_per_s = 1.875 * way_rad / duration_s;  // of the quintic
  double worst = 0.0;
  for (double t = 0.0; t < duration_s + 0.2; t += kPeriod_s) {
    bench.cycle(0x0F, bench.counts(quintic(0.0, way_rad, t / duration_s)));
    worst = std::max(worst, std::abs(bench.drive.view().demand_rad - bench.drive.view().position_rad));
  }
  // A cascade with velocity feed-forward lags by no more than the velocity loop's time constant (1/300 s) and the filter.
  EXPECT_LT(worst, most_rad_per_s * (1.0 / 300.0 + 5e-4));
  EXPECT_GT(worst, 0.0);
  // At rest what is left is friction over the position stiffness, which the integral removes within its time (50 ms).
  EXPECT_NEAR(bench.drive.view().position_rad, way_rad, 1e-4);
  EXPECT_EQ(bench.state(), 0x27U);
}

TEST(DriveCsp, ASyncThatIsAServoStepLateDoesNotShakeTheMotor) {
  DriveBench bench;
  bench.prepare();
  bench.enable();
  const drives::Profile profile;
  const double speed = 1.0, late_s = 0.1e-3;
  const double gain = profile.mechanics.inertia_kg_m2 * profile.control.velocity_bandwidth_rad_per_s;
  double target = 0.0, most = 0.0;
  for (int k = 0; k < 400; ++k) {
    const double rate = speed * std::min(1.0, k / 200.0);
    target += (kPeriod_s + late_s) * rate;
    bench.cycle(0x0F, bench.counts(target));
    bench.wait(static_cast<std::int64_t>(late_s * 1e9));
    const auto told = bench.feedback();  // as the drive was at the SYNC
    if (k > 250 && told) most = std::max(most, std::abs(told->torque * 1e-3 * profile.mechanics.rated_torque_Nm));
  }
  // The line is too fast by late/period and friction has to be overcome; the encoder's steps are below 1 Nm. To stand still
  // between line and SYNC would ask for the whole speed: 45 Nm.
  const double friction = profile.mechanics.coulomb_friction_Nm +
                          profile.mechanics.viscous_friction_Nm_s_per_rad * speed;
  EXPECT_GT(most, 0.0);
  EXPECT_LT(most, friction + gain * speed * late_s / kPeriod_s + 1.0);
}

TEST(DriveCsp, HoldsTheLastTargetWhenSetpointsStop) {
  DriveBench bench;
  bench.prepare();
  bench.enable();
  for (int k = 1; k <= 50; ++k) bench.cycle(0x0F, bench.counts(0.002 * k));
  for (int k = 0; k < 100; ++k) {
    bench.sync();
    bench.wait(2 * kMs);
  }
  EXPECT_NEAR(bench.drive.view().position_rad, 0.1, 1e-4);
  EXPECT_EQ(bench.drive.counters().missing_setpoints, 99U);  // the first SYNC still had one
}

TEST(DriveCsp, MissingSyncsAreCountedOnce) {
  DriveBench bench;
  bench.prepare();
  for (int k = 0; k < 10; ++k) bench.cycle(0x06, 0);
  EXPECT_EQ(bench.drive.counters().missed_cycles, 0U);
  bench.wait(6 * kMs);  // three SYNCs do not come
  bench.cycle(0x06, 0);
  EXPECT_EQ(bench.drive.counters().missed_cycles, 3U);
}

TEST(DriveCsp, TargetsBeyondTheSoftLimitAreCutAndSaySo) {
  DriveBench bench;
  bench.prepare();
  bench.enable();
  const std::int64_t limit = bench.counts(0.01);
  ASSERT_EQ(bench.download(0x607D, 2, limit, 4), 0U);
  for (int k = 1; k <= 20; ++k) bench.cycle(0x0F, bench.counts(0.001 * k));
  bench.wait(10 * kMs);
  EXPECT_EQ(bench.upload(0x6062).value, limit);
  EXPECT_NE(bench.drive.view().statusword & 1U << 11U, 0U);
}

TEST(DriveCsp, AJumpIsTakenAtTheGreatestSpeed) {
  DriveBench bench;
  bench.prepare();
  bench.enable();
  ASSERT_EQ(bench.download(0x6065, 0, 0xFFFFFFFF, 4), 0U);
  const double before = bench.drive.view().demand_rad;
  bench.setpoint(0x0F, bench.counts(1.0));
  bench.sync();
  bench.wait(2 * kMs);
  const double greatest = drives::Profile{}.mechanics.max_speed_rad_per_s;
  EXPECT_NEAR(bench.drive.view().demand_rad - before, greatest * kPeriod_s, 1e-12);
  EXPECT_NE(bench.drive.view().statusword & 1U << 11U, 0U);
}

TEST(DriveTorque, NeverExceedsTheLimit) {
  DriveBench bench;
  bench.prepare();
  ASSERT_EQ(bench.download(0x6072, 0, 100, 2), 0U);  // a tenth of the rated torque
  ASSERT_EQ(bench.download(0x6065, 0, 0xFFFFFFFF, 4), 0U);
  bench.enable();
  double most = 0.0;
  for (int k = 0; k < 100; ++k) {
    bench.cycle(0x0F, bench.counts(k % 20 < 10 ? 0.2 : -0.2));
    most = std::max(most, std::abs(bench.drive.view().torque_Nm));
  }
  EXPECT_DOUBLE_EQ(most, 0.1 * drives::Profile{}.mechanics.rated_torque_Nm);
}

TEST(DriveLoad, AddsTorqueThatThePositionLoopHolds) {
  DriveBench bench;
  bench.prepare();
  bench.enable();
  bench.drive.set_load({-10.0, 0.2});
  for (int k = 0; k < 500; ++k) bench.cycle(0x0F, 0);
  EXPECT_NEAR(bench.drive.view().torque_Nm, 10.0, 1.0);  // Coulomb friction may carry 1 Nm of it
  EXPECT_NEAR(bench.drive.view().position_rad, 0.0, 1e-3);
}

class QuickStop : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Option605Ah, QuickStop, testing::Values(0, 1, 2, 3, 5, 6, 7));

TEST_P(QuickStop, StopsOnItsRampAndEndsWhereTheOptionSays) {
  const int option = GetParam();
  DriveBench bench;
  bench.prepare();
  bench.enable();
  const double deceleration = 4.0, profile_deceleration = 2.0, speed = 1.0;  // rad/s^2, rad/s
  ASSERT_EQ(bench.download(0x605A, 0, option, 2), 0U);
  ASSERT_EQ(bench.download(0x6085, 0, bench.counts(deceleration), 4), 0U);
  ASSERT_EQ(bench.download(0x6084, 0, bench.counts(profile_deceleration), 4), 0U);
  double target = 0.0;
  for (int k = 0; k < 200; ++k) {
    target += kPeriod_s * speed * std::min(1.0, k / 100.0);
    bench.cycle(0x0F, bench.counts(target));
  }
  bench.setpoint(0x02, bench.counts(target));
  bench.sync();
  const double start = bench.drive.view().demand_rad;
  const double used = option == 0                  ? 0.0
                      : option == 1 || option == 5 ? profile_deceleration
                      : option == 2 || option == 6 ? deceleration
                                                   : 60.0 / 0.15;  // peak torque over inertia
  double stop_s = 0.0;
  while (bench.drive.view().powered && stop_s < 2.0 && (bench.drive.view().statusword & 1U << 10U) == 0) {
    bench.wait(kMs / 2);
    stop_s += 0.5e-3;
  }
  if (option == 0) {
    EXPECT_EQ(bench.state(), 0x40U);
    return;
  }
  EXPECT_NEAR(stop_s, speed / used, 1e-3);  // a step of the clock and of the servo
  // The way of a uniform deceleration, cut by servo steps of 250 us. Without power the demand is where the joint was when
  // the brake took it: behind by the delay of the velocity loop and of the filter.
  const double way = speed * speed / (2.0 * used), delay_s = 1.0 / 300.0 + 5e-4;
  EXPECT_NEAR(bench.drive.view().demand_rad - start, way, 0.01 * way + speed * (1e-3 + (option >= 5 ? 0.0 : delay_s)));
  bench.wait(100 * kMs);
  EXPECT_EQ(bench.state(), option >= 5 ? 0x07U : 0x40U);
  EXPECT_EQ(bench.drive.view().powered, option >= 5);
}

TEST(DriveFollowingError, IsWatchedDuringAQuickStopToo) {
  DriveBench bench;
  bench.prepare();
  bench.enable();
  ASSERT_EQ(bench.download(0x605A, 0, 6, 2), 0U);
  ASSERT_EQ(bench.download(0x6065, 0, bench.counts(0.01), 4), 0U);
  ASSERT_EQ(bench.download(0x6085, 0, bench.counts(2.0), 4), 0U);
  for (int k = 1; k <= 200; ++k) bench.cycle(0x0F, bench.counts(0.001 * k));  // 0.5 rad/s
  drives::Outbox out;
  bench.drive.inject({FaultKind::Jam, 0, 0}, bench.now_ns, out);
  bench.take();
  for (int k = 0; k < 50; ++k) bench.cycle(0x02, 0);  // the ramp goes on 60 mrad without the joint
  EXPECT_EQ(emergency_code(bench), 0x8611);
  EXPECT_EQ(bench.state() & 0x4F, 0x08U);
  EXPECT_FALSE(bench.drive.view().powered);
}

TEST(DriveFollowingError, BitIsGoneWhenTheDriveIsOff) {
  DriveBench bench;
  bench.prepare();
  bench.enable();
  ASSERT_EQ(bench.download(0x6065, 0, 1, 4), 0U);
  ASSERT_EQ(bench.download(0x6066, 0, 60000, 2), 0U);
  for (int k = 1; k <= 20; ++k) bench.cycle(0x0F, bench.counts(0.002 * k));
  ASSERT_NE(bench.drive.view().statusword & 1U << 13U, 0U);
  bench.cycle(0x00, 0);
  bench.cycle(0x00, 0);
  EXPECT_EQ(bench.drive.view().statusword & 1U << 13U, 0U);
}

TEST(DriveFollowingError, BeyondWindowAndTimeIsAFault) {
  DriveBench bench;
  bench.prepare();
  bench.enable();
  const double window_rad = 0.02, speed = 0.5;
  ASSERT_EQ(bench.download(0x6065, 0, bench.counts(window_rad), 4), 0U);
  ASSERT_EQ(bench.download(0x6066, 0, 20, 2), 0U);
  bench.drive.inject({FaultKind::Jam, 0, 0}, bench.now_ns, *std::make_unique<drives::Outbox>());
  bench.take();
  double time_s = 0.0;
  while (bench.state() == 0x27 && time_s < 1.0) {
    bench.cycle(0x0F, bench.counts(speed * time_s));
    time_s += kPeriod_s;
  }
  // The window is left after window/speed and one period of transport; then 20 ms must pass.
  EXPECT_NEAR(time_s, window_rad / speed + 0.020, 3 * kPeriod_s);
  EXPECT_EQ(emergency_code(bench), 0x8611);
  EXPECT_NE(bench.drive.view().statusword & 1U << 13U, 0U);
  bench.wait(500 * kMs);
  EXPECT_EQ(bench.state() & 0x4F, 0x08U);
  EXPECT_FALSE(bench.drive.view().powered);
}

}  // namespace
}  // namespace glenoid::test
