#include <gtest/gtest.h>
#include <linux/can/error.h>

#include <array>

#include "host/bridge/can/error_frame.hpp"
#include "support/environment.hpp"
#include "support/random.hpp"

namespace glenoid::can {
namespace {

Frame error_frame(std::uint32_t classes, std::array<std::uint8_t, 8> data = {}) {
  return {.id = classes, .size = 8, .error = true, .data = data};
}

class Made : public testing::TestWithParam<ControllerState> {};
TEST_P(Made, ErrorFrameIsDecodedToItsStateAndCounters) {
  const ErrorReport report = decode_error(make_error(GetParam(), 130, 7));
  EXPECT_TRUE(report.has_state);
  EXPECT_EQ(report.state, GetParam());
  EXPECT_TRUE(report.has_counters);
  EXPECT_EQ(report.tx_errors, 130);
  EXPECT_EQ(report.rx_errors, 7);
}
INSTANTIATE_TEST_SUITE_P(States, Made,
                         testing::Values(ControllerState::Active, ControllerState::Warning, ControllerState::Passive,
                                         ControllerState::Off));

TEST(ErrorFrame, BusOffWinsOverEverythingInTheSameFrame) {
  const Frame frame = error_frame(CAN_ERR_BUSOFF | CAN_ERR_CRTL | CAN_ERR_RESTARTED, {0, CAN_ERR_CRTL_ACTIVE});
  EXPECT_EQ(decode_error(frame).state, ControllerState::Off);
}

TEST(ErrorFrame, PassiveWinsOverWarning) {
  const Frame frame = error_frame(CAN_ERR_CRTL, {0, CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_PASSIVE});
  EXPECT_EQ(decode_error(frame).state, ControllerState::Passive);
}

TEST(ErrorFrame, AnOverflowSaysNothingOfTheState) {
  const ErrorReport report = decode_error(error_frame(CAN_ERR_CRTL, {0, CAN_ERR_CRTL_RX_OVERFLOW}));
  EXPECT_FALSE(report.has_state);
  EXPECT_TRUE(report.receive_overflow);
  EXPECT_FALSE(report.has_counters);
}

TEST(ErrorFrame, CountersOfDriversThatDoNotAnnounceThemAreRead) {
  const ErrorReport report = decode_error(error_frame(CAN_ERR_ACK, {0, 0, 0, 0, 0, 0, 128, 0}));
  EXPECT_TRUE(report.has_counters);
  EXPECT_EQ(report.tx_errors, 128);
  EXPECT_TRUE(report.no_acknowledge);
}

TEST(ErrorFrame, ADataFrameIsNoReport) {
  Frame frame = error_frame(CAN_ERR_BUSOFF);
  frame.error = false;
  EXPECT_FALSE(decode_error(frame).has_state);
  EXPECT_EQ(describe_error(frame), "no error frame");
}

TEST(ErrorFrame, WordsNameTheStateAndTheCounters) {
  EXPECT_EQ(describe_error(make_error(ControllerState::Off, 248, 0)),
            "bus off; transmit error counter 248, receive error counter 0");
  EXPECT_EQ(describe_error(error_frame(CAN_ERR_RESTARTED)), "error active; controller restarted");
  EXPECT_EQ(describe_error(error_frame(CAN_ERR_TX_TIMEOUT | CAN_ERR_TRX)),
            "transmission timed out; transceiver fault, wiring");
}

TEST(ErrorFrame, EveryClassHasWords) {
  test::Random random(2);
  for (int n = 0; n < test::test_count(2000); ++n) {
    Frame frame = error_frame(static_cast<std::uint32_t>(random.uniform(0, 0x400)));
    for (auto& byte : frame.data) byte = static_cast<std::uint8_t>(random.uniform(0, 256));
    EXPECT_FALSE(describe_error(frame).empty());
  }
}

}  // namespace
}  // namespace glenoid::can
