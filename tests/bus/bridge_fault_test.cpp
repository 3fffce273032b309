// Every way things go wrong: the bridge stops all drives, says why, and stays stopped until it is told otherwise.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bridge_motions.hpp"
#include "host/bridge/can/error_frame.hpp"
#include "host/bridge/core/cia402.hpp"
#include "host/bridge/core/codec.hpp"

namespace glenoid::bridge::test {
namespace {

class Running : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(rig.run(swing)) << rig.told(); }

  /// All drives are told to quick-stop within `within_ns` of `since_ns`, the fault is latched and what follows moves nobody.
  void expect_stop(Fault fault, State state, std::int64_t since_ns, std::int64_t within_ns, const char* name) {
    rig.run_until([&] { return rig.bridge.state() == state; }, within_ns + rig.settings.period_ns);
    EXPECT_EQ(rig.bridge.state(), state) << rig.told();
    EXPECT_EQ(rig.bridge.fault(), fault) << rig.told();
    const double command = rig.bridge.command_rad()[0];
    rig.cycles(3);
    for (const FakeDrive& drive : rig.drives)
      if (!drive.dead && rig.last_rpdo(drive.node).first != 0xFFFF) {
        EXPECT_NE(rig.last_rpdo(drive.node).first & 0x0F, 0x0F) << int{drive.node};
      }
    rig.run_for(700 * kMs);
    EXPECT_EQ(rig.bridge.state(), state);
    EXPECT_EQ(rig.bridge.session(), 0);
    EXPECT_TRUE(rig.has_event(static_cast<std::int32_t>(fault)));
    EXPECT_NEAR(rig.bridge.command_rad()[0], command, 1e-3);
    show_reaction(name, rig, since_ns);
  }

  Rig rig{six_drives()};
};

TEST_F(Running, StreamEndsThenHoldThenQuickStopThenDisarm) {
  rig.motion = nullptr;
  const std::int64_t since_ns = rig.now_ns;
  const Settings& s = rig.settings;
  // The last setpoint came half a period before `since`.
  ASSERT_TRUE(rig.run_until([&] { return rig.bridge.state() == State::Hold; }, s.hold_after_ns)) << rig.told();
  for (const FakeDrive& drive : rig.drives) EXPECT_EQ(rig.last_rpdo(drive.node).first, 0x0F);
  const double speed_before = std::abs(rig.feedback.back().velocity_rad_per_s[0]);
  rig.cycles(10);
  EXPECT_LT(std::abs(rig.feedback.back().velocity_rad_per_s[0]), speed_before);
  ASSERT_EQ(rig.bridge.state(), State::Hold);
  ASSERT_TRUE(rig.run_until([&] { return rig.bridge.state() == State::Stop; }, s.quick_stop_after_ns));
  EXPECT_LE(rig.now_ns - since_ns, s.quick_stop_after_ns + s.period_ns);
  EXPECT_EQ(rig.last_rpdo(1).first, 0x02);
  EXPECT_NE(rig.bridge.session(), 0);
  ASSERT_TRUE(rig.run_until([&] { return rig.bridge.session() == 0; }, s.disarm_after_ns));
  EXPECT_LE(rig.now_ns - since_ns, s.disarm_after_ns + s.period_ns);
  EXPECT_EQ(rig.last_rpdo(1).first, 0x00);
  EXPECT_EQ(rig.bridge.fault(), Fault::StaleSetpoints);
  rig.motion = swing;  // a stream that comes back finds the door closed
  rig.run_for(200 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Stop);
  show_reaction("stream stops", rig, since_ns);
}

TEST_F(Running, ShortGapIsHeldAndThenFollowedAgain) {
  rig.motion = nullptr;
  rig.run_for(20 * kMs);
  ASSERT_EQ(rig.bridge.state(), State::Hold);
  rig.motion = swing;
  rig.run_for(500 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Run) << rig.told();
  EXPECT_NEAR(rig.bridge.command_rad()[0],
              swing(rig.seconds() - 1e-9 * static_cast<double>(rig.settings.delay_ns)).position_rad[0], 1e-6);
}

