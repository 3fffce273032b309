// CiA 301 side of the simulated drive: SDO, PDO mapping, SYNC, NMT, heartbeat, EMCY.

#include <gtest/gtest.h>

#include <string>

#include "bus/drives_bench.hpp"
#include "support/allocation_guard.hpp"

namespace glenoid::test {
namespace {

constexpr std::uint32_t kNoObject = 0x06020000, kNoSub = 0x06090011, kReadOnly = 0x06010002, kTooLong = 0x06070012,
                        kTooShort = 0x06070013, kRange = 0x06090030, kNotMappable = 0x06040041,
                        kPdoTooLong = 0x06040042, kState = 0x08000022, kSubZeroFirst = 0x06010003, kToggle = 0x05030000,
                        kCommand = 0x05040001;

TEST(DriveBoot, SendsBootUpOnceThenIsPreOperational) {
  DriveBench bench;
  EXPECT_TRUE(bench.take().empty());
  bench.wait(100 * kMs);
  const auto frames = bench.take(0x701);
  ASSERT_EQ(frames.size(), 1U);  // 1017h is 0: no heartbeat after it
  EXPECT_EQ(frames[0].size, 1);
  EXPECT_EQ(frames[0].data[0], 0x00);
  EXPECT_EQ(bench.drive.view().nmt, drives::Nmt::PreOperational);
}

TEST(DriveSdo, RefusesWithTheCodeThatNamesTheReason) {
  DriveBench bench;
  bench.wait(25 * kMs);
  EXPECT_EQ(bench.upload(0x5FFF).abort, kNoObject);
  EXPECT_EQ(bench.upload(0x1018, 9).abort, kNoSub);
  EXPECT_EQ(bench.download(0x6041, 0, 0, 2), kReadOnly);
  EXPECT_EQ(bench.download(0x6040, 0, 0, 4), kTooLong);
  EXPECT_EQ(bench.download(0x607A, 0, 0, 2), kTooShort);
  EXPECT_EQ(bench.download(0x6060, 0, 9, 1), kRange);
  EXPECT_EQ(bench.download(0x6007, 0, 4, 2), kRange);
  EXPECT_EQ(bench.download(0x605A, 0, 4, 2), kRange);
}

TEST(DriveSdo, WhatIsWrittenIsRead) {
  DriveBench bench;
  bench.wait(25 * kMs);
  for (const std::int64_t value : {0LL, 1LL, -1LL, 2147483647LL, -2147483648LL, 0x12345678LL}) {
    ASSERT_EQ(bench.download(0x607A, 0, value, 4), 0U);
    EXPECT_EQ(bench.upload(0x607A).value, value & 0xFFFFFFFF);
  }
  EXPECT_EQ(bench.upload(0x1000).value & 0xFFFF, 0x0192);  // CiA 402
  EXPECT_NE(bench.upload(0x6502).value & 0x80, 0);         // csp
}

TEST(DriveSdo, SegmentsCarryTextBothWays) {
  DriveBench bench;
  bench.wait(25 * kMs);
  const std::string text = "left elbow";  // 10 characters: segments of 7 and 3
  bench.give(0x601, {0x21, 0x20, 0x2F, 0, 10, 0, 0, 0});
  bench.give(0x601, {0x00, 'l', 'e', 'f', 't', ' ', 'e', 'l'});
  bench.give(0x601, {0x19, 'b', 'o', 'w', 0, 0, 0, 0});
  auto answers = bench.take(0x581);
  ASSERT_EQ(answers.size(), 3U);
  EXPECT_EQ(answers[0].data[0], 0x60);
  EXPECT_EQ(answers[1].data[0], 0x20);
  EXPECT_EQ(answers[2].data[0], 0x30);
  bench.give(0x601, {0x40, 0x20, 0x2F, 0, 0, 0, 0, 0});
  bench.give(0x601, {0x60, 0, 0, 0, 0, 0, 0, 0});
  bench.give(0x601, {0x70, 0, 0, 0, 0, 0, 0, 0});
  answers = bench.take(0x581);
  ASSERT_EQ(answers.size(), 3U);
  EXPECT_EQ(answers[0].data[0], 0x41);
  EXPECT_EQ(answers[0].data[4], text.size());
  std::string read;
  for (std::size_t k = 1; k < 8; ++k) read += static_cast<char>(answers[1].data[k]);
  for (std::size_t k = 1; k < 4; ++k) read += static_cast<char>(answers[2].data[k]);
  EXPECT_EQ(read, text);
  EXPECT_EQ(answers[2].data[0], 0x10 | 4 << 1 | 1);
}

TEST(DriveSdo, RepeatedToggleAndForeignCommandsAbort) {
  DriveBench bench;
  bench.wait(25 * kMs);
  bench.give(0x601, {0x40, 0x08, 0x10, 0, 0, 0, 0, 0});
  bench.give(0x601, {0x70, 0, 0, 0, 0, 0, 0, 0});  // the first segment has toggle 0
  const auto code = [&] {
    const auto frames = bench.take(0x581);
    const can::Frame& last = frames.back();
    EXPECT_EQ(last.data[0], 0x80);
    return std::uint32_t{last.data[4]} | std::uint32_t{last.data[5]} << 8U | std::uint32_t{last.data[6]} << 16U |
           std::uint32_t{last.data[7]} << 24U;
  };
  EXPECT_EQ(code(), kToggle);
  bench.give(0x601, {0xA0, 0x08, 0x10, 0, 0, 0, 0, 0});  // block upload
  EXPECT_EQ(code(), kCommand);
  bench.give(0x601, {0x60, 0, 0, 0, 0, 0, 0, 0});  // a segment without a beginning
  EXPECT_EQ(code(), kCommand);
}

TEST(DriveMapping, FollowsTheOrderOfRemapping) {
  DriveBench bench;
  bench.wait(25 * kMs);
  EXPECT_EQ(bench.download(0x1600, 0, 0, 1), kState);  // valid PDO
  EXPECT_EQ(bench.download(0x1400, 1, 0x80000201, 4), 0U);
  EXPECT_EQ(bench.download(0x1600, 1, 0x60400010, 4), kSubZeroFirst);
  EXPECT_EQ(bench.download(0x1600, 0, 0, 1), 0U);
  EXPECT_EQ(bench.download(0x1600, 1, 0x60410010, 4), kNotMappable);  // statusword is not received
  EXPECT_EQ(bench.download(0x1600, 1, 0x60650020, 4), kNotMappable);
  EXPECT_EQ(bench.download(0x1600, 1, 0x60400008, 4), kNotMappable);  // wrong length
  EXPECT_EQ(bench.download(0x1600, 1, 0x5FFF0010, 4), kNoObject);
  for (std::uint8_t k = 1; k <= 3; ++k) EXPECT_EQ(bench.download(0x1600, k, 0x607A0020, 4), 0U);
  EXPECT_EQ(bench.download(0x1600, 0, 3, 1), kPdoTooLong);  // 12 bytes
  EXPECT_EQ(bench.download(0x1600, 0, 2, 1), 0U);
  EXPECT_EQ(bench.download(0x1400, 2, 241, 1), kRange);
  EXPECT_EQ(bench.download(0x1400, 1, 0x00000181 - 1, 4), kRange);  // 180h is not for PDOs
  EXPECT_EQ(bench.download(0x1400, 1, 0x00000201, 4), 0U);
  EXPECT_EQ(bench.download(0x1400, 1, 0x00000202, 4), kRange);  // not while it is valid
}

TEST(DriveMapping, IsRefusedWhileOperational) {
  DriveBench bench;
  bench.prepare();
  EXPECT_EQ(bench.download(0x1400, 1, 0x80000201, 4), kState);
}

TEST(DriveMapping, DummiesFillGapsWhereTheFamilyHasThem) {
  drives::Profile without;
  without.dummy_mapping = false;
  DriveBench with_dummies, without_dummies(without);
  for (DriveBench* bench : {&with_dummies, &without_dummies}) bench->wait(25 * kMs);
  EXPECT_TRUE(with_dummies.map(0x1400, 0x201, 255, {0x00040020, 0x607A0020}));
  EXPECT_FALSE(without_dummies.map(0x1400, 0x201, 255, {0x00040020, 0x607A0020}));
  with_dummies.give(0x000, {0x01, 0});
  with_dummies.give(0x201, {1, 2, 3, 4, 0x44, 0x33, 0x22, 0x11});
  EXPECT_EQ(with_dummies.upload(0x607A).value, 0x11223344);
}

TEST(DriveSync, SetpointBecomesActiveAtTheNextSyncAndFeedbackIsSampledBeforeIt) {
  DriveBench bench;
  bench.prepare();
  bench.setpoint(0x06, 1234);
  EXPECT_EQ(bench.upload(0x607A).value, 0);
  EXPECT_EQ(bench.state(), 0x40U);
  bench.sync();
  EXPECT_EQ(bench.upload(0x607A).value, 1234);
  EXPECT_EQ(bench.state(), 0x21U);
  EXPECT_EQ(bench.feedback()->statusword & 0x6F, 0x40U);  // of the time before
  bench.wait(2 * kMs);
  bench.sync();
  EXPECT_EQ(bench.feedback()->statusword & 0x6F, 0x21U);
}

TEST(DriveSync, LatestSetpointBeforeSyncWins) {
  DriveBench bench;
  bench.prepare();
  for (const int target : {10, 20, 30}) bench.setpoint(0x06, target);
  bench.sync();
  EXPECT_EQ(bench.upload(0x607A).value, 30);
  EXPECT_EQ(bench.drive.counters().setpoints, 1U);
}

class EveryNthSync : public testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Types, EveryNthSync, testing::Values(1U, 2U, 3U, 240U));

TEST_P(EveryNthSync, IsAnsweredOnce) {
  const unsigned type = GetParam();
  DriveBench bench;
  bench.wait(25 * kMs);
  ASSERT_TRUE(bench.map(0x1800, 0x181, type, {0x60640020}));
  bench.give(0x000, {0x01, 0});
  bench.take();
  for (unsigned k = 1; k <= 3 * type; ++k) {
    bench.sync();
    EXPECT_EQ(bench.take(0x181).size(), k % type == 0 ? 1U : 0U) << k;
    bench.wait(1 * kMs);
  }
}

TEST(DriveSync, CounterAndStartValueChooseTheFirst) {
  DriveBench bench;
  bench.wait(25 * kMs);
  ASSERT_EQ(bench.download(0x1019, 0, 4, 1), 0U);
  ASSERT_EQ(bench.download(0x1800, 1, 0x80000181, 4), 0U);
  ASSERT_EQ(bench.download(0x1800, 6, 3, 1), 0U);
  ASSERT_TRUE(bench.map(0x1800, 0x181, 2, {0x60640020}));
  bench.give(0x000, {0x01, 0});
  bench.take();
  std::string answered;
  for (unsigned k = 0; k < 8; ++k) {
    bench.give(0x080, {k % 4 + 1});
    answered += bench.take(0x181).empty() ? '-' : 'x';
  }
  EXPECT_EQ(answered, "--x-x-x-");
  bench.sync();  // without a counter
  EXPECT_EQ(bench.take(0x081).at(0).data[1], 0x82);
}

TEST(DrivePdo, EventDrivenIsSentOnChangeAndNoCloserThanTheInhibitTime) {
  DriveBench bench;
  bench.wait(25 * kMs);
  ASSERT_EQ(bench.download(0x1800, 1, 0x80000181, 4), 0U);
  ASSERT_EQ(bench.download(0x1800, 3, 300, 2), 0U);  // 30 ms
  ASSERT_TRUE(bench.map(0x1800, 0x181, 255, {0x60410010}));
  bench.give(0x000, {0x01, 0});
  EXPECT_EQ(bench.take(0x181).size(), 1U);  // the first after the start
  bench.give(0x201, {0x06, 0x00});
  bench.wait(29 * kMs);
  EXPECT_TRUE(bench.take(0x181).empty());
  bench.wait(2 * kMs);
  EXPECT_EQ(bench.take(0x181).size(), 1U);
  bench.wait(200 * kMs);
  EXPECT_TRUE(bench.take(0x181).empty());  // nothing changes
}

TEST(DrivePdo, WrongLengthIsReportedAndShortOnesAreNotTaken) {
  DriveBench bench;
  bench.prepare();
  bench.take();
  bench.give(0x201, {0x06, 0, 1, 2, 3});
  bench.sync();
  EXPECT_EQ(bench.upload(0x607A).value, 0);
  const auto first = bench.take(0x081);
  ASSERT_EQ(first.size(), 2U);  // reported, and over at the SYNC
  EXPECT_EQ(first[0].data[0] | first[0].data[1] << 8, 0x8210);
  EXPECT_EQ(first[1].data[0] | first[1].data[1] << 8, 0);
  bench.give(0x201, {0x06, 0, 1, 0, 0, 0, 9, 9});
  const auto second = bench.take(0x081);
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0].data[0] | second[0].data[1] << 8, 0x8220);
  bench.sync();
  EXPECT_EQ(bench.upload(0x607A).value, 1);
  EXPECT_EQ(bench.drive.counters().bad_pdos, 2U);
}

