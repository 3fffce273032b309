// From bytes to the loop: what is no setpoint never becomes one, the newest wins, commands are all there.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "host/bridge/lcm/convert.hpp"
#include "host/bridge/lcm/inbox.hpp"
#include "support/allocation_guard.hpp"
#include "support/environment.hpp"
#include "support/random.hpp"

namespace glenoid::lcm_port {
namespace {

using bridge::Command;
using bridge::Request;
using bridge::Setpoint;

template <class Message>
std::vector<std::uint8_t> bytes_of(const Message& message) {
  std::vector<std::uint8_t> out(static_cast<std::size_t>(message.getEncodedSize()));
  EXPECT_EQ(message.encode(out.data(), 0, static_cast<int>(out.size())), static_cast<int>(out.size()));
  return out;
}

setpoint_v1_t setpoint(std::int64_t sequence) {
  setpoint_v1_t out{};
  out.sequence = sequence;
  out.session = 7;
  out.count = 6;
  for (int k = 0; k < 16; ++k) out.position_rad[k] = 1e-3 * static_cast<double>(sequence) + k;
  return out;
}

command_v1_t command(std::int32_t request, std::int64_t sequence) {
  command_v1_t out{};
  out.command = request;
  out.sequence = sequence;
  return out;
}

class InboxTest : public testing::Test {
 protected:
  Decoded hear(const std::vector<std::uint8_t>& bytes) { return inbox_->hear_setpoint(bytes.data(), bytes.size(), 1); }
  std::vector<Setpoint> taken() {
    std::array<Setpoint, Inbox::kNewest> room;
    const std::size_t count = inbox_->take_setpoints(room);
    return {room.begin(), room.begin() + static_cast<std::ptrdiff_t>(count)};
  }
  std::vector<Command> commands() {
    std::vector<Command> room(100);
    room.resize(inbox_->take_commands(room));
    return room;
  }