TEST_F(Running, HoldStaysWithinTheAccelerationLimit) {
  rig.feedback.clear();
  rig.motion = nullptr;
  rig.run_for(40 * kMs);
  const double T = 1e-9 * static_cast<double>(rig.settings.period_ns);
  for (std::size_t k = 2; k < rig.feedback.size(); ++k) {
    const double change = rig.feedback[k].command_rad[0] - 2 * rig.feedback[k - 1].command_rad[0] +
                          rig.feedback[k - 2].command_rad[0];
    ASSERT_LE(std::abs(change) / (T * T), rig.settings.joints[0].acceleration_rad_per_s2 * (1 + 1e-6) + 1e-6);
  }
}

struct BadSetpoint {
  const char* name;
  Rejection reason;
  void (*spoil)(Setpoint&);
};

class BadSetpoints : public ::testing::TestWithParam<BadSetpoint> {};

TEST_P(BadSetpoints, OneIsRejectedWholeAndTheMotionGoesOn) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.run(swing)) << rig.told();
  rig.feedback.clear();
  Setpoint bad = rig.setpoint_now();
  --rig.sequence;
  bad.time_ns += kMs / 2;
  GetParam().spoil(bad);
  rig.setpoints.push_back(bad);
  rig.run_for(100 * kMs);
  EXPECT_EQ(rig.statuses.back().setpoints_rejected, 1) << rig.told();
  EXPECT_EQ(rig.statuses.back().last_rejection, GetParam().reason);
  EXPECT_EQ(rig.bridge.state(), State::Run);
  const double tolerance = std::pow(0.002, 4) * 0.15 * 16 / 384 + 1e-12;
  for (const Feedback& feedback : rig.feedback) {
    const double t = 1e-9 * static_cast<double>(feedback.time_ns - rig.settings.delay_ns);
    ASSERT_NEAR(feedback.command_rad[0], swing(t).position_rad[0], tolerance);
  }
}

TEST_P(BadSetpoints, AStreamOfThemEndsInAQuickStop) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.run(swing)) << rig.told();
  const std::int64_t since_ns = rig.now_ns;
  const auto stop = [&] { return rig.bridge.state() == State::Stop || rig.bridge.state() == State::Fault; };
  for (int k = 0; k < 30 && !stop(); ++k) {
    rig.motion = swing;
    Setpoint bad = rig.setpoint_now();
    rig.motion = nullptr;
    GetParam().spoil(bad);
    rig.setpoints.push_back(bad);
    rig.cycle();
  }
  EXPECT_TRUE(stop()) << rig.told();
  EXPECT_LE(rig.now_ns - since_ns, rig.settings.quick_stop_after_ns + 2 * rig.settings.period_ns);
  rig.cycles(2);
  show_reaction(GetParam().name, rig, since_ns);
}

INSTANTIATE_TEST_SUITE_P(
    Gate, BadSetpoints,
    ::testing::Values(
        BadSetpoint{"nan position", Rejection::NotFinite,
                    [](Setpoint& s) { s.position_rad[2] = std::numeric_limits<double>::quiet_NaN(); }},
        BadSetpoint{"infinite velocity", Rejection::NotFinite,
                    [](Setpoint& s) { s.velocity_rad_per_s[5] = std::numeric_limits<double>::infinity(); }},
        BadSetpoint{"nan effort", Rejection::NotFinite,
                    [](Setpoint& s) { s.effort_feedforward_Nm[0] = std::numeric_limits<double>::quiet_NaN(); }},
        BadSetpoint{"count", Rejection::Count, [](Setpoint& s) { s.count = 5; }},
        BadSetpoint{"negative count", Rejection::Count, [](Setpoint& s) { s.count = -1; }},
        BadSetpoint{"mask", Rejection::Mask, [](Setpoint& s) { s.valid_mask = 0x1F; }},
        BadSetpoint{"wrong token", Rejection::Session, [](Setpoint& s) { s.session ^= 2; }},
        BadSetpoint{"token zero", Rejection::Session, [](Setpoint& s) { s.session = 0; }},
        BadSetpoint{"old sequence", Rejection::Sequence, [](Setpoint& s) { s.sequence = 1; }},
        BadSetpoint{"old", Rejection::Age, [](Setpoint& s) { s.time_ns -= 60 * kMs; }},
        BadSetpoint{"future", Rejection::Future, [](Setpoint& s) { s.time_ns += 1000 * kMs; }},
        BadSetpoint{"negative stamp", Rejection::Age, [](Setpoint& s) { s.time_ns = -1; }},
        BadSetpoint{"negative sequence", Rejection::Sequence,
                    [](Setpoint& s) { s.sequence = std::numeric_limits<std::int64_t>::min(); }},
        BadSetpoint{"impossible velocity", Rejection::Velocity, [](Setpoint& s) { s.velocity_rad_per_s[1] = -1e4; }},
        BadSetpoint{"stamp at the end of time", Rejection::Future,
                    [](Setpoint& s) { s.time_ns = std::numeric_limits<std::int64_t>::max(); }},
        BadSetpoint{"jump", Rejection::Step, [](Setpoint& s) { s.position_rad[3] += 0.5; }}),
    [](const auto& tested) {
      std::string name = tested.param.name;
      for (char& c : name) c = c == ' ' ? '_' : c;
      return name;
    });