TEST(DriveNmt, PdosRunOnlyInOperationalAndSdoEndsInStopped) {
  DriveBench bench;
  bench.prepare();
  bench.give(0x000, {0x80, 1});
  bench.take();
  bench.sync();
  EXPECT_TRUE(bench.take(0x181).empty());
  EXPECT_EQ(bench.upload(0x1000).abort, 0U);
  bench.give(0x000, {0x02, 1});
  EXPECT_EQ(bench.upload(0x1000).abort, 0xFFFFFFFFU);  // no answer at all
  bench.give(0x000, {0x01, 2});                        // somebody else
  EXPECT_EQ(bench.drive.view().nmt, drives::Nmt::Stopped);
  bench.give(0x000, {0x01, 1});
  EXPECT_EQ(bench.drive.view().nmt, drives::Nmt::Operational);
}

TEST(DriveNmt, ResetOfCommunicationKeepsTheDriveProfileAndResetOfTheNodeDoesNot) {
  DriveBench bench;
  bench.prepare();
  ASSERT_EQ(bench.download(0x1017, 0, 100, 2), 0U);
  ASSERT_EQ(bench.download(0x6065, 0, 77, 4), 0U);
  bench.give(0x000, {0x82, 1});
  bench.wait(1 * kMs);
  EXPECT_EQ(bench.take(0x701).at(0).data[0], 0);
  EXPECT_EQ(bench.upload(0x1017).value, 0);
  EXPECT_EQ(bench.upload(0x6065).value, 77);
  bench.give(0x000, {0x81, 1});
  EXPECT_EQ(bench.upload(0x6065).abort, 0xFFFFFFFFU);  // boots
  bench.wait(25 * kMs);
  EXPECT_EQ(bench.take(0x701).at(0).data[0], 0);
  EXPECT_NE(bench.upload(0x6065).value, 77);
  EXPECT_EQ(bench.drive.counters().reboots, 1U);
}

