// Parts of the loop that need no clock: histogram, log line, e-stop descriptor.

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <thread>

#include "host/bridge/loop/estop_input.hpp"
#include "host/bridge/loop/frame_log.hpp"
#include "host/bridge/loop/histogram.hpp"
#include "host/bridge/loop/realtime.hpp"
#include "support/random.hpp"

namespace glenoid::bridge::test {
namespace {

TEST(BridgeHistogram, QuantilesAreWithinABucket) {
  glenoid::test::Random random(61);
  Histogram histogram;
  std::vector<double> values;
  for (int k = 0; k < 10000; ++k) {
    values.push_back(std::floor(random.log_uniform(1, 1e10)));
    histogram.record(static_cast<std::int64_t>(values.back()));
  }
  std::sort(values.begin(), values.end());
  for (const double share : {0.01, 0.5, 0.9, 0.99, 0.999}) {
    const double exact_us = 1e-3 * values[static_cast<std::size_t>(share * 10000)];
    EXPECT_GE(histogram.quantile_us(share), exact_us * (1 - 1e-12));
    EXPECT_LE(histogram.quantile_us(share), exact_us * (1 + 1.0 / 32));
  }
  EXPECT_EQ(histogram.largest_us(), 1e-3 * values.back());
  EXPECT_EQ(histogram.count(), 10000U);
}

TEST(BridgeHistogram, CanBeReadWhileItGrows) {
  Histogram histogram;
  std::atomic<bool> over = false;
  std::thread writer([&] {
    for (int k = 0; k < 200'000; ++k) histogram.record(1000 + k % 1000);
    over = true;
  });
  std::int64_t last = 0;
  while (!over) {
    const Figure figure = histogram.figure();
    EXPECT_GE(figure.values, last);
    EXPECT_LE(figure.p50_us, 2.0);
    EXPECT_LE(figure.largest_us, 2.0);
    last = figure.values;
  }
  writer.join();
  EXPECT_EQ(histogram.figure().values, 200'000);
  EXPECT_NEAR(histogram.figure().p50_us, 1.5, 1.5 / 32);
}

TEST(BridgeHistogram, ExtremesAreCounted) {
  Histogram histogram;
  EXPECT_EQ(histogram.quantile_us(0.5), 0.0);
  histogram.record(-5);
  histogram.record(INT64_MAX);
  EXPECT_EQ(histogram.count(), 2U);
}

TEST(BridgeWait, EndsNeverBeforeItsTimeAndIsAwakeAtTheEndOnly) {
  for (const std::int64_t awake_ns : {0, 50'000, 3'000'000}) {
    const std::int64_t until_ns = monotonic_ns() + 2'000'000;
    const std::int64_t awake_for_ns = wait_until(until_ns, awake_ns);
    EXPECT_GE(monotonic_ns(), until_ns);
    if (awake_ns == 0) {
      EXPECT_EQ(awake_for_ns, 0);
    }
  }
}

TEST(BridgeLog, LinesAreCandumps) {
  can::Frame frame;
  frame.id = 0x201;
  frame.size = 6;
  frame.data = {0x0F, 0x00, 0x10, 0x27};
  EXPECT_EQ(candump_line(1'700'000'000'123'456'789, "can0", frame), "(1700000000.123456) can0 201#0F0010270000");
  EXPECT_EQ(candump_line(1'000'000'000'000'000'001, "can0", can::Frame{0x80}), "(1000000000.000000) can0 080#");
  frame.extended = true;
  frame.size = 0;
  EXPECT_EQ(candump_line(0, "b", frame), "(0.000000) b 00000201#");
}

class Pipe : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(pipe(ends_.data()), 0); }
  void TearDown() override {
    close(ends_[0]);
    if (ends_[1] >= 0) close(ends_[1]);
  }
  void write(const char* text) { ASSERT_GT(::write(ends_[1], text, std::char_traits<char>::length(text)), 0); }
  void cut() {
    close(ends_[1]);
    ends_[1] = -1;
  }
  std::array<int, 2> ends_{};
};

TEST_F(Pipe, EnterPressesAndOneReleases) {
  EStopInput input(ends_[0]);
  EXPECT_FALSE(input.poll());
  write("\n");
  EXPECT_TRUE(input.poll());
  EXPECT_TRUE(input.poll());  // a level
  write("1\n");
  EXPECT_FALSE(input.poll());
  write("0");
  EXPECT_TRUE(input.poll());
}

TEST_F(Pipe, PressThatIsOverBeforeAnybodyLooksCounts) {
  EStopInput input(ends_[0]);
  write("0\n1\n");
  EXPECT_TRUE(input.poll());
  EXPECT_FALSE(input.poll());
  const std::string chatter(3000, '1');
  write(("0" + chatter).c_str());
  EXPECT_TRUE(input.poll());
  write((chatter + "0").c_str());
  EXPECT_TRUE(input.poll());
  EXPECT_TRUE(input.poll());
}

TEST_F(Pipe, CutWirePressesForGood) {
  EStopInput input(ends_[0]);
  write("1");
  EXPECT_FALSE(input.poll());
  cut();
  EXPECT_TRUE(input.poll());
  EXPECT_TRUE(input.poll());
}

TEST(BridgeEStop, WithoutADescriptorItIsNotPressed) { EXPECT_FALSE(EStopInput(-1).poll()); }

}  // namespace
}  // namespace glenoid::bridge::test
