// Frames byte by byte, and laws of the codec.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bridge_rig.hpp"
#include "host/bridge/core/canopen.hpp"
#include "host/bridge/core/cia402.hpp"
#include "host/bridge/core/codec.hpp"
#include "host/bridge/core/sdo_client.hpp"
#include "support/environment.hpp"
#include "support/random.hpp"

namespace glenoid::bridge::test {
namespace {

can::Frame golden(std::uint32_t id, std::initializer_list<std::uint8_t> bytes) {
  can::Frame frame;
  frame.id = id;
  frame.size = static_cast<std::uint8_t>(bytes.size());
  std::size_t k = 0;
  for (const std::uint8_t byte : bytes) frame.data[k++] = byte;
  return frame;
}

TEST(BridgeFrames, NmtStartOfNode3) {
  EXPECT_EQ(canopen::nmt(canopen::NmtCommand::Start, 3), golden(0x000, {0x01,     // start remote node
                                                                        0x03}));  // node id
}

TEST(BridgeFrames, NmtPreOperationalOfAll) {
  EXPECT_EQ(canopen::nmt(canopen::NmtCommand::PreOperational, 0), golden(0x000, {0x80,     // enter pre-operational
                                                                                 0x00}));  // every node
}

TEST(BridgeFrames, SyncHasNoCounter) { EXPECT_EQ(canopen::sync(), golden(0x080, {})); }

TEST(BridgeFrames, HeartbeatOfTheMaster) {
  EXPECT_EQ(canopen::heartbeat(0x7F, Nmt::Operational), golden(0x77F, {0x05}));  // operational
}

TEST(BridgeFrames, SdoDownloadOfOneTwoAndFourBytes) {
  EXPECT_EQ(canopen::sdo_download(1, 0x6060, 0, 1, 8), golden(0x601, {0x2F,                // expedited, 3 bytes unused
                                                                      0x60, 0x60, 0x00,    // 6060h:00
                                                                      0x08, 0, 0, 0}));    // cyclic position
  EXPECT_EQ(canopen::sdo_download(2, 0x1017, 0, 2, 100), golden(0x602, {0x2B,              // 2 bytes unused
                                                                        0x17, 0x10, 0x00,  // 1017h:00
                                                                        0x64, 0x00, 0, 0}));    // 100 ms
  EXPECT_EQ(canopen::sdo_download(6, 0x1016, 1, 4, 0x7F003C), golden(0x606, {0x23,              // all 4 used
                                                                             0x16, 0x10, 0x01,  // 1016h:01
                                                                             0x3C, 0x00,        // 60 ms
                                                                             0x7F, 0x00}));     // of node 7Fh
}

TEST(BridgeFrames, NegativeOneByteValueDoesNotSpill) {
  EXPECT_EQ(canopen::sdo_download(1, 0x60C2, 2, 1, static_cast<std::uint32_t>(-3)),
            golden(0x601, {0x2F, 0xC2, 0x60, 0x02, 0xFD, 0, 0, 0}));  // -3, the three unused bytes zero
}

TEST(BridgeFrames, SdoUpload) {
  EXPECT_EQ(canopen::sdo_upload(1, 0x1000, 0), golden(0x601, {0x40,              // initiate upload
                                                              0x00, 0x10, 0x00,  // 1000h:00
                                                              0, 0, 0, 0}));
}

TEST(BridgeFrames, Rpdo1) {
  EXPECT_EQ(encode(1, Rpdo1{0x000F, 10000}), golden(0x201, {0x0F, 0x00,                 // enable operation
                                                            0x10, 0x27, 0x00, 0x00}));  // 10000 counts
  EXPECT_EQ(encode(6, Rpdo1{0x0002, -2}), golden(0x206, {0x02, 0x00,                    // quick stop
                                                         0xFE, 0xFF, 0xFF, 0xFF}));     // -2 counts
}

TEST(BridgeFrames, Tpdo1) {
  const auto value = decode_tpdo1(golden(0x181, {0x37, 0x12,              // operation enabled, follows its target
                                                 0xF0, 0xD8, 0xFF, 0xFF,  // -10000 counts
                                                 0xF6, 0xFF}));           // -10 per mille of rated torque
  EXPECT_EQ(value, (Tpdo1{0x1237, -10000, -10}));
}

TEST(BridgeFrames, AnswersOfASdoServer) {
  const auto read = canopen::sdo_answer(golden(0x581, {0x4F, 0x61, 0x60, 0x00, 0x08, 0xAA, 0xBB, 0xCC}));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->kind, canopen::SdoAnswer::Kind::Uploaded);
  EXPECT_EQ(read->value, 8U);  // one byte counts, the others are anything
  const auto aborted = canopen::sdo_answer(golden(0x581, {0x80, 0x16, 0x10, 0x01, 0x00, 0x00, 0x02, 0x06}));
  ASSERT_TRUE(aborted);
  EXPECT_EQ(canopen::abort_words(aborted->value), "object does not exist");
  EXPECT_FALSE(canopen::sdo_answer(golden(0x581, {0x60, 0x17, 0x10})));  // too short
}

TEST(BridgeCodec, DecodingUndoesEncoding) {
  glenoid::test::Random random(41);
  for (int k = glenoid::test::test_count(20000); k > 0; --k) {
    const auto word = static_cast<std::uint16_t>(random.uniform(0, 65536));
    const auto position = static_cast<std::int32_t>(random.uniform(-2147483648.0, 2147483648.0));
    const auto torque = static_cast<std::int16_t>(random.uniform(-32768, 32768));
    const Rpdo1 rpdo{word, position};
    const Tpdo1 tpdo{word, position, torque};
    ASSERT_EQ(decode_rpdo1(encode(1, rpdo)), rpdo);
    ASSERT_EQ(decode_tpdo1(encode(1, tpdo)), tpdo);
  }
}

TEST(BridgeCodec, OtherLengthsAndKindsAreNoProcessData) {
  for (std::uint8_t size = 0; size <= 8; ++size) {
    can::Frame frame = encode(1, Tpdo1{});
    frame.size = size;
    EXPECT_EQ(decode_tpdo1(frame).has_value(), size == 8);
    EXPECT_EQ(decode_rpdo1(frame).has_value(), size == 6);
  }
  for (bool can::Frame::*flag : {&can::Frame::extended, &can::Frame::remote, &can::Frame::error}) {
    can::Frame frame = encode(1, Tpdo1{});
    frame.*flag = true;
    EXPECT_FALSE(decode_tpdo1(frame));
  }
}

TEST(BridgeScale, CountsAndBackIsWithinHalfACount) {
  glenoid::test::Random random(42);
  for (int k = glenoid::test::test_count(20000); k > 0; --k) {
    JointSettings joint;
    joint.gear_ratio = random.log_uniform(1, 300);
    joint.encoder_counts_per_turn = std::floor(random.log_uniform(100, 1e6));
    joint.sign = random.uniform(-1, 1) < 0 ? -1 : 1;
    joint.offset_rad = random.uniform(-3, 3);
    const Scale scale(joint);
    const double q = random.uniform(-3, 3);
    const auto counts = scale.counts(q);
    ASSERT_TRUE(counts);
    // Half a count of rounding and the rounding errors of doubles at 3 rad.
    ASSERT_NEAR(scale.position_rad(*counts), q, 0.5 / std::abs(scale.counts_per_rad()) + 1e-15 * 8);
    ASSERT_EQ(scale.counts(scale.position_rad(*counts)), counts);
  }
}

TEST(BridgeScale, WhatDoesNotFitIsNotCommanded) {
  JointSettings joint;
  joint.gear_ratio = 100;
  joint.encoder_counts_per_turn = 1 << 20;
  const Scale scale(joint);
  const double most = 2147483647.0 / scale.counts_per_rad();
  EXPECT_TRUE(scale.counts(most));
  EXPECT_FALSE(scale.counts(most * (1 + 1e-8)));
  EXPECT_FALSE(scale.counts(-most * (1 + 1e-8)));
  EXPECT_FALSE(scale.counts(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(scale.counts(std::numeric_limits<double>::infinity()));
}

TEST(BridgeCia402, EveryStatuswordIsAtMostOneState) {
  // The table of the standard, bit patterns written out.
  const auto matches = [](std::uint32_t word, std::uint32_t mask, std::uint32_t value) {
    return (word & mask) == value;
  };
  for (std::uint32_t word = 0; word < 0x10000; ++word) {
    const int states = matches(word, 0x4F, 0x00) + matches(word, 0x4F, 0x40) + matches(word, 0x6F, 0x21) +
                       matches(word, 0x6F, 0x23) + matches(word, 0x6F, 0x27) + matches(word, 0x6F, 0x07) +
                       matches(word, 0x4F, 0x0F) + matches(word, 0x4F, 0x08);
    ASSERT_LE(states, 1);
    ASSERT_EQ(cia402::decode(static_cast<std::uint16_t>(word)) != DriveState::Unknown, states == 1) << word;
  }
}

TEST(BridgeCia402, OnlySwitchedOnDrivesAreEnabled) {
  EXPECT_EQ(cia402::towards_enabled(DriveState::SwitchOnDisabled, true), 0x06);
  EXPECT_EQ(cia402::towards_enabled(DriveState::ReadyToSwitchOn, true), 0x07);
  EXPECT_EQ(cia402::towards_enabled(DriveState::SwitchedOn, false), 0x07);
  EXPECT_EQ(cia402::towards_enabled(DriveState::SwitchedOn, true), 0x0F);
  for (const DriveState state : {DriveState::Fault, DriveState::FaultReaction, DriveState::QuickStopActive,
                                 DriveState::NotReady, DriveState::Unknown})
    EXPECT_EQ(cia402::towards_enabled(state, true), 0x00);
}

TEST(BridgeSdo, TimesOutAfterItsRetriesAndAborts) {
  SdoClient client(5, 100, 2);
  client.upload(0x1000, 0);
  int requests = 0;
  std::optional<can::Frame> last;
  for (std::int64_t now = 0; client.busy() && now < 10000; ++now)
    if (const auto frame = client.poll(now)) {
      last = frame;
      requests += frame->data[0] == 0x40 ? 1 : 0;
    }
  EXPECT_EQ(requests, 3);
  ASSERT_TRUE(last);
  EXPECT_EQ(*last, golden(0x605, {0x80, 0x00, 0x10, 0x00,     // abort of 1000h:00
                                  0x00, 0x00, 0x04, 0x05}));  // 05040000h: timed out
  EXPECT_EQ(client.result().outcome, SdoClient::Outcome::TimedOut);
}

TEST(BridgeSdo, AnswersToOtherObjectsAreNotTaken) {
  SdoClient client(5, 100, 2);
  client.upload(0x6061, 0);
  static_cast<void>(client.poll(0));
  client.receive({canopen::SdoAnswer::Kind::Uploaded, 0x6060, 0, 1, 8});
  client.receive({canopen::SdoAnswer::Kind::Uploaded, 0x6061, 1, 1, 8});
  client.receive({canopen::SdoAnswer::Kind::Downloaded, 0x6061, 0, 1, 8});
  EXPECT_TRUE(client.busy());
  client.receive({canopen::SdoAnswer::Kind::Uploaded, 0x6061, 0, 1, 8});
  EXPECT_FALSE(client.busy());
  EXPECT_EQ(client.result().value, 8U);
}

TEST(BridgeWords, NoCodeIsWithoutWords) {
  for (std::uint32_t code = 0; code < 0x10000; ++code)
    ASSERT_FALSE(canopen::emergency_words(static_cast<std::uint16_t>(code)).empty());
  EXPECT_EQ(canopen::emergency_words(0x8130), "heartbeat of the master lost");
  EXPECT_FALSE(canopen::abort_words(0x12345678).empty());
}

}  // namespace
}  // namespace glenoid::bridge::test