TEST_F(Running, RepeatedSequenceIsRejectedWithoutHarm) {
  rig.motion = nullptr;
  for (int k = 0; k < 20; ++k) {
    rig.motion = swing;
    const Setpoint setpoint = rig.setpoint_now();
    rig.motion = nullptr;
    rig.setpoints = {setpoint, setpoint};
    rig.cycle();
  }
  EXPECT_EQ(rig.bridge.state(), State::Run) << rig.told();
  rig.run_for(150 * kMs);
  EXPECT_EQ(rig.statuses.back().last_rejection, Rejection::Sequence);
  EXPECT_GE(rig.statuses.back().setpoints_rejected, 20);
}

TEST_F(Running, SecondPublisherIsAFault) {
  const std::int64_t since_ns = rig.now_ns;
  for (int k = 0; k < 4 && rig.bridge.state() == State::Run; ++k) {
    Setpoint other = rig.setpoint_now();
    --rig.sequence;
    other.time_ns += kMs / 4;
    other.sequence = 10 + k;
    rig.setpoints.push_back(other);
    rig.cycle();
  }
  expect_stop(Fault::TwoPublishers, State::Fault, since_ns, 10 * kMs, "second publisher");
}

TEST_F(Running, EmergencyOfOneDriveStopsAll) {
  const std::int64_t since_ns = rig.now_ns;
  can::Frame emcy;
  emcy.id = 0x083;
  emcy.size = 8;
  emcy.data = {0x10, 0x23, 0x02};  // 2310h over-current
  rig.error_frame(0, emcy);
  expect_stop(Fault::DriveEmergency, State::Fault, since_ns, rig.settings.period_ns, "EMCY");
  EXPECT_NE(rig.told().find("over-current"), std::string::npos);
}

TEST_F(Running, DriveInFaultStopsAll) {
  const std::int64_t since_ns = rig.now_ns;
  rig.drives[4].statusword = 0x0208;
  expect_stop(Fault::DriveFault, State::Fault, since_ns, 2 * rig.settings.period_ns, "drive fault");
}

TEST_F(Running, DriveThatLeavesOperationStopsAll) {
  const std::int64_t since_ns = rig.now_ns;
  rig.drives[1].statusword = 0x0240;
  expect_stop(Fault::DriveLeftOperation, State::Fault, since_ns, 2 * rig.settings.period_ns, "left operation");
}

TEST_F(Running, DriveThatIgnoresItsTargetStopsAll) {
  const std::int64_t since_ns = rig.now_ns;
  rig.drives[1].follows = false;
  expect_stop(Fault::DriveNotFollowing, State::Fault, since_ns, 3 * rig.settings.period_ns, "bit 12 lost");
}

TEST_F(Running, DriveThatVanishesStopsAll) {
  const std::int64_t since_ns = rig.now_ns;
  rig.drives[3].dead = true;
  expect_stop(Fault::FeedbackLost, State::Fault, since_ns, (rig.settings.feedback_misses + 1) * rig.settings.period_ns,
              "drive vanishes");
}

TEST_F(Running, SilentBusIsTold) {
  const std::int64_t since_ns = rig.now_ns;
  for (FakeDrive& drive : rig.drives) drive.mute_pdo = true;
  expect_stop(Fault::BusSilent, State::Fault, since_ns, (rig.settings.feedback_misses + 1) * rig.settings.period_ns,
              "bus silent");
}