  std::unique_ptr<Inbox> inbox_ = std::make_unique<Inbox>();
};

TEST_F(InboxTest, TypesHaveTheLengthsTheirFilesState) {
  EXPECT_EQ(setpoint_v1_t().getEncodedSize(), 424);
  EXPECT_EQ(feedback_v1_t().getEncodedSize(), 640);
  EXPECT_EQ(command_v1_t().getEncodedSize(), 36);
  EXPECT_EQ(event_v1_t().getEncodedSize(), 220);
  EXPECT_EQ(status_v1_t().getEncodedSize(), 1136);
  EXPECT_EQ(figures_v1_t().getEncodedSize(), 676);
  EXPECT_EQ(device_v1_t().getEncodedSize(), 984);
}

TEST_F(InboxTest, ASetpointArrivesAsItWasSent) {
  setpoint_v1_t sent = setpoint(5);
  sent.time_mono_ns = 123;
  sent.valid_mask = 0x3F;
  sent.velocity_rad_per_s[3] = -0.5;
  sent.effort_feedforward_Nm[15] = 2.5;
  EXPECT_EQ(inbox_->hear_setpoint(bytes_of(sent).data(), 424, 99), Decoded::Ok);
  const auto got = taken();
  ASSERT_EQ(got.size(), 1u);
  EXPECT_EQ(got[0].time_ns, 123);
  EXPECT_EQ(got[0].arrival_ns, 99);
  EXPECT_EQ(got[0].sequence, 5);
  EXPECT_EQ(got[0].session, 7);
  EXPECT_EQ(got[0].count, 6);
  EXPECT_EQ(got[0].valid_mask, 0x3F);
  for (std::size_t k = 0; k < 16; ++k) EXPECT_EQ(got[0].position_rad[k], sent.position_rad[k]);
  EXPECT_EQ(got[0].velocity_rad_per_s[3], -0.5);
  EXPECT_EQ(got[0].effort_feedforward_Nm[15], 2.5);
}

TEST_F(InboxTest, ValuesAreNotJudgedHere) {
  setpoint_v1_t sent = setpoint(1);
  sent.count = -5;
  sent.position_rad[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(hear(bytes_of(sent)), Decoded::Ok);
  const auto got = taken();
  ASSERT_EQ(got.size(), 1u);
  EXPECT_EQ(got[0].count, -5);
  EXPECT_TRUE(std::isnan(got[0].position_rad[0]));
}

TEST_F(InboxTest, EveryOtherLengthIsRefused) {
  auto bytes = bytes_of(setpoint(1));
  bytes.resize(1000);
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    // A buffer of exactly that size, so that a sanitizer sees a read behind it.
    const std::vector<std::uint8_t> message(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(hear(message), size == 424 ? Decoded::Ok : Decoded::Size) << size;
  }
  EXPECT_EQ(taken().size(), 1u);
  EXPECT_EQ(inbox_->take_undecodable(), 1000);
  EXPECT_EQ(inbox_->take_undecodable(), 0) << "told once";
}

TEST_F(InboxTest, ForeignTypesAreRefused) {
  EXPECT_EQ(hear(bytes_of(feedback_v1_t{})), Decoded::Size);
  EXPECT_EQ(hear(bytes_of(command_v1_t{})), Decoded::Size);
  auto bytes = bytes_of(setpoint(1));
  for (std::size_t bit = 0; bit < 64; ++bit) {
    auto forged = bytes;
    forged[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
    EXPECT_EQ(hear(forged), Decoded::Type);
  }
  EXPECT_TRUE(taken().empty());
  EXPECT_EQ(inbox_->heard(Decoded::Type), 64u);
}

TEST_F(InboxTest, RubbishOfTheRightLengthIsRefusedOrHarmless) {
  test::Random random(5);
  for (int n = 0; n < test::test_count(2000); ++n) {
    auto bytes = bytes_of(setpoint(1));
    for (std::size_t k = n % 2 == 0 ? 0 : 8; k < bytes.size(); ++k)
      bytes[k] = static_cast<std::uint8_t>(random.uniform(0, 256));
    ASSERT_EQ(hear(bytes), n % 2 == 0 ? Decoded::Type : Decoded::Ok);
    std::vector<std::uint8_t> request(36);
    for (auto& byte : request) byte = static_cast<std::uint8_t>(random.uniform(0, 256));
    ASSERT_NE(inbox_->hear_command(request.data(), request.size()), Decoded::Ok);
  }
  EXPECT_TRUE(commands().empty());
}

TEST_F(InboxTest, OfAFloodTheNewestAreTakenInOrderAndOnce) {
  for (std::int64_t n = 1; n <= 1000; ++n) hear(bytes_of(setpoint(n)));
  const auto got = taken();
  ASSERT_EQ(got.size(), Inbox::kNewest);
  for (std::size_t k = 0; k < got.size(); ++k) {
    EXPECT_EQ(got[k].sequence, 1000 - static_cast<std::int64_t>(Inbox::kNewest) + 1 + static_cast<std::int64_t>(k));
  }
  EXPECT_TRUE(taken().empty());
  hear(bytes_of(setpoint(1001)));
  EXPECT_EQ(taken().size(), 1u);
}

TEST_F(InboxTest, NothingIsLostWhereFewWaited) {
  std::int64_t expected = 0, sent = 0;
  for (int round = 0; round < 100; ++round) {
    for (int n = 0; n <= round % static_cast<int>(Inbox::kNewest) && n < static_cast<int>(Inbox::kNewest); ++n)
      hear(bytes_of(setpoint(++sent)));
    for (const Setpoint& got : taken()) EXPECT_EQ(got.sequence, ++expected);
  }
  EXPECT_EQ(expected, sent);
}

TEST_F(InboxTest, CommandsKeepTheirOrderAndNumber) {
  for (std::int64_t n = 0; n < 60; ++n) {
    const auto bytes = bytes_of(command(static_cast<std::int32_t>(1 + n % 3), n));
    EXPECT_EQ(inbox_->hear_command(bytes.data(), bytes.size()), Decoded::Ok);
  }
  const auto got = commands();
  ASSERT_EQ(got.size(), 60u);
  for (std::size_t n = 0; n < 60; ++n) {
    EXPECT_EQ(got[n].sequence, static_cast<std::int64_t>(n));
    EXPECT_EQ(static_cast<int>(got[n].request), static_cast<int>(1 + n % 3));
  }
}

TEST_F(InboxTest, AnEmergencyStopWaitsBehindNothing) {
  std::array<Command, 16> into{};
  const auto ask = [this](std::int32_t request) {
    const auto bytes = bytes_of(command(request, 1));
    EXPECT_EQ(inbox_->hear_command(bytes.data(), bytes.size()), Decoded::Ok);
  };
  for (int n = 0; n < 40; ++n) ask(command_v1_t::STOP);
  for (int round = 0; round < 20; ++round) {  // the loop takes 16 at once and never catches up
    const bool pressed = round == 10;
    for (int n = 0; n < 15; ++n) ask(command_v1_t::STOP);
    if (pressed) ask(command_v1_t::ESTOP);
    const std::size_t count = inbox_->take_commands(into);
    const std::span<const Command> got(into.data(), count);
    const auto stops = std::count_if(got.begin(), got.end(),
                                     [](const Command& c) { return c.request == Request::EStop; });
    EXPECT_EQ(stops, pressed ? 1 : 0) << round;
    if (pressed) {
      EXPECT_EQ(got.front().request, Request::EStop);
    }
  }
}

TEST_F(InboxTest, AFloodOfRequestsIsAnEmergencyStopAtOnce) {
  std::array<Command, 16> into{};
  for (std::int64_t n = 0; n < 65; ++n) {
    const auto bytes = bytes_of(command(command_v1_t::ARM, n));
    inbox_->hear_command(bytes.data(), bytes.size());
  }
  ASSERT_EQ(inbox_->take_commands(into), into.size());
  EXPECT_EQ(into.front().request, Request::EStop);
}

TEST_F(InboxTest, MoreCommandsThanFitEndInAnEmergencyStop) {
  for (std::int64_t n = 0; n < 200; ++n) {
    const auto bytes = bytes_of(command(command_v1_t::ARM, n));
    inbox_->hear_command(bytes.data(), bytes.size());
  }
  const auto got = commands();
  ASSERT_EQ(got.size(), 65u);
  EXPECT_EQ(got.front().request, Request::EStop);
  EXPECT_TRUE(commands().empty());
}

class NoCommand : public InboxTest, public testing::WithParamInterface<std::int32_t> {};
TEST_P(NoCommand, IsRefused) {
  const auto bytes = bytes_of(command(GetParam(), 1));
  EXPECT_EQ(inbox_->hear_command(bytes.data(), bytes.size()), Decoded::Value);
  EXPECT_TRUE(commands().empty());
}
INSTANTIATE_TEST_SUITE_P(Numbers, NoCommand,
                         testing::Values(0, -1, 7, 1 << 30, std::numeric_limits<std::int32_t>::min()));

TEST_F(InboxTest, TakingAllocatesNothing) {
  const auto bytes = bytes_of(setpoint(1));
  std::array<Setpoint, Inbox::kNewest> room;
  std::array<Command, 4> requests;
  const test::AllocationGuard guard;
  for (int n = 0; n < 100; ++n) {
    inbox_->hear_setpoint(bytes.data(), bytes.size(), 1);
    inbox_->take_setpoints(room);
    inbox_->take_commands(requests);
    inbox_->take_undecodable();
  }
  EXPECT_EQ(guard.allocations(), 0);
}

TEST(Mailbox, TheWriterNeverTouchesWhatTheReaderHolds) {
  test::Random random(6);
  Mailbox<int> mailbox;
  int posted = 0, held = 0;
  for (int n = 0; n < test::test_count(5000); ++n) {
    if (random.uniform(0, 1) < 0.5) {
      mailbox.draft() = posted + 1;
      ASSERT_EQ(mailbox.value(), held) << "while the writer drafts";
      mailbox.post();
      ++posted;
    } else if (mailbox.take()) {
      ASSERT_GT(posted, held);
      held = posted;
    } else {
      ASSERT_EQ(posted, held) << "something newer was not shown";
    }
    ASSERT_EQ(mailbox.value(), held);
  }
}

// Every word of a posted value is the same number, so that half of one and half of another would show.
TEST(Mailbox, NeverShowsHalfAValueNorAnOlderOne) {
  struct Block {
    std::array<std::int64_t, 64> words{};
  };
  auto mailbox = std::make_unique<Mailbox<Block>>();
  const std::int64_t posts = test::test_count(200'000);
  std::thread writer([&] {
    for (std::int64_t n = 1; n <= posts; ++n) {
      mailbox->draft().words.fill(n);
      mailbox->post();
    }
  });
  std::int64_t last = 0;
  while (last < posts) {
    if (!mailbox->take()) {
      std::this_thread::yield();
      continue;
    }
    const auto& words = mailbox->value().words;
    ASSERT_GT(words[0], last);
    last = words[0];
    for (const std::int64_t word : words) ASSERT_EQ(word, last);
  }
  writer.join();
  EXPECT_FALSE(mailbox->take());
}

TEST(Ring, HandsOverEveryValueInOrder) {
  auto ring = std::make_unique<Ring<std::int64_t, 16>>();
  const std::int64_t values = test::test_count(200'000);
  std::thread writer([&] {
    for (std::int64_t n = 1; n <= values;) {
      if (ring->push(n)) {
        ++n;
      } else {
        std::this_thread::yield();
      }
    }
  });
  std::int64_t expected = 1, got = 0;
  while (expected <= values) {
    if (!ring->pop(got)) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(got, expected++);
  }
  writer.join();
}

TEST_F(InboxTest, TwoThreadsHandOverSetpointsInOrder) {
  const std::int64_t posts = test::test_count(50'000);
  std::thread hearing([&] {
    for (std::int64_t n = 1; n <= posts; ++n) hear(bytes_of(setpoint(n)));
  });
  std::int64_t last = 0;
  while (last < posts) {
    for (const Setpoint& got : taken()) {
      ASSERT_GT(got.sequence, last);
      last = got.sequence;
      for (std::size_t k = 0; k < 16; ++k)
        ASSERT_EQ(got.position_rad[k], 1e-3 * static_cast<double>(last) + static_cast<double>(k));
    }
  }
  hearing.join();
}

}  // namespace
}  // namespace glenoid::lcm_port
