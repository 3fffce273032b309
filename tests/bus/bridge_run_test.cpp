// From nothing to drives that follow a motion.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bridge_motions.hpp"
#include "host/bridge/core/codec.hpp"

namespace glenoid::bridge::test {
namespace {

using Key = std::uint32_t;

std::size_t place(const FakeDrive& drive, std::uint32_t index, std::uint32_t sub, bool last = false) {
  const Key key = FakeDrive::key(index, sub);
  if (last)
    return static_cast<std::size_t>(drive.writes.rend() - std::find(drive.writes.rbegin(), drive.writes.rend(), key));
  return static_cast<std::size_t>(std::find(drive.writes.begin(), drive.writes.end(), key) - drive.writes.begin()) + 1;
}

TEST(BridgeRun, SixDrivesReachOperationEnabledAndFollow) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.run(swing)) << rig.told();
  const std::int64_t accepted_before = rig.statuses.back().setpoints_accepted;
  rig.run_for(2000 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Run) << rig.told();
  EXPECT_EQ(rig.statuses.back().setpoints_rejected, 0);
  EXPECT_GT(rig.statuses.back().setpoints_accepted, accepted_before + 900);
  for (const FakeDrive& drive : rig.drives) EXPECT_EQ(drive.statusword & 0x6F, 0x27);
}

TEST(BridgeRun, CommandIsTheMotionDelayedByTheConfiguredTime) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.run(swing)) << rig.told();
  rig.feedback.clear();
  rig.run_for(1000 * kMs);
  // Cubic Hermite: h^4 |q''''| / 384, and half a count of rounding on the way to the drive (not in command_rad).
  const double h = 1e-9 * static_cast<double>(rig.settings.setpoint_period_ns);
  const double tolerance = std::pow(h, 4) * 0.15 * 16 / 384 + 1e-12;
  for (const Feedback& feedback : rig.feedback) {
    const double t = 1e-9 * static_cast<double>(feedback.time_ns - rig.settings.delay_ns);
    ASSERT_NEAR(feedback.command_rad[0], swing(t).position_rad[0], tolerance);
  }
}

TEST(BridgeRun, FeedbackBelongsToItsSync) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.run(swing)) << rig.told();
  rig.feedback.clear();
  rig.run_for(100 * kMs);
  const double count = 1.0 / std::abs(Scale(rig.settings.joints[0]).counts_per_rad());
  for (std::size_t k = 2; k < rig.feedback.size(); ++k) {
    const Feedback& now = rig.feedback[k];
    EXPECT_EQ(now.sync_count, rig.feedback[k - 1].sync_count + 1);
    EXPECT_EQ(now.valid_mask, 0x3F);
    // Sampled at SYNC n: the effect of the command that was active from SYNC n - 1 on.
    EXPECT_NEAR(now.position_rad[0], rig.feedback[k - 1].command_rad[0], 0.5 * count + 1e-12);
    EXPECT_EQ(now.time_ns - rig.feedback[k - 1].time_ns, rig.settings.period_ns);
  }
}