TEST_F(Running, RebootStopsAll) {
  const std::int64_t since_ns = rig.now_ns;
  std::vector<can::Frame> boot;
  rig.drives[0].reboot(boot);
  rig.error_frame(0, boot.front());
  expect_stop(Fault::DriveRebooted, State::Fault, since_ns, rig.settings.period_ns, "drive reboots");
}

TEST_F(Running, LostHeartbeatStopsAll) {
  const std::int64_t since_ns = rig.now_ns;
  rig.drives[5].mute_heartbeat = true;
  expect_stop(Fault::HeartbeatLost, State::Fault, since_ns, rig.settings.heartbeat_timeout_ns, "heartbeat lost");
}

TEST_F(Running, DriveThatDropsToPreOperationalStopsAll) {
  const std::int64_t since_ns = rig.now_ns;
  rig.drives[5].nmt = 0x7F;
  rig.run_until([&] { return rig.bridge.state() == State::Fault; }, 200 * kMs);
  EXPECT_TRUE(rig.bridge.fault() == Fault::DriveLeftNmt || rig.bridge.fault() == Fault::FeedbackLost) << rig.told();
  show_reaction("NMT left", rig, since_ns);
}

TEST_F(Running, BusOffSilencesTheBusAndIsLatched) {
  const std::int64_t since_ns = rig.now_ns;
  rig.error_frame(0, can::make_error(can::ControllerState::Off, 248, 0));
  const std::size_t before = rig.wire.size();
  rig.cycle();
  EXPECT_EQ(rig.bridge.fault(), Fault::BusOff);
  rig.cycles(100);
  std::size_t after_step = 0;
  for (std::size_t k = before; k < rig.wire.size(); ++k)
    if (rig.wire[k].from_bridge && rig.wire[k].time_ns > since_ns) ++after_step;
  EXPECT_EQ(after_step, 0U);  // one SYNC was out before the report was read
  EXPECT_EQ(rig.buses[0].purges, 1);
  rig.error_frame(0, can::make_error(can::ControllerState::Active, 0, 0));  // the driver restarted by itself
  rig.cycles(10);
  EXPECT_EQ(rig.bridge.fault(), Fault::BusOff);
  EXPECT_EQ(rig.statuses.back().bus[0].state, BusState::Off);
  show_reaction("bus-off", rig, since_ns);
}

TEST_F(Running, LinkDownStopsTheOthersAndIsConfiguredAgain) {
  const std::int64_t since_ns = rig.now_ns;
  rig.buses[0].link = can::Link::Gone;
  rig.cycle();
  EXPECT_EQ(rig.bridge.fault(), Fault::LinkDown) << rig.told();
  rig.run_for(600 * kMs);
  rig.command(Request::ResetFault);
  rig.cycle();
  EXPECT_EQ(rig.bridge.state(), State::Fault);  // not while the link is down
  rig.buses[0].link = can::Link::Up;
  rig.run_for(100 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Fault);  // and never by itself
  rig.motion = nullptr;
  rig.command(Request::ResetFault);
  ASSERT_TRUE(rig.run_until([&] { return rig.bridge.configured(); }, 5000 * kMs)) << rig.told();
  EXPECT_EQ(rig.bridge.state(), State::Idle);
  show_reaction("interface down", rig, since_ns);
}

TEST(BridgeFault, LinkOfOneBusStopsTheDrivesOfTheOther) {
  Rig rig(six_drives(6, 2));
  ASSERT_TRUE(rig.run(swing)) << rig.told();
  rig.buses[1].link = can::Link::Down;
  rig.cycles(2);
  EXPECT_EQ(rig.bridge.fault(), Fault::LinkDown);
  for (std::uint8_t node = 1; node <= 3; ++node) EXPECT_EQ(rig.last_rpdo(node).first, 0x02);
}

TEST_F(Running, LocalEStopDuringMotionIsLatched) {
  const std::int64_t since_ns = rig.now_ns;
  rig.local_estop = true;
  rig.cycle();
  EXPECT_EQ(rig.bridge.state(), State::Stop);
  for (const FakeDrive& drive : rig.drives) EXPECT_EQ(rig.last_rpdo(drive.node).first, 0x02);
  rig.run_for(600 * kMs);
  rig.command(Request::ResetFault);
  rig.cycle();
  EXPECT_EQ(rig.bridge.state(), State::Stop) << "reset while the button is pressed";
  rig.local_estop = false;
  rig.run_for(100 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Stop) << "releasing the button is not a reset";
  rig.command(Request::Arm);
  rig.cycle();
  EXPECT_EQ(rig.bridge.state(), State::Stop) << "arming is not a reset";
  rig.motion = nullptr;
  rig.command(Request::ResetFault);
  rig.run_for(20 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Idle);
  rig.command(Request::Arm);
  EXPECT_TRUE(rig.run_until([&] { return rig.bridge.state() == State::Ready; }, 2000 * kMs)) << rig.told();
  show_reaction("e-stop", rig, since_ns);
}

