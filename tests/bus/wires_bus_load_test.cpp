// Bits of a frame and shares of a bus against an independent count of stuff bits and the arithmetic of the mapping.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "host/bridge/can/bus_load.hpp"
#include "support/environment.hpp"
#include "support/random.hpp"

namespace glenoid::can {
namespace {

using Bits = std::vector<int>;

void append(Bits& bits, std::uint32_t value, int count) {
  for (int k = count - 1; k >= 0; --k) bits.push_back(static_cast<int>(value >> k & 1u));
}

/// ISO 11898-1: remainder by x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1.
std::uint32_t crc15(const Bits& bits) {
  std::uint32_t crc = 0;
  for (const int bit : bits) {
    const bool next = ((crc >> 14) & 1u) != static_cast<std::uint32_t>(bit);
    crc = (crc << 1) & 0x7FFFu;
    if (next) crc ^= 0x4599u;
  }
  return crc;
}

/// Bits of a data frame with an 11-bit identifier as they are sent, interframe space included.
std::size_t bits_on_the_wire(std::uint32_t id, const std::vector<std::uint8_t>& data) {
  Bits bits = {0};
  append(bits, id, 11);
  append(bits, 0, 3);  // no remote frame, standard format, reserved
  append(bits, static_cast<std::uint32_t>(data.size()), 4);
  for (const std::uint8_t byte : data) append(bits, byte, 8);
  append(bits, crc15(bits), 15);
  std::size_t stuffed = 0;
  int run = 0, last = -1;
  for (const int bit : bits) {
    run = bit == last ? run + 1 : 1;
    last = bit;
    if (run == 5) {  // the stuff bit begins the next run
      ++stuffed;
      last = 1 - bit;
      run = 1;
    }
  }
  return bits.size() + stuffed + 1 + 2 + 7 + 3;  // CRC delimiter, acknowledge, end of frame, interframe space
}

TEST(FrameBits, OfEveryFrameLieBetweenNoStuffingAndTheWorst) {
  test::Random random(1);
  for (int n = 0; n < test::test_count(5000); ++n) {
    std::vector<std::uint8_t> data(static_cast<std::size_t>(random.uniform(0, 9)));
    for (auto& byte : data) byte = static_cast<std::uint8_t>(random.uniform(0, 256));
    const std::size_t bits = bits_on_the_wire(static_cast<std::uint32_t>(random.uniform(0, 2048)), data);
    ASSERT_GE(bits, frame_bits(data.size(), false, Stuffing::None));
    ASSERT_LE(bits, frame_bits(data.size(), false, Stuffing::Worst));
  }
}

TEST(FrameBits, NoStuffingIsReachedByAFrameThatNeedsNone) {
  // 0101... has no run of five; its CRC is what it is, so the frame is searched for.
  std::size_t fewest = 1000;
  for (std::uint32_t id = 0; id < 2048; ++id) {
    fewest = std::min(fewest, bits_on_the_wire(id, {0x55, 0xAA, 0x55, 0x5A, 0xA5, 0x55, 0xAA, 0x55}));
  }
  EXPECT_EQ(fewest, frame_bits(8, false, Stuffing::None));
}

TEST(FrameBits, WorstStuffingIsNearlyReached) {
  // 1 0000 1111 0000 ... behind a run of five: a stuff bit after every fourth bit but for what the header and the CRC break.
  std::size_t most = 0;
  for (std::uint32_t id = 0; id < 2048; ++id) {
    for (const std::uint8_t byte : std::initializer_list<std::uint8_t>{0x0F, 0x1E, 0x3C, 0x78, 0xF0, 0xE1, 0xC3, 0x87}) {
      most = std::max(most, bits_on_the_wire(id, std::vector<std::uint8_t>(8, byte)));
    }
  }
  const std::size_t bound = frame_bits(8, false, Stuffing::Worst);
  EXPECT_LE(most, bound);
  EXPECT_GE(most + 6, bound);  // control field and CRC, 21 bits, cannot be chosen: at most 5 stuff bits fewer
}

TEST(FrameBits, OfAnExtendedFrameIncludeTwentyMoreBits) {
  for (std::size_t bytes = 0; bytes <= 8; ++bytes) {
    EXPECT_EQ(frame_bits(bytes, true, Stuffing::None), frame_bits(bytes, false, Stuffing::None) + 20);
  }
  EXPECT_EQ(frame_bits(8, true, Stuffing::Worst), 160u);
}

struct Row {
  std::size_t drives;
  double none_percent_at_500_hz, worst_percent_at_500_hz;
};

class Mapping : public testing::TestWithParam<Row> {};

// SYNC, and per drive 6 bytes out and 8 back: 55 + N (115 + 135) bits at worst, 47 + N (95 + 111) without stuffing, at
// 500 Hz on 1 Mbit/s.
TEST_P(Mapping, TakesItsShareOfTheBus) {
  const BusTraffic traffic{.drives = GetParam().drives, .drive_heartbeat_rate_hz = 0, .master_heartbeat_rate_hz = 0};
  const double half_percent = 0.005;  // the table is rounded to whole percent
  EXPECT_NEAR(traffic_load(traffic, Stuffing::None), 0.01 * GetParam().none_percent_at_500_hz, half_percent);
  EXPECT_NEAR(worst_case_load(traffic), 0.01 * GetParam().worst_percent_at_500_hz, half_percent);
}
INSTANTIATE_TEST_SUITE_P(PlainMapping, Mapping,
                         testing::Values(Row{3, 33, 40}, Row{4, 44, 53}, Row{6, 64, 78}, Row{8, 85, 103},
                                         Row{12, 126, 153}));

TEST(WorstCaseLoad, GrowsInProportionToTheRateAndFallsWithTheBitRate) {
  const BusTraffic slow{.drive_heartbeat_rate_hz = 0, .master_heartbeat_rate_hz = 0};
  BusTraffic fast = slow;
  fast.sync_rate_hz *= 2;
  EXPECT_DOUBLE_EQ(worst_case_load(fast), 2 * worst_case_load(slow));
  fast.bit_rate *= 2;
  EXPECT_DOUBLE_EQ(worst_case_load(fast), worst_case_load(slow));
}

TEST(WorstCaseLoad, OfSixDrivesIsAllowedAt500HzAndRefusedAt1kHz) {
  BusTraffic traffic;
  EXPECT_LT(worst_case_load(traffic), kLoadWarned);
  traffic.sync_rate_hz = 1000;
  EXPECT_GT(worst_case_load(traffic), kLoadRefused);
  traffic.drives = 3;  // one of two buses
  EXPECT_LT(worst_case_load(traffic), kLoadRefused);
}

TEST(WorstCaseLoad, CountsHeartbeatsSecondPdosAndTheReserve) {
  const double before = worst_case_load({});
  EXPECT_NEAR(worst_case_load({.second_tpdo_rate_hz = 100}) - before, 6 * 100 * 115 / 1e6, 1e-12);
  EXPECT_NEAR(worst_case_load({.drive_heartbeat_rate_hz = 20}) - before, 6 * 10 * 65 / 1e6, 1e-12);
  EXPECT_NEAR(worst_case_load({.reserve = 0.1}) - before, 0.1, 1e-12);
}

}  // namespace
}  // namespace glenoid::can