TEST(BridgeRun, StartUpWritesEverythingAndInTheRightOrder) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.configure()) << rig.told();
  for (const FakeDrive& drive : rig.drives) {
    const auto value = [&](Key index, Key sub) { return drive.objects.at(FakeDrive::key(index, sub)); };
    EXPECT_EQ(value(0x1017, 0), 100U);
    EXPECT_EQ(value(0x1016, 1), 0x7F003CU);  // master 7Fh, 60 ms
    EXPECT_EQ(value(0x1029, 1), 0U);
    EXPECT_EQ(value(0x6007, 0), 3U);
    EXPECT_EQ(value(0x605A, 0), 6U);
    EXPECT_EQ(value(0x605E, 0), 2U);
    EXPECT_EQ(value(0x6066, 0), 20U);
    EXPECT_EQ(value(0x60C2, 1), 2U);
    EXPECT_EQ(value(0x60C2, 2), 0xFDU);  // -3: milliseconds
    EXPECT_EQ(value(0x6060, 0), 8U);
    EXPECT_EQ(value(0x1400, 1), 0x200U + drive.node);
    EXPECT_EQ(value(0x1800, 1), 0x4000'0180U + drive.node);
    EXPECT_EQ(value(0x1600, 0), 2U);
    EXPECT_EQ(value(0x1600, 1), 0x6040'0010U);
    EXPECT_EQ(value(0x1600, 2), 0x607A'0020U);
    EXPECT_EQ(value(0x1A00, 0), 3U);
    EXPECT_EQ(value(0x1A00, 3), 0x6077'0010U);
    EXPECT_EQ(value(0x1401, 1), 0x8000'0300U + drive.node);  // unused ones off
    EXPECT_EQ(value(0x1801, 1), 0xC000'0280U + drive.node);  // and no remote frames on those of the drive
    EXPECT_LT(static_cast<std::int32_t>(value(0x607D, 1)), static_cast<std::int32_t>(value(0x607D, 2)));
    for (const Key pdo : {0x1400U, 0x1800U}) {
      EXPECT_LT(place(drive, pdo, 1), place(drive, pdo + 0x200, 0));                // off, then cleared
      EXPECT_LT(place(drive, pdo + 0x200, 0), place(drive, pdo + 0x200, 1));        // cleared, then filled
      EXPECT_LT(place(drive, pdo + 0x200, 2), place(drive, pdo + 0x200, 0, true));  // filled, then counted
      EXPECT_LT(place(drive, pdo + 0x200, 0, true), place(drive, pdo, 2));          // counted, then typed
      EXPECT_LT(place(drive, pdo, 2), place(drive, pdo, 1, true));                  // typed, then on
    }
  }
}

TEST(BridgeRun, SoftwareLimitsAreSwappedForANegativeSign) {
  Rig rig(six_drives(2));
  ASSERT_TRUE(rig.configure()) << rig.told();
  const JointSettings& joint = rig.settings.joints[1];
  ASSERT_LT(joint.sign, 0);
  const auto low = static_cast<std::int32_t>(rig.drives[1].objects.at(FakeDrive::key(0x607D, 1)));
  EXPECT_EQ(low, Scale(joint).counts(joint.upper_rad + joint.measured_margin_rad));
}

TEST(BridgeRun, NothingIsAllocatedAfterConstruction) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.run(swing)) << rig.told();
  rig.drives[2].dead = true;
  rig.run_for(1000 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Fault);
  EXPECT_EQ(rig.allocations, 0);
}

TEST(BridgeRun, EqualInputsGiveEqualFrames) {
  std::vector<Wire> first;
  for (int round = 0; round < 2; ++round) {
    Rig rig(six_drives());
    ASSERT_TRUE(rig.run(swing)) << rig.told();
    if (round == 0) {
      first = rig.wire;
      continue;
    }
    ASSERT_EQ(first.size(), rig.wire.size());
    for (std::size_t k = 0; k < first.size(); ++k) {
      ASSERT_EQ(first[k].time_ns, rig.wire[k].time_ns);
      ASSERT_EQ(first[k].frame, rig.wire[k].frame);
    }
  }
}

TEST(BridgeRun, TwoBusesOfThreeDrivesAtOneKilohertz) {
  Settings settings = six_drives(6, 2);
  settings.period_ns = settings.setpoint_period_ns = 1 * kMs;
  settings.delay_ns = 2 * kMs;
  settings.hold_after_ns = 3 * kMs;
  Rig rig(settings);
  ASSERT_TRUE(rig.run(swing)) << rig.told();
  for (const Wire& entry : rig.wire) {
    const std::uint32_t node = entry.frame.id & 0x7FU;
    if (entry.from_bridge && (entry.frame.id & 0x780U) == 0x200U) {
      ASSERT_EQ(entry.bus, node <= 3 ? 0U : 1U);
    }
  }
}

TEST(BridgeRun, ArmingDoesNotMoveTheDrives) {
  Rig rig(six_drives());
  std::vector<std::int32_t> before;
  for (const FakeDrive& drive : rig.drives) before.push_back(drive.position);
  ASSERT_TRUE(rig.arm()) << rig.told();
  rig.run_for(500 * kMs);
  for (std::size_t j = 0; j < before.size(); ++j) EXPECT_EQ(rig.drives[j].position, before[j]);
}

TEST(BridgeRun, StartIsWithoutAJumpFromTheMeasuredPosition) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.arm()) << rig.told();
  rig.motion = [](double) {
    Sample sample;
    sample.position_rad.fill(0.4);  // 0.1 rad away, within the start window
    return sample;
  };
  rig.cycles(5);
  rig.command(Request::Start);
  rig.feedback.clear();
  rig.run_for(1000 * kMs);
  ASSERT_EQ(rig.bridge.state(), State::Run) << rig.told();
  const double period_s = 1e-9 * static_cast<double>(rig.settings.period_ns);
  for (std::size_t k = 1; k < rig.feedback.size(); ++k) {
    const double step = rig.feedback[k].command_rad[0] - rig.feedback[k - 1].command_rad[0];
    ASSERT_LE(std::abs(step), rig.settings.joints[0].blend_rad_per_s * period_s * (1 + 1e-9));
  }
  EXPECT_NEAR(rig.feedback.back().command_rad[0], 0.4, 1e-12);
}

TEST(BridgeRun, StopBringsToRestAndStaysReady) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.run(swing)) << rig.told();
  rig.command(Request::Stop);
  rig.run_for(200 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Ready) << rig.told();
  const double at = rig.bridge.command_rad()[0];
  rig.run_for(200 * kMs);
  EXPECT_EQ(rig.bridge.command_rad()[0], at);
  EXPECT_NE(rig.bridge.session(), 0);
}