TEST_F(Running, EStopMessageNeedsNoTokenAndNoFreshStamp) {
  rig.command(Command{0, 0, 0, Request::EStop});
  rig.cycle();
  EXPECT_EQ(rig.bridge.state(), State::Stop);
  EXPECT_EQ(rig.bridge.fault(), Fault::EStop);
}

TEST_F(Running, EStopBeatsEverythingOfTheSameCycle) {
  rig.command(Request::EStop);
  rig.command(Request::ResetFault);
  rig.command(Request::Arm);
  rig.command(Request::Start);
  rig.cycle();
  EXPECT_EQ(rig.bridge.state(), State::Stop);
}

TEST_F(Running, QueuedFramesMoveNobodyAfterAnEStop) {
  rig.buses[0].stalled = true;
  rig.cycles(2);
  ASSERT_FALSE(rig.buses[0].queue.empty());
  rig.local_estop = true;
  rig.cycle();
  rig.cycle();
  EXPECT_GE(rig.buses[0].purges, 1);
  const auto positions = [&] {
    std::vector<std::int32_t> all;
    for (const FakeDrive& drive : rig.drives) all.push_back(drive.position);
    return all;
  };
  const auto before = positions();
  rig.buses[0].stalled = false;
  rig.run_for(200 * kMs);
  EXPECT_EQ(positions(), before);
  EXPECT_FALSE(rig.statuses.back().purge_needed);
}

TEST_F(Running, WithoutAPurgeArmingIsRefused) {
  rig.buses[0].stalled = true;
  rig.buses[0].can_purge = false;
  rig.cycles(2);
  rig.local_estop = true;
  rig.run_for(600 * kMs);
  EXPECT_TRUE(rig.statuses.back().purge_needed);
  const std::size_t queued = rig.buses[0].queue.size();
  rig.run_for(200 * kMs);
  EXPECT_EQ(rig.buses[0].queue.size(), queued) << "nothing is added to a queue that does not move";
  rig.local_estop = false;
  rig.motion = nullptr;
  rig.command(Request::ResetFault);
  rig.cycle();
  rig.command(Request::Arm);
  rig.run_for(100 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Idle);
  EXPECT_TRUE(rig.has_event(static_cast<std::int32_t>(Notice::Refused)));
}

TEST_F(Running, UnsentFramesSkipTheCycleThenFault) {
  rig.buses[0].stalled = true;
  rig.cycle();
  const std::size_t queued = rig.buses[0].queue.size();
  rig.cycles(3);
  EXPECT_EQ(rig.buses[0].queue.size(), queued) << "commands pile up";
  EXPECT_EQ(rig.bridge.state(), State::Run);
  rig.cycles(rig.settings.transmit_skips);
  EXPECT_TRUE(rig.bridge.fault() == Fault::TransmitStalled || rig.bridge.fault() == Fault::BusSilent) << rig.told();
}

TEST_F(Running, RefusedFramesAreNeverSentLaterAndFault) {
  rig.buses[0].refuses = true;
  rig.run_for(20 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Fault);
  EXPECT_TRUE(rig.bridge.fault() == Fault::TransmitStalled || rig.bridge.fault() == Fault::BusSilent) << rig.told();
}

TEST_F(Running, FollowingErrorStopsAll) {
  const std::int64_t since_ns = rig.now_ns;
  rig.drives[2].stuck = true;
  rig.drives[2].position += static_cast<std::int32_t>(0.15 * 100 * 4096 / 6.283);
  expect_stop(Fault::FollowingError, State::Fault, since_ns, rig.settings.joints[2].following_time_ns + 4 * kMs,
              "following error");
}