TEST(DriveHeartbeat, ComesOnAGridAndTellsTheState) {
  DriveBench bench;
  bench.wait(25 * kMs);
  ASSERT_EQ(bench.download(0x1017, 0, 50, 2), 0U);
  bench.take();
  bench.wait(1000 * kMs);
  EXPECT_EQ(bench.take(0x701).size(), 20U);
  bench.give(0x000, {0x01, 0});
  bench.wait(50 * kMs);
  EXPECT_EQ(bench.take(0x701).back().data[0], 0x05);
}

class ConnectionLoss : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Option6007h, ConnectionLoss, testing::Values(0, 1, 2, 3));

TEST_P(ConnectionLoss, OfTheMasterHeartbeatActsAsConfigured) {
  const int option = GetParam();
  DriveBench bench;
  bench.prepare();
  bench.enable();
  ASSERT_EQ(bench.state(), 0x27U);
  ASSERT_EQ(bench.download(0x6007, 0, option, 2), 0U);
  ASSERT_EQ(bench.download(0x1029, 1, 0, 1), 0U);
  ASSERT_EQ(bench.download(0x1016, 1, 0x7F << 16 | 60, 4), 0U);
  bench.wait(500 * kMs);
  EXPECT_EQ(bench.state(), 0x27U);  // a heartbeat never heard is not missed
  bench.give(0x77F, {0x05});
  bench.wait(60 * kMs);
  EXPECT_EQ(bench.state(), 0x27U);
  bench.take();
  bench.wait(1 * kMs);
  const auto emergencies = bench.take(0x081);
  ASSERT_EQ(emergencies.size(), 1U);
  EXPECT_EQ(emergencies[0].data[0] | emergencies[0].data[1] << 8, 0x8130);
  EXPECT_EQ(bench.drive.view().nmt, drives::Nmt::PreOperational);
  bench.wait(100 * kMs);  // the ramp of a joint at rest ends at once
  const unsigned expected[] = {0x27, 0x08, 0x40, 0x40};
  EXPECT_EQ(bench.state() & (option == 1 ? 0x4FU : 0x6FU), expected[option]);
}

