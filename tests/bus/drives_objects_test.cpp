// Objects of the communication profile with rules of their own: identifiers, consumers, error history, stored parameters.

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "bus/drives_bench.hpp"

namespace glenoid::test {
namespace {

constexpr std::uint32_t kRange = 0x06090030, kIncompatible = 0x06040043, kTooMany = 0x06040042, kNoData = 0x08000024,
                        kState = 0x08000022, kNotStored = 0x08000020;
constexpr std::int64_t kSave = 0x65766173, kLoad = 0x64616F6C;  // "save", "load"

class DriveObjects : public testing::Test {
 protected:
  DriveObjects() { bench.wait(25 * kMs); }
  void reboot() {
    bench.give(0x000, {0x81, 1});
    bench.wait(25 * kMs);
  }
  DriveBench bench;
};

TEST_F(DriveObjects, IdentifiersOfSyncAndEmergencyKeepToElevenBits) {
  EXPECT_EQ(bench.download(0x1005, 0, 0x20000080, 4), kRange);  // 29 bits
  EXPECT_EQ(bench.download(0x1005, 0, 0x40000080, 4), kRange);  // a producer
  EXPECT_EQ(bench.download(0x1014, 0, 0x20000081, 4), kRange);
  EXPECT_EQ(bench.download(0x1014, 0, 0x00000601, 4), kRange);  // that of an SDO
  EXPECT_EQ(bench.download(0x1014, 0, 0x00000085, 4), kRange);  // another one while it is in use
  EXPECT_EQ(bench.download(0x1014, 0, 0x80000081, 4), 0U);
  EXPECT_EQ(bench.download(0x1014, 0, 0x00000085, 4), 0U);
  bench.take();
  bench.download(0x2F00, 1, 4, 1);
  bench.wait(1 * kMs);
  EXPECT_EQ(bench.take(0x085).size(), 1U);
}

TEST_F(DriveObjects, NoTpdoAnswersRemoteFrames) {
  EXPECT_EQ(bench.upload(0x1800, 1).value, 0x40000181);
  EXPECT_EQ(bench.download(0x1800, 1, 0x00000181, 4), kRange);
  EXPECT_EQ(bench.download(0x1800, 1, 0xC0000181, 4), 0U);
  EXPECT_EQ(bench.download(0x1800, 1, 0x40000181, 4), 0U);
  EXPECT_EQ(bench.upload(0x1400, 1).value, 0x00000201);
}

TEST_F(DriveObjects, AMappingHasNoMoreEntriesThanThereIsRoom) {
  ASSERT_EQ(bench.download(0x1600, 0, 0, 1), kState);
  ASSERT_EQ(bench.download(0x1400, 1, 0x80000201, 4), 0U);
  EXPECT_EQ(bench.download(0x1600, 0, 9, 1), kTooMany);
}

TEST_F(DriveObjects, OneConsumerWatchesANode) {
  ASSERT_EQ(bench.download(0x1016, 1, 0x7F << 16 | 60, 4), 0U);
  EXPECT_EQ(bench.download(0x1016, 2, 0x7F << 16 | 80, 4), kIncompatible);
  EXPECT_EQ(bench.download(0x1016, 2, 0x7F << 16, 4), 0U);  // time 0: not in use
  EXPECT_EQ(bench.download(0x1016, 2, 0x7E << 16 | 80, 4), 0U);
  EXPECT_EQ(bench.download(0x1016, 1, 0x7F << 16 | 70, 4), 0U);  // itself
  EXPECT_EQ(bench.download(0x1016, 2, 0x80 << 16 | 80, 4), kRange);
}

TEST_F(DriveObjects, AHeartbeatHasOneByte) {
  ASSERT_EQ(bench.download(0x1016, 1, 0x7F << 16 | 60, 4), 0U);
  bench.give(0x77F, {});
  bench.give(0x77F, {5, 0});
  bench.take();
  bench.wait(100 * kMs);
  EXPECT_TRUE(bench.take(0x081).empty());  // a heartbeat never heard is not missed
}

TEST_F(DriveObjects, HistoryHasNoEntryBeyondItsCount) {
  EXPECT_EQ(bench.upload(0x1003, 0).value, 0);
  EXPECT_EQ(bench.upload(0x1003, 1).abort, kNoData);
  bench.download(0x2F00, 1, 4, 1);
  bench.wait(1 * kMs);
  EXPECT_EQ(bench.upload(0x1003, 0).value, 1);
  EXPECT_EQ(bench.upload(0x1003, 1).value, 0x2310);
  EXPECT_EQ(bench.upload(0x1003, 2).abort, kNoData);
}

TEST_F(DriveObjects, StoredParametersOutliveAReboot) {
  ASSERT_EQ(bench.download(0x1017, 0, 50, 2), 0U);
  ASSERT_EQ(bench.download(0x6065, 0, 77, 4), 0U);
  ASSERT_EQ(bench.download(0x6040, 0, 6, 2), 0U);
  EXPECT_EQ(bench.upload(0x1010, 1).value, 1);
  EXPECT_EQ(bench.download(0x1010, 1, 1, 4), kNotStored);
  EXPECT_EQ(bench.download(0x1010, 1, kSave, 4), 0U);
  ASSERT_EQ(bench.download(0x6065, 0, 78, 4), 0U);
  reboot();
  EXPECT_EQ(bench.upload(0x1017).value, 50);
  EXPECT_EQ(bench.upload(0x6065).value, 77);
  EXPECT_EQ(bench.upload(0x6040).value, 0);  // an order is no parameter
  EXPECT_EQ(bench.state(), 0x40U);
  bench.take();
  bench.wait(50 * kMs);
  EXPECT_FALSE(bench.take(0x701).empty());  // it is heard without having been configured
  EXPECT_EQ(bench.download(0x1011, 1, kLoad, 4), 0U);
  EXPECT_EQ(bench.upload(0x1017).value, 50);  // until it boots
  reboot();
  EXPECT_EQ(bench.upload(0x1017).value, 0);
  EXPECT_NE(bench.upload(0x6065).value, 77);
}

TEST_F(DriveObjects, NothingIsStoredUnderPower) {
  bench.prepare();
  bench.enable();
  EXPECT_EQ(bench.download(0x1010, 1, kSave, 4), kState);
}

TEST_F(DriveObjects, AFaultStaysInTheErrorRegisterWhenCommunicationIsReset) {
  bench.download(0x2F00, 1, 4, 1);
  bench.wait(1 * kMs);
  ASSERT_EQ(bench.upload(0x1001).value, 0x03);
  bench.give(0x000, {0x82, 1});
  bench.wait(1 * kMs);
  EXPECT_EQ(bench.upload(0x1001).value, 0x03);
  EXPECT_EQ(bench.state() & 0x4F, 0x08U);
}

struct ErrorClass {
  std::uint32_t code;
  std::int64_t error_register;
};
class DriveErrorRegister : public testing::TestWithParam<ErrorClass> {};
INSTANTIATE_TEST_SUITE_P(Codes, DriveErrorRegister,
                         testing::Values(ErrorClass{0x1000, 0x01}, ErrorClass{0x2310, 0x03}, ErrorClass{0x3210, 0x05},
                                         ErrorClass{0x4210, 0x09}, ErrorClass{0x7320, 0x21}, ErrorClass{0x8130, 0x11},
                                         ErrorClass{0x8611, 0x21}, ErrorClass{0xFF01, 0x81}));

TEST_P(DriveErrorRegister, NamesTheKindOfError) {
  DriveBench bench;
  bench.wait(25 * kMs);
  bench.download(0x2F00, 2, GetParam().code, 4);
  bench.download(0x2F00, 1, 4, 1);
  bench.wait(1 * kMs);
  const auto told = bench.take(0x081);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].data[2], GetParam().error_register);
  EXPECT_EQ(bench.upload(0x1001).value, GetParam().error_register);
}