TEST(BridgeRun, DisarmDuringMotionComesToRestFirst) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.run(swing)) << rig.told();
  rig.command(Request::Disarm);
  rig.cycle();
  EXPECT_EQ(rig.bridge.state(), State::Hold);
  EXPECT_EQ(rig.last_rpdo(1).first, 0x0F);
  rig.run_for(300 * kMs);
  EXPECT_EQ(rig.bridge.state(), State::Idle) << rig.told();
  EXPECT_EQ(rig.bridge.session(), 0);
  EXPECT_NE(rig.drives[0].statusword & 0x6F, 0x27);
}

TEST(BridgeRun, ShutdownReleasesTheDrives) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.run(swing)) << rig.told();
  rig.shutdown = true;
  ASSERT_TRUE(rig.run_until([&] { return rig.bridge.released(); }, 2000 * kMs)) << rig.told();
  for (FakeDrive& drive : rig.drives) {
    EXPECT_EQ(drive.objects.at(FakeDrive::key(0x1016, 1)), 0U);
    EXPECT_EQ(drive.nmt, 0x7F);
    EXPECT_NE(drive.statusword & 0x6F, 0x27);
  }
}

TEST(BridgeRun, SetpointsSlowerThanSyncAreInterpolated) {
  Settings settings = six_drives();
  settings.setpoint_period_ns = 10 * kMs;
  settings.delay_ns = 20 * kMs;
  settings.hold_after_ns = 30 * kMs;
  Rig rig(settings);
  ASSERT_TRUE(rig.arm()) << rig.told();
  rig.motion = swing;
  const auto thin = [&] {  // every fifth cycle only
    const auto motion = rig.motion;
    for (int k = 0; k < 5; ++k) {
      if (k > 0) rig.motion = nullptr;
      rig.cycle();
      rig.motion = motion;
    }
  };
  for (int k = 0; k < 6; ++k) thin();
  rig.command(Request::Start);
  for (int k = 0; k < 100; ++k) thin();
  ASSERT_EQ(rig.bridge.state(), State::Run) << rig.told();
  rig.feedback.clear();
  for (int k = 0; k < 50; ++k) thin();
  const double tolerance = std::pow(0.010, 4) * 0.15 * 16 / 384 + 1e-12;
  for (const Feedback& feedback : rig.feedback) {
    const double t = 1e-9 * static_cast<double>(feedback.time_ns - settings.delay_ns);
    ASSERT_NEAR(feedback.command_rad[0], swing(t).position_rad[0], tolerance);
  }
}

}  // namespace
}  // namespace glenoid::bridge::test
