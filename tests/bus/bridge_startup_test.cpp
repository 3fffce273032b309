// Start-up of drives that are late, silent, the wrong ones, or refuse.

#include <gtest/gtest.h>

#include "bridge_motions.hpp"
#include "host/bridge/core/codec.hpp"

namespace glenoid::bridge::test {
namespace {

constexpr std::int32_t kFailed = static_cast<std::int32_t>(Fault::StartUpFailed);

TEST(BridgeStartUp, DriveThatIsSwitchedOnLateIsFound) {
  Rig rig(six_drives());
  rig.drives[2].dead = true;
  rig.run_for(5000 * kMs);
  EXPECT_FALSE(rig.bridge.configured());
  EXPECT_TRUE(rig.has_event(static_cast<std::int32_t>(Notice::DriveSilent)));
  rig.drives[2].dead = false;
  EXPECT_TRUE(rig.configure()) << rig.told();
}

TEST(BridgeStartUp, LostSdoAnswersAreAskedForAgain) {
  Rig rig(six_drives(2));
  rig.cycles(30);
  rig.drives[0].mute_sdo = true;
  rig.run_for(150 * kMs);
  rig.drives[0].mute_sdo = false;
  EXPECT_TRUE(rig.configure()) << rig.told();
  EXPECT_EQ(rig.bridge.fault(), Fault::None) << rig.told();
}

TEST(BridgeStartUp, ServerThatFallsSilentIsAFaultWithWords) {
  Rig rig(six_drives(2));
  rig.cycles(30);
  rig.drives[0].mute_sdo = true;
  rig.run_for(1000 * kMs);
  EXPECT_EQ(rig.bridge.fault(), Fault::StartUpFailed) << rig.told();
  EXPECT_NE(rig.told().find("timed out"), std::string::npos) << rig.told();
}

struct Wrong {
  const char* name;
  std::uint32_t index, sub, value;
};

class WrongDrive : public ::testing::TestWithParam<Wrong> {};

TEST_P(WrongDrive, IsNotConfigured) {
  Settings settings = six_drives(2);
  settings.joints[1].vendor = 1;
  settings.joints[1].product = 2;
  Rig rig(settings);
  rig.drives[1].objects[FakeDrive::key(GetParam().index, GetParam().sub)] = GetParam().value;
  rig.run_for(2000 * kMs);
  EXPECT_FALSE(rig.bridge.configured());
  EXPECT_TRUE(rig.drives[1].writes.empty()) << "a foreign drive must not be written to";
  EXPECT_EQ(rig.bridge.fault(), Fault::StartUpFailed) << rig.told();
  const Event* event = rig.first_event(kFailed);
  ASSERT_NE(event, nullptr);
  EXPECT_EQ(event->node, 2);
  EXPECT_EQ(event->value, GetParam().value);
}

INSTANTIATE_TEST_SUITE_P(Identity, WrongDrive,
                         ::testing::Values(Wrong{"profile", 0x1000, 0, 0x00010191}, Wrong{"vendor", 0x1018, 1, 99},
                                           Wrong{"product", 0x1018, 2, 98}, Wrong{"modes", 0x6502, 0, 0x025}),
                         [](const auto& tested) { return tested.param.name; });

TEST(BridgeStartUp, AbortIsToldInWordsAndResetTriesAgain) {
  Rig rig(six_drives(2));
  rig.drives[0].aborts[FakeDrive::key(0x6007, 0)] = 0x06090030;
  rig.run_for(2000 * kMs);
  EXPECT_EQ(rig.bridge.fault(), Fault::StartUpFailed);
  EXPECT_NE(rig.told().find("6007h"), std::string::npos) << rig.told();
  EXPECT_NE(rig.told().find("value out of range"), std::string::npos) << rig.told();
  rig.drives[0].aborts.clear();
  rig.command(Request::ResetFault);
  EXPECT_TRUE(rig.configure()) << rig.told();
}

TEST(BridgeStartUp, ValueThatDoesNotStickIsAFault) {
  Rig rig(six_drives(2));
  rig.drives[0].read_back[FakeDrive::key(0x1016, 1)] = 0;  // no supervision of the master
  rig.run_for(2000 * kMs);
  EXPECT_EQ(rig.bridge.fault(), Fault::StartUpFailed) << rig.told();
  EXPECT_NE(rig.told().find("1016h"), std::string::npos) << rig.told();
}

TEST(BridgeStartUp, OptionalObjectsMayBeMissing) {
  Rig rig(six_drives(1));
  for (const std::uint32_t sub : {3U, 5U}) rig.drives[0].objects.erase(FakeDrive::key(0x1800, sub));
  rig.drives[0].objects.erase(FakeDrive::key(0x1401, 1));
  EXPECT_TRUE(rig.configure()) << rig.told();
}

TEST(BridgeStartUp, DriveThatCannotWatchTheMasterIsRefused) {
  Rig rig(six_drives(2));
  rig.drives[1].objects.erase(FakeDrive::key(0x1016, 1));
  rig.run_for(2000 * kMs);
  EXPECT_FALSE(rig.bridge.configured());
  EXPECT_EQ(rig.bridge.fault(), Fault::StartUpFailed) << rig.told();
  EXPECT_NE(rig.told().find("1016h"), std::string::npos) << rig.told();
}

TEST(BridgeStartUp, DriveThatCannotWatchTheMasterIsTakenWhereThatIsAcceptedAndTold) {
  Settings settings = six_drives(2);
  settings.joints[1].may_lack_heartbeat_consumer = true;
  Rig rig(settings);
  rig.drives[1].objects.erase(FakeDrive::key(0x1016, 1));
  EXPECT_TRUE(rig.configure()) << rig.told();
  const Event* event = rig.first_event(static_cast<std::int32_t>(Notice::DriveUnwatched));
  ASSERT_NE(event, nullptr);
  EXPECT_EQ(event->node, 2);
  EXPECT_EQ(event->severity, Severity::Warning);
  // Accepted is not wanted: one that has the object is still given it, and one that has it without keeping it is refused.
  Rig able(settings);
  EXPECT_TRUE(able.configure());
  EXPECT_NE(able.drives[1].objects.at(FakeDrive::key(0x1016, 1)), 0U);
  EXPECT_FALSE(able.has_event(static_cast<std::int32_t>(Notice::DriveUnwatched)));
}

TEST(BridgeStartUp, SecondTpdoIsOffUnlessAskedFor) {
  Rig rig(six_drives(1));
  ASSERT_TRUE(rig.configure()) << rig.told();
  EXPECT_NE(rig.drives[0].objects.at(FakeDrive::key(0x1801, 1)) & 0x8000'0000U, 0U);
}

TEST(BridgeStartUp, SecondTpdoIsMappedAndItsErrorCodeIsShown) {
  Settings settings = six_drives(1);
  settings.second_tpdo_every = 10;
  Rig rig(settings);
  ASSERT_TRUE(rig.configure()) << rig.told();
  const auto object = [&](std::uint32_t index, std::uint32_t sub) {
    return rig.drives[0].objects.at(FakeDrive::key(index, sub));
  };
  EXPECT_EQ(object(0x1801, 1) & 0x8000'07FFU, 0x281U);
  EXPECT_EQ(object(0x1801, 2) & 0xFFU, 10U);
  EXPECT_EQ(object(0x1A01, 0) & 0xFFU, 2U);
  EXPECT_EQ(object(0x1A01, 1), 0x606C'0020U);
  EXPECT_EQ(object(0x1A01, 2), 0x603F'0010U);
  rig.error_frame(0, encode(1, Tpdo2{-1234, 0x8611}));
  rig.run_for(150 * kMs);
  EXPECT_EQ(rig.statuses.back().drive[0].error_code, 0x8611);
}

TEST(BridgeStartUp, NmtIsConfirmedByTheHeartbeat) {
  Rig rig(six_drives(1));
  rig.drives[0].mute_heartbeat = true;
  rig.run_for(3000 * kMs);
  EXPECT_FALSE(rig.bridge.configured());
  EXPECT_EQ(rig.bridge.fault(), Fault::StartUpFailed) << rig.told();
}

TEST(BridgeStartUp, ModeIsConfirmed) {
  Rig rig(six_drives(1));
  rig.drives[0].read_back[FakeDrive::key(0x6061, 0)] = 1;
  rig.run_for(3000 * kMs);
  EXPECT_EQ(rig.bridge.fault(), Fault::StartUpFailed) << rig.told();
  EXPECT_NE(rig.told().find("6061h"), std::string::npos) << rig.told();
}

TEST(BridgeStartUp, RebootWhileIdleIsConfiguredAgain) {
  Rig rig(six_drives(2));
  ASSERT_TRUE(rig.configure());
  rig.cycles(10);
  std::vector<can::Frame> boot;
  rig.drives[0].reboot(boot);
  rig.error_frame(0, boot.front());
  rig.cycles(2);
  EXPECT_FALSE(rig.bridge.configured());
  EXPECT_TRUE(rig.configure()) << rig.told();
  EXPECT_EQ(rig.bridge.state(), State::Idle);
}

TEST(BridgeStartUp, NoPowerBeforeArming) {
  Rig rig(six_drives());
  ASSERT_TRUE(rig.configure());
  rig.run_for(500 * kMs);
  for (const Wire& entry : rig.wire)
    if (entry.from_bridge && (entry.frame.id & 0x780U) == 0x200U) {
      ASSERT_EQ(entry.frame.data[0], 0x00);
    }
}

TEST(BridgeStartUp, HeartbeatOfTheMasterIsPeriodicFromTheBeginning) {
  Rig rig(six_drives(1));
  rig.run_for(2000 * kMs);
  std::int64_t last_ns = -1;
  for (const Wire& entry : rig.wire) {
    if (!entry.from_bridge || entry.frame.id != 0x77F) continue;
    EXPECT_EQ(entry.frame.data[0], 0x05);
    if (last_ns >= 0) {
      EXPECT_EQ(entry.time_ns - last_ns, rig.settings.master_heartbeat_ns);
    }
    last_ns = entry.time_ns;
  }
  EXPECT_GT(last_ns, rig.now_ns - 2 * rig.settings.master_heartbeat_ns);
  rig.suppress_heartbeat = true;
  const std::size_t before = rig.wire.size();
  rig.run_for(200 * kMs);
  for (std::size_t k = before; k < rig.wire.size(); ++k) ASSERT_NE(rig.wire[k].frame.id, 0x77FU);
}

TEST(BridgeStartUp, SettingsThatDoNotFitAreRefused) {
  Settings settings = six_drives(1);
  settings.joints.clear();
  EXPECT_THROW(Bridge{settings}, std::invalid_argument);
  settings = six_drives(1);
  settings.joints[0].upper_rad = 1e9;
  EXPECT_THROW(Bridge{settings}, std::invalid_argument);
  settings = six_drives(1);
  settings.period_ns = 1'234'567;
  EXPECT_THROW(Bridge{settings}, std::invalid_argument);
}

}  // namespace
}  // namespace glenoid::bridge::test