TEST_F(DriveObjects, OnePdoIsConfiguredWithoutDisturbingTheOthers) {
  ASSERT_TRUE(bench.map(0x1800, 0x181, 3, {0x60640020}));  // every third SYNC
  bench.give(0x000, {0x01, 0});
  bench.take();
  bench.sync();
  bench.sync();
  ASSERT_EQ(bench.download(0x1801, 5, 100, 2), 0U);  // another one's event timer
  EXPECT_TRUE(bench.take(0x181).empty());
  bench.sync();
  EXPECT_EQ(bench.take(0x181).size(), 1U);
}

TEST_F(DriveObjects, AModeThatThereIsNotIsNotDisplayed) {
  ASSERT_TRUE(bench.map(0x1400, 0x201, 1, {0x60400010, 0x60600008}));
  ASSERT_EQ(bench.download(0x6060, 0, 8, 1), 0U);
  bench.give(0x000, {0x01, 0});
  bench.give(0x201, {0x06, 0x00, 3});  // profile velocity, by PDO
  bench.sync();
  EXPECT_EQ(bench.upload(0x6061).value, 8);
}

TEST(DriveProfile, DefaultsKeepToTheRangeOfTheirObject) {
  drives::Profile profile;
  profile.objects = {{{0x6007, 0}, 9}};
  EXPECT_THROW(drives::Drive(profile, {}), std::invalid_argument);
  profile.objects = {{{0x6007, 0}, 3}};
  EXPECT_EQ(DriveBench(profile).drive.node(), 1);
}

}  // namespace
}  // namespace glenoid::test