TEST_F(Running, DriveThatDoesNotFollowLosesItsPowerAtOnceAndTheOthersBrake) {
  rig.drives[2].stuck = true;
  rig.drives[2].position += static_cast<std::int32_t>(0.15 * 100 * 4096 / 6.283);
  while (rig.bridge.state() == State::Run) rig.cycle();
  ASSERT_EQ(rig.bridge.fault(), Fault::FollowingError);
  for (std::size_t j = 0; j < rig.drives.size(); ++j) {
    const std::uint16_t expected = j == 2 ? cia402::kDisableVoltage : cia402::kQuickStop;
    EXPECT_EQ(rig.last_rpdo(static_cast<std::uint8_t>(j + 1)).first, expected) << "joint " << j;
  }
}

TEST_F(Running, MeasuredPositionOutsideTheLimitsStopsAll) {
  const std::int64_t since_ns = rig.now_ns;
  rig.drives[2].stuck = true;
  rig.drives[2].position = Scale(rig.settings.joints[2]).counts(2.15).value();
  expect_stop(Fault::MeasuredOutOfRange, State::Fault, since_ns, 2 * rig.settings.period_ns, "measured out of range");
}

TEST_F(Running, StoppedProcessDoesNotBurst) {
  // As after SIGSTOP and SIGCONT: the loop leaves the numbers out that it overran.
  rig.sync_number += 500;
  rig.now_ns += 500 * rig.settings.period_ns;
  const std::size_t before = rig.wire.size();
  const auto position = rig.drives[0].position;
  rig.cycle();
  std::size_t frames = 0;
  for (std::size_t k = before; k < rig.wire.size(); ++k) frames += rig.wire[k].from_bridge ? 1U : 0U;
  EXPECT_LE(frames, 7U);  // RPDOs with the quick stop, heartbeat; no SYNC before them
  EXPECT_EQ(rig.bridge.state(), State::Stop);
  EXPECT_EQ(rig.bridge.fault(), Fault::LoopStalled);
  EXPECT_EQ(rig.statuses.back().cycles_skipped, 500);
  rig.run_for(600 * kMs);
  EXPECT_EQ(rig.drives[0].position, position);
}

TEST_F(Running, LimitWithStopPolicyIsAFault) {
  Settings settings = six_drives();
  settings.joints[1].on_limit = OnLimit::Stop;
  settings.joints[1].upper_rad = 0.4;
  Rig strict(settings);
  ASSERT_TRUE(strict.arm()) << strict.told();
  strict.motion = swing;
  strict.cycles(5);
  strict.command(Request::Start);
  strict.run_for(4000 * kMs);
  EXPECT_EQ(strict.bridge.fault(), Fault::LimitExceeded) << strict.told();
}

TEST(BridgeFault, ClampedLimitIsRecoverable) {
  Settings settings = six_drives();
  settings.joints[1].upper_rad = 0.4;  // the swing goes to 0.45
  Rig rig(settings);
  ASSERT_TRUE(rig.run(swing)) << rig.told();
  rig.feedback.clear();
  rig.run_for(4000 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Run) << rig.told();
  double highest = 0.0, lowest = 1.0;
  for (const Feedback& feedback : rig.feedback) {
    highest = std::max(highest, feedback.command_rad[1]);
    lowest = std::min(lowest, feedback.command_rad[1]);
  }
  EXPECT_LE(highest, 0.4 + 1e-12);
  EXPECT_GE(highest, 0.39);
  EXPECT_NEAR(lowest, 0.15, 1e-3);
  EXPECT_TRUE(rig.has_event(static_cast<std::int32_t>(Notice::Limited)));
}

TEST(BridgeFault, FirstSetpointFarFromTheJointIsRefused) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.arm()) << rig.told();
  rig.motion = [](double) {
    Sample sample;
    sample.position_rad.fill(0.3 + 0.21);
    return sample;
  };
  rig.run_for(200 * kMs);
  EXPECT_EQ(rig.statuses.back().last_rejection, Rejection::StartDistance) << rig.told();
  rig.command(Request::Start);
  rig.run_for(2500 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Ready);
  EXPECT_NEAR(rig.bridge.command_rad()[0], 0.3, 1e-4);
}

TEST(BridgeFault, SetpointsWithoutArmingAreNotUsed) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.configure()) << rig.told();
  rig.motion = swing;
  rig.run_for(200 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Idle);
  EXPECT_EQ(rig.statuses.back().last_rejection, Rejection::NotArmed);
  EXPECT_EQ(rig.last_rpdo(1).first, 0x00);
}

