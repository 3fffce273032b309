// Injected faults, and how the simulated drive reacts when its host falls silent.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "bus/drives_bench.hpp"

namespace glenoid::test {
namespace {

using drives::FaultKind;

int emergency_code(DriveBench& bench) {
  const auto frames = bench.take(0x080U + bench.drive.node());
  return frames.empty() ? -1 : frames.front().data[0] | frames.front().data[1] << 8;
}

TEST(DriveFaults, StuckEncoderEndsInAFollowingErrorAndRest) {
  DriveBench bench;
  bench.prepare();
  bench.enable();
  const auto move = [&](int cycles, int from) {
    for (int k = from; k < from + cycles; ++k) bench.cycle(0x0F, bench.counts(0.001 * k));
  };
  move(100, 0);
  drives::Outbox out;
  bench.drive.inject({FaultKind::StuckEncoder, 0, 0}, bench.now_ns, out);
  const std::int64_t reported = bench.upload(0x6064).value;
  move(300, 100);
  EXPECT_EQ(bench.upload(0x6064).value, reported);
  EXPECT_EQ(bench.state() & 0x4F, 0x08U);
  bench.wait(500 * kMs);
  EXPECT_EQ(bench.drive.view().velocity_rad_per_s, 0.0);
}

TEST(DriveFaults, StallIsSilentAndFreezesTheTarget) {
  DriveBench bench;
  bench.prepare();
  ASSERT_EQ(bench.download(0x1017, 0, 10, 2), 0U);
  bench.enable();
  bench.download(0x2F00, 3, 100, 4);
  bench.download(0x2F00, 1, 3, 1);
  bench.take();
  for (int k = 0; k < 49; ++k) bench.cycle(0x0F, bench.counts(0.1));
  EXPECT_TRUE(bench.take().empty());
  EXPECT_NEAR(bench.drive.view().position_rad, 0.0, 1e-4);
  bench.wait(10 * kMs);
  EXPECT_FALSE(bench.take(0x701).empty());
}

TEST(DriveFaults, BusOffStopsTheJointAndTellsAfterRecovery) {
  DriveBench bench;
  bench.prepare();
  ASSERT_EQ(bench.download(0x6007, 0, 3, 2), 0U);
  bench.enable();
  drives::Outbox out;
  bench.drive.inject({FaultKind::BusOff, 0, 50}, bench.now_ns, out);
  bench.take();
  bench.wait(49 * kMs);
  EXPECT_TRUE(bench.take().empty());
  EXPECT_EQ(bench.state(), 0x40U);
  bench.wait(2 * kMs);
  EXPECT_EQ(emergency_code(bench), 0x8140);
}

TEST(DriveFaults, DelayedFramesKeepTheirOrder) {
  DriveBench bench;
  bench.prepare();
  bench.download(0x2F00, 2, 5000, 4);  // us
  bench.download(0x2F00, 1, 2, 1);
  bench.take();
  bench.sync();
  EXPECT_TRUE(bench.take().empty());
  bench.wait(4 * kMs);
  EXPECT_TRUE(bench.take().empty());
  bench.wait(1 * kMs);
  EXPECT_EQ(bench.take().size(), 1U);
}

TEST(DriveFaults, LossIsTheSameForTheSameSeedAndNearItsRate) {
  const auto answers = [](std::uint64_t seed) {
    DriveBench bench({}, {1, 0.0, seed});
    bench.prepare();
    drives::Outbox out;
    bench.drive.inject({FaultKind::Drop, 200, 0}, bench.now_ns, out);
    std::string which;
    for (int k = 0; k < 2000; ++k) {
      bench.take();
      bench.sync();
      which += bench.take(0x181).empty() ? '-' : 'x';
      bench.wait(2 * kMs);
    }
    return which;
  };
  const std::string first = answers(7);
  EXPECT_EQ(first, answers(7));
  EXPECT_NE(first, answers(8));
  // Both the SYNC and the answer get through: 0.8^2 of 2000, five standard deviations of a binomial.
  const double mean = 2000 * 0.64, deviation = std::sqrt(2000 * 0.64 * 0.36);
  EXPECT_NEAR(static_cast<double>(std::count(first.begin(), first.end(), 'x')), mean, 5 * deviation);
}

TEST(DriveFaults, RebootForgetsTheConfigurationAndBoots) {
  DriveBench bench;
  bench.prepare();
  bench.enable();
  bench.download(0x2F00, 1, 5, 1);
  EXPECT_FALSE(bench.drive.view().powered);
  bench.take();
  bench.wait(25 * kMs);
  EXPECT_EQ(bench.take(0x701).at(0).data[0], 0);
  EXPECT_EQ(bench.upload(0x6060).value, 0);
  EXPECT_EQ(bench.drive.counters().reboots, 1U);
}

/// Loss of SYNC and of RPDOs, as each family reacts.
struct Loss {
  const char* name;
  int sync_reaction, rpdo_reaction;
  unsigned state_after_sync_loss, state_after_rpdo_loss;
};
class LossOfHost : public testing::TestWithParam<Loss> {};
INSTANTIATE_TEST_SUITE_P(Reactions, LossOfHost,
                         testing::Values(Loss{"nothing", 0, 0, 0x27, 0x27}, Loss{"report", 1, 1, 0x27, 0x27},
                                         Loss{"hold", 2, 1, 0x27, 0x27}, Loss{"quick_stop", 3, 3, 0x40, 0x40},
                                         Loss{"fault", 4, 4, 0x08, 0x08}, Loss{"voltage", 5, 5, 0x40, 0x40}),
                         [](const auto& given) { return std::string(given.param.name); });

TEST_P(LossOfHost, OfSyncActsAsConfigured) {
  drives::Profile profile;
  profile.sync_lost_bit = 15;
  DriveBench bench(profile);
  bench.prepare();
  ASSERT_EQ(bench.download(0x1006, 0, 2000, 4), 0U);
  ASSERT_EQ(bench.download(0x2F10, 2, 500, 4), 0U);
  ASSERT_EQ(bench.download(0x2F10, 1, GetParam().sync_reaction, 1), 0U);
  bench.enable();
  bench.take();
  bench.sync();
  bench.wait(2'400'000);
  EXPECT_EQ(bench.state(), 0x27U);
  EXPECT_EQ(emergency_code(bench), -1);
  bench.wait(5 * kMs);
  EXPECT_EQ(bench.state() & (GetParam().sync_reaction == 4 ? 0x4FU : 0x6FU), GetParam().state_after_sync_loss);
  EXPECT_EQ(emergency_code(bench), GetParam().sync_reaction == 0 ? -1 : 0x8700);
  EXPECT_NE(bench.drive.view().statusword & 1U << 15U, 0U);
  bench.sync();
  EXPECT_EQ(bench.drive.view().statusword & 1U << 15U, 0U);
}

TEST_P(LossOfHost, OfRpdosActsAsConfigured) {
  DriveBench bench;
  bench.prepare();
  bench.give(0x000, {0x80, 1});
  ASSERT_EQ(bench.download(0x1400, 5, 10, 2), 0U);
  ASSERT_EQ(bench.download(0x2F10, 3, GetParam().rpdo_reaction, 1), 0U);
  bench.give(0x000, {0x01, 1});
  bench.enable();
  bench.take();
  for (int k = 0; k < 10; ++k) {
    bench.sync();
    bench.wait(2 * kMs);
  }
  EXPECT_EQ(bench.state() & (GetParam().rpdo_reaction == 4 ? 0x4FU : 0x6FU), GetParam().state_after_rpdo_loss);
}

}  // namespace
}  // namespace glenoid::test
