// What a joint does when its power goes, and how fast a motor can make it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bus/drives_bench.hpp"
#include "host/drives/servo.hpp"

namespace glenoid::test {
namespace {

constexpr double kPeriod_s = 2e-3;

/// A drive whose joint moves at a speed, rad/s.
void move(DriveBench& bench, double speed) {
  bench.prepare();
  bench.enable();
  double target = 0.0;
  for (int k = 0; k < 300; ++k) {
    target += kPeriod_s * speed * std::min(1.0, k / 150.0);
    bench.cycle(0x0F, bench.counts(target));
  }
}

TEST(DriveBrake, ClosesLateAndStopsAMovingJointByItsTorque) {
  drives::Profile profile;
  drives::Mechanics& m = profile.mechanics;
  m.coulomb_friction_Nm = m.viscous_friction_Nm_s_per_rad = 0.0;
  m.brake_torque_Nm = 15.0;
  DriveBench bench(profile);
  move(bench, 1.0);
  bench.setpoint(0x00, 0);
  bench.sync();  // disable voltage
  const double speed = bench.drive.view().velocity_rad_per_s, begin = bench.drive.view().position_rad;
  ASSERT_FALSE(bench.drive.view().powered);
  ASSERT_NEAR(speed, 1.0, 0.05);
  double stop_s = 0.0;
  for (; bench.drive.view().velocity_rad_per_s != 0.0 && stop_s < 1.0; stop_s += 0.5e-3) bench.wait(kMs / 2);
  const double deceleration = m.brake_torque_Nm / m.inertia_kg_m2;
  const double tolerance_s = 2e-3;  // of the bench's and the servo's steps
  EXPECT_NEAR(stop_s, m.brake_delay_s + speed / deceleration, tolerance_s);
  const double way = speed * m.brake_delay_s + speed * speed / (2.0 * deceleration);
  EXPECT_NEAR(bench.drive.view().position_rad - begin, way, speed * tolerance_s);
}

TEST(DriveBrake, HoldsAJointAtRestAtOnce) {
  DriveBench bench;
  move(bench, 0.0);
  const double place = bench.drive.view().position_rad;
  bench.drive.set_load({-10.0, 0.0});
  bench.setpoint(0x00, 0);
  bench.sync();
  for (int k = 0; k < 200; ++k) bench.wait(kMs / 2);
  EXPECT_DOUBLE_EQ(bench.drive.view().position_rad, place);
}

TEST(DriveBrake, LetsTheJointGoWhenPowerIsBack) {
  DriveBench bench;
  move(bench, 1.0);
  for (int k = 0; k < 100; ++k) bench.cycle(0x00, 0);
  ASSERT_EQ(bench.drive.view().velocity_rad_per_s, 0.0);
  bench.enable();
  const double place = bench.drive.view().position_rad;
  for (int k = 0; k < 100; ++k) bench.cycle(0x0F, bench.counts(place + 0.002 * std::min(k, 50)));
  EXPECT_NEAR(bench.drive.view().position_rad, place + 0.1, 1e-3);
}

TEST(DriveMotor, IsNeverFasterThanItsVoltageAllows) {
  drives::Profile profile;
  DriveBench bench(profile);
  move(bench, 1.0);
  ASSERT_EQ(bench.download(0x6065, 0, 0xFFFFFFFF, 4), 0U);  // nobody watches
  drives::Outbox out;
  bench.drive.inject({drives::FaultKind::StuckEncoder, 0, 0}, bench.now_ns, out);
  const drives::Mechanics& m = profile.mechanics;
  const double no_load = m.no_load_speed_ratio * m.max_speed_rad_per_s;
  double fastest = 0.0;
  for (int k = 0; k < 500; ++k) {
    bench.cycle(0x0F, bench.counts(2.0));
    const drives::DriveView view = bench.drive.view();
    fastest = std::max(fastest, std::abs(view.velocity_rad_per_s));
    const double share = (no_load - std::abs(view.velocity_rad_per_s)) / (no_load - m.max_speed_rad_per_s);
    const double change = m.peak_torque_Nm / m.inertia_kg_m2 * drives::kServoStep_s;  // of the speed, since the limit
    EXPECT_LE(view.torque_Nm,
              m.peak_torque_Nm * std::clamp(share + change / (no_load - m.max_speed_rad_per_s), 0.0, 1.0));
  }
  EXPECT_LT(fastest, no_load);
  EXPECT_GT(fastest, m.max_speed_rad_per_s);  // the blind controller pushes as hard as it can
}

}  // namespace
}  // namespace glenoid::test