TEST(BridgeFault, RecordedRequestsDoNotArm) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.configure()) << rig.told();
  rig.cycles(2);
  rig.command(Command{rig.now_ns - 2000 * kMs, 1, 0, Request::Arm});
  rig.run_for(200 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Idle);
  EXPECT_EQ(rig.drives[0].statusword & 0x6F, 0x40);
}

TEST(BridgeFault, EveryArmingHasItsOwnToken) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.arm()) << rig.told();
  const std::int64_t first = rig.bridge.session();
  rig.command(Request::Disarm);
  rig.run_for(50 * kMs);
  ASSERT_EQ(rig.bridge.state(), State::Idle) << rig.told();
  rig.command(Request::Arm);
  ASSERT_TRUE(rig.run_until([&] { return rig.bridge.state() == State::Ready; }, 2000 * kMs)) << rig.told();
  EXPECT_NE(rig.bridge.session(), first);
  EXPECT_NE(rig.bridge.session(), 0);
}

TEST(BridgeFault, OneDriveThatCannotBeEnabledStopsAll) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.configure()) << rig.told();
  rig.cycles(2);
  rig.drives[3].refuses_enable = true;
  rig.command(Request::Arm);
  rig.run_until([&] { return rig.bridge.state() == State::Fault; }, 5000 * kMs);
  EXPECT_EQ(rig.bridge.fault(), Fault::EnableTimeout) << rig.told();
  rig.run_for(600 * kMs);
  for (const FakeDrive& drive : rig.drives) EXPECT_NE(drive.statusword & 0x6F, 0x27);
}

TEST(BridgeFault, ReadyNeedsBit12) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.configure()) << rig.told();
  rig.cycles(2);
  rig.drives[3].follows = false;
  rig.command(Request::Arm);
  rig.run_for(500 * kMs);
  EXPECT_NE(rig.bridge.state(), State::Ready);
  EXPECT_EQ(rig.bridge.session(), 0);
}

TEST(BridgeFault, ResetGivesOneRisingEdgeOnlyOnRequest) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.configure()) << rig.told();
  rig.cycles(2);
  rig.drives[0].statusword = 0x0208;
  rig.run_for(500 * kMs);
  for (const Wire& entry : rig.wire)
    if (entry.from_bridge && entry.frame.id == 0x201) {
      ASSERT_EQ(entry.frame.data[0] & 0x80, 0);
    }
  rig.command(Request::Arm);
  rig.run_for(50 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Idle) << "a drive in fault cannot be armed";
  const std::size_t before = rig.wire.size();
  rig.command(Request::ResetFault);
  rig.run_for(500 * kMs);
  int edges = 0;
  std::uint8_t last = 0;
  for (std::size_t k = before; k < rig.wire.size(); ++k) {
    if (!rig.wire[k].from_bridge || rig.wire[k].frame.id != 0x201) continue;
    edges += (rig.wire[k].frame.data[0] & 0x80) != 0 && (last & 0x80) == 0 ? 1 : 0;
    last = rig.wire[k].frame.data[0];
  }
  EXPECT_EQ(edges, 1);
  EXPECT_EQ(rig.drives[0].statusword & 0x6F, 0x40);
}

TEST(BridgeFault, FaultThatStaysIsTriedThreeTimes) {
  Rig rig(six_drives(1));
  ASSERT_TRUE(rig.configure()) << rig.told();
  rig.cycles(2);
  const std::size_t before = rig.wire.size();
  rig.command(Request::ResetFault);
  for (int k = 0; k < 1000; ++k) {
    rig.drives[0].statusword = 0x0208;
    rig.cycle();
  }
  int edges = 0;
  std::uint8_t last = 0;
  for (std::size_t k = before; k < rig.wire.size(); ++k) {
    if (!rig.wire[k].from_bridge || rig.wire[k].frame.id != 0x201) continue;
    edges += (rig.wire[k].frame.data[0] & 0x80) != 0 && (last & 0x80) == 0 ? 1 : 0;
    last = rig.wire[k].frame.data[0];
  }
  EXPECT_EQ(edges, 3);
}

}  // namespace
}  // namespace glenoid::bridge::test
