// What somebody beside the patient would try: laws that hold whatever the buses, the drives and the messages do.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bridge_motions.hpp"
#include "host/bridge/can/error_frame.hpp"
#include "host/bridge/core/codec.hpp"
#include "support/environment.hpp"
#include "support/random.hpp"

namespace glenoid::bridge::test {
namespace {

using glenoid::test::Random;
using glenoid::test::test_count;

/// Most that the target of a drive changed from one SYNC at which it got one to the next, in rad.
double largest_step_on_the_wire(const Rig& rig, std::size_t joint) {
  const Scale scale(rig.settings.joints[joint]);
  double largest = 0.0, last = NAN, next = NAN;
  for (const Wire& entry : rig.wire) {
    if (!entry.from_bridge || entry.bus != rig.settings.joints[joint].bus) continue;
    if (entry.frame.id == 0x200U + rig.settings.joints[joint].node) {
      if (const auto order = decode_rpdo1(entry.frame); order && order->controlword == 0x0F)
        next = scale.position_rad(order->target_position);
    } else if (entry.frame.id == 0x080 && !std::isnan(next)) {
      if (!std::isnan(last)) largest = std::max(largest, std::abs(next - last));
      last = next;
    }
  }
  return largest;
}

double count_rad(const Rig& rig, std::size_t joint) {
  const Scale scale(rig.settings.joints[joint]);
  return std::abs(scale.position_rad(1) - scale.position_rad(0));
}

/// No drive was told more at once than its speed limit allows in a period; a count of rounding.
void expect_steps_within_limits(const Rig& rig) {
  const double period_s = 1e-9 * static_cast<double>(rig.settings.period_ns);
  for (std::size_t j = 0; j < rig.settings.joints.size(); ++j)
    ASSERT_LE(largest_step_on_the_wire(rig, j),
              rig.settings.joints[j].velocity_rad_per_s * period_s + 1.01 * count_rad(rig, j));
}

enum class Trouble { Stalled, Refused };

/// A bus that carries nothing for some cycles, again and again, but never long enough for a fault.
class Hiccups : public ::testing::TestWithParam<Trouble> {};

TEST_P(Hiccups, NeverLetAJointJumpFurtherThanItsLimit) {
  Settings settings = six_drives(6, 2);
  for (JointSettings& joint : settings.joints) joint.velocity_rad_per_s = 0.32;  // the swing takes 0.30
  Rig rig(settings);
  ASSERT_TRUE(rig.run(swing)) << rig.told();
  for (int k = 0; k < 400; ++k) {
    bool& trouble = GetParam() == Trouble::Stalled ? rig.buses[1].stalled : rig.buses[1].refuses;
    trouble = k % 10 < settings.transmit_skips - 2;
    rig.cycle();
    ASSERT_EQ(rig.bridge.state(), State::Run) << rig.told();
  }
  expect_steps_within_limits(rig);
}

INSTANTIATE_TEST_SUITE_P(Buses, Hiccups, ::testing::Values(Trouble::Stalled, Trouble::Refused),
                         [](const auto& one) { return one.param == Trouble::Stalled ? "Stalled" : "Refused"; });

TEST(BridgeSafety, EStopInAnyStateBeatsAResetOfTheSameCycle) {
  for (const State state : {State::Idle, State::Ready, State::Run, State::Hold}) {
    Rig rig(six_drives(2));
    if (state == State::Idle) {
      ASSERT_TRUE(rig.configure()) << rig.told();
    } else if (state == State::Ready) {
      ASSERT_TRUE(rig.arm()) << rig.told();
    } else {
      ASSERT_TRUE(rig.run(swing)) << rig.told();
    }
    if (state == State::Hold) {
      rig.motion = nullptr;
      ASSERT_TRUE(rig.run_until([&] { return rig.bridge.state() == State::Hold; }, 20 * kMs));
    }
    ASSERT_EQ(rig.bridge.state(), state);
    rig.command(Request::EStop);
    rig.command(Request::ResetFault);
    rig.commands.push_back({rig.now_ns, 0, 0, Request::ResetFault});
    rig.cycle();
    EXPECT_EQ(rig.bridge.state(), State::Stop) << static_cast<int>(state);
    EXPECT_EQ(rig.bridge.fault(), Fault::EStop) << static_cast<int>(state);
  }
}

can::Frame foreign(std::uint32_t id) {
  can::Frame frame;
  frame.id = id;
  frame.size = id < 0x200 ? 0 : 6;
  return frame;
}

/// What a second bridge, canplayer, or a process that left frames in a queue sends: identifiers of the predefined connection set.
class ForeignOrders : public ::testing::TestWithParam<std::uint32_t> {};

TEST_P(ForeignOrders, StopAMotionAndForbidArming) {
  Rig rig(six_drives(6, 2));
  ASSERT_TRUE(rig.configure()) << rig.told();
  rig.cycles(2);
  rig.buses[1].to_bridge.push_back({foreign(GetParam()), rig.now_ns, false});
  rig.command(Request::Arm);
  rig.cycles(100);
  EXPECT_EQ(rig.bridge.state(), State::Idle) << "armed beside another master";
  EXPECT_TRUE(rig.has_event(static_cast<std::int32_t>(Notice::ForeignFrames)));
  rig.run_for(1000 * kMs);
  ASSERT_TRUE(rig.run(swing)) << "not armed after the other master had gone\n" << rig.told();
  const std::int64_t since_ns = rig.now_ns;
  rig.buses[1].to_bridge.push_back({foreign(GetParam()), rig.now_ns, false});
  rig.cycle();
  EXPECT_EQ(rig.bridge.fault(), Fault::ForeignMaster) << rig.told();
  for (const FakeDrive& drive : rig.drives) EXPECT_EQ(rig.last_rpdo(drive.node).first, 0x02);
  show_reaction("foreign master", rig, since_ns);
}

INSTANTIATE_TEST_SUITE_P(Identifiers, ForeignOrders, ::testing::Values(0x000, 0x080, 0x205, 0x306, 0x404, 0x506, 0x77F),
                         [](const auto& one) { return "id" + std::to_string(one.param); });

TEST(BridgeSafety, FramesOfOtherDevicesAndOwnEchoesAreNoForeignOrders) {
  Rig rig(six_drives(6, 2));
  ASSERT_TRUE(rig.run(swing)) << rig.told();
  for (const std::uint32_t id : {0x081U, 0x185U, 0x201U, 0x20AU, 0x285U, 0x385U, 0x485U, 0x585U, 0x605U, 0x77EU, 0x7E5U})
    rig.buses[1].to_bridge.push_back({foreign(id), rig.now_ns, false});  // node 1 is on the other bus
  rig.buses[1].to_bridge.push_back({foreign(0x080), rig.now_ns, true});
  rig.buses[1].to_bridge.push_back({foreign(0x205), rig.now_ns, true});
  rig.cycles(3);
  EXPECT_EQ(rig.bridge.state(), State::Run) << rig.told();
}

TEST(BridgeSafety, DriveThatKeepsItsPowerAfterDisarmingIsAFault) {
  Rig rig(six_drives(2));
  ASSERT_TRUE(rig.arm()) << rig.told();
  rig.drives[1].keeps_power = true;
  rig.command(Request::Disarm);
  rig.run_for(rig.settings.state_timeout_ns / 2);
  EXPECT_EQ(rig.bridge.state(), State::Idle);
  rig.command(Request::Arm);
  rig.cycle();
  EXPECT_EQ(rig.bridge.session(), 0) << "armed while a drive does not obey";
  rig.run_for(rig.settings.state_timeout_ns);
  EXPECT_EQ(rig.bridge.state(), State::Fault) << rig.told();
  EXPECT_EQ(rig.bridge.fault(), Fault::DriveKeepsPower);
  EXPECT_EQ(rig.last_rpdo(2).first, 0x00);
  rig.command(Request::ResetFault);
  rig.cycles(3);
  rig.command(Request::Arm);
  rig.run_for(100 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Idle) << rig.told();
  EXPECT_EQ(rig.bridge.session(), 0);
}

TEST(BridgeSafety, DriveThatKeepsItsPowerAfterAnEStopIsToldOnce) {
  Rig rig(six_drives(2));
  ASSERT_TRUE(rig.arm()) << rig.told();
  rig.drives[1].keeps_power = true;
  rig.local_estop = true;
  rig.run_for(5000 * kMs);
  EXPECT_EQ(rig.bridge.fault(), Fault::EStop);
  const auto told = std::count_if(rig.events.begin(), rig.events.end(), [](const Event& e) {
    return e.code == static_cast<std::int32_t>(Fault::DriveKeepsPower);
  });
  EXPECT_EQ(told, 1) << rig.told();
}

TEST(BridgeSafety, BusOffBesideAnotherFaultIsToldOnce) {
  Rig rig(six_drives(6, 2));
  ASSERT_TRUE(rig.run(swing)) << rig.told();
  rig.local_estop = true;
  rig.cycle();
  for (const std::size_t bus : {0U, 1U}) rig.error_frame(bus, can::make_error(can::ControllerState::Off, 248, 0));
  rig.run_for(100 * kMs);
  const auto told = std::count_if(rig.events.begin(), rig.events.end(),
                                  [](const Event& e) { return e.code == static_cast<std::int32_t>(Fault::BusOff); });
  EXPECT_EQ(told, 2) << rig.told();  // once a bus
}

/// An echo that was lost, or frames that wait while nothing is armed: the reset clears the way as a stop would.
TEST(BridgeSafety, ResetPurgesWhatWaitsWhileIdle) {
  Rig rig(six_drives(2));
  ASSERT_TRUE(rig.configure()) << rig.told();
  rig.buses[0].stalled = true;
  rig.cycles(3);
  rig.command(Request::Arm);
  rig.cycles(3);
  ASSERT_EQ(rig.bridge.state(), State::Idle);
  ASSERT_FALSE(rig.buses[0].queue.empty());
  rig.command(Request::ResetFault);
  rig.cycle();
  EXPECT_EQ(rig.buses[0].purges, 1);
  rig.buses[0].stalled = false;
  EXPECT_TRUE(rig.arm()) << rig.told();
}

/// A source that has the token and sends whatever can be encoded: stamps close together, far apart, early and late, numbers that
/// jump, finite values of any size.
class HostileSource : public ::testing::TestWithParam<TimeBase> {};

TEST_P(HostileSource, NeverMovesAJointFasterThanItsLimits) {
  Random random(55);
  for (int k = test_count(20); k > 0; --k) {
    Settings settings = six_drives(2);
    settings.time_base = GetParam();
    Rig rig(settings);
    ASSERT_TRUE(rig.run(swing)) << rig.told();
    rig.wire.clear();
    std::int64_t stamp_ns = rig.now_ns;
    for (int n = 0; n < 2000 && rig.bridge.state() == State::Run; ++n) {
      for (int m = static_cast<int>(random.uniform(0.0, 4.0)); m > 0; --m) {
        Setpoint hostile = rig.setpoint_now();
        const auto pick = static_cast<int>(random.uniform(0.0, 4.0));
        stamp_ns = pick == 0   ? stamp_ns + 1
                   : pick == 1 ? rig.now_ns + static_cast<std::int64_t>(random.uniform(-60e6, 110e6))
                               : rig.now_ns;
        hostile.time_ns = stamp_ns;
        for (std::size_t j = 0; j < settings.joints.size(); ++j) {
          if (random.uniform(0.0, 1.0) < 0.5)
            hostile.position_rad[j] = rig.bridge.command_rad()[j] + random.uniform(-0.06, 0.06);
          if (random.uniform(0.0, 1.0) < 0.5)
            hostile.velocity_rad_per_s[j] = std::copysign(random.log_uniform(1e-3, 1.7e308), random.uniform(-1.0, 1.0));
        }
        rig.setpoints.push_back(hostile);
      }
      rig.cycle();
      ASSERT_TRUE(std::isfinite(rig.bridge.command_rad()[0]));
    }
    EXPECT_NE(rig.bridge.fault(), Fault::CountOverflow) << rig.told();
    ASSERT_NO_FATAL_FAILURE(expect_steps_within_limits(rig));
  }
}

INSTANTIATE_TEST_SUITE_P(TimeBases, HostileSource, ::testing::Values(TimeBase::Stamp, TimeBase::Estimated),
                         [](const auto& one) { return one.param == TimeBase::Stamp ? "Stamp" : "Estimated"; });

/// Between two setpoints with a long pause the cubic would leave the range of a double: it is a rejection, not a fault.
TEST(BridgeSafety, VelocitiesThatNoJointHasAreRejected) {
  Rig rig(six_drives(2));
  ASSERT_TRUE(rig.arm()) << rig.told();
  rig.motion = [](double) {
    Sample sample;
    sample.position_rad.fill(0.3);
    sample.velocity_rad_per_s.fill(1.7e308);
    return sample;
  };
  rig.cycles(2);
  rig.motion = nullptr;
  rig.run_for(10'000 * kMs);
  rig.motion = swing;
  rig.command(Request::Start);
  rig.run_for(200 * kMs);
  EXPECT_EQ(rig.bridge.fault(), Fault::None) << rig.told();
  EXPECT_TRUE(std::any_of(rig.statuses.begin(), rig.statuses.end(),
                          [](const Status& s) { return s.last_rejection == Rejection::Velocity; }));
}

}  // namespace
}  // namespace glenoid::bridge::test