TEST(DriveEmergency, HistoryIsNewestFirstAndCanBeCleared) {
  DriveBench bench;
  bench.wait(25 * kMs);
  for (const std::uint32_t code : {0x3210U, 0x4210U}) {
    bench.download(0x2F00, 2, code, 4);
    bench.download(0x2F00, 1, 4, 1);
    bench.give(0x601, {0x2B, 0x40, 0x60, 0, 0x00, 0, 0, 0});
    bench.give(0x601, {0x2B, 0x40, 0x60, 0, 0x80, 0, 0, 0});
    bench.wait(1 * kMs);
  }
  EXPECT_EQ(bench.upload(0x1003, 0).value, 2);
  EXPECT_EQ(bench.upload(0x1003, 1).value, 0x4210);
  EXPECT_EQ(bench.upload(0x1003, 2).value, 0x3210);
  EXPECT_EQ(bench.upload(0x1001).value, 0);
  EXPECT_EQ(bench.download(0x1003, 0, 1, 1), kRange);
  EXPECT_EQ(bench.download(0x1003, 0, 0, 1), 0U);
  EXPECT_EQ(bench.upload(0x1003, 1).abort, 0x08000024U);
}

TEST(Drive, CyclicPathDoesNotAllocate) {
  DriveBench bench;
  bench.prepare();
  bench.enable();
  drives::Outbox out;
  can::Frame sync, setpoint;
  sync.id = 0x80;
  setpoint.id = 0x201;
  setpoint.size = 6;
  setpoint.data[0] = 0x0F;
  const AllocationGuard guard;
  for (int k = 0; k < 100; ++k) {
    bench.drive.receive(sync, bench.now_ns, out);
    bench.drive.receive(setpoint, bench.now_ns, out);
    bench.now_ns += 2 * kMs;
    bench.drive.advance(bench.now_ns, out);
    out.clear();
  }
  EXPECT_EQ(guard.allocations(), 0);
}

}  // namespace
}  // namespace glenoid::test
