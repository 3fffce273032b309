// The bridge's end of LCM and the publisher's end, over multicast in a network of their own.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <thread>
#include <vector>

#include "bus/wires_network.hpp"
#include "host/bridge/lcm/lcm_port.hpp"
#include "host/bridge/lcm/publisher.hpp"
#include "support/allocation_guard.hpp"

namespace glenoid::lcm_port {
namespace {

using namespace std::chrono_literals;

bool wait_until(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + 10s;
  while (std::chrono::steady_clock::now() < end) {
    if (condition()) return true;
    std::this_thread::sleep_for(1ms);
  }
  return false;
}

class Lcm : public testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = test::own_network(); !why.empty()) GTEST_SKIP() << why;
    port_ = std::make_unique<LcmPort>(LcmOptions{});
    lcm_ = std::make_unique<lcm::LCM>(std::string(kDefaultUrl));
    // The hearing thread subscribes after the constructor has returned.
    ASSERT_TRUE(wait_until([&] {
      command_v1_t message{};
      lcm_->publish(kCommandChannel, &message);
      return port_->inbox().heard(Decoded::Value) > 0;
    }));
  }
  bridge::Status ready(std::int64_t session) {
    bridge::Status out;
    out.session = session;
    out.state = bridge::State::Ready;
    return out;
  }

  std::unique_ptr<LcmPort> port_;
  std::unique_ptr<lcm::LCM> lcm_;
  std::array<bridge::Setpoint, Inbox::kNewest> setpoints_;
  std::array<bridge::Command, 8> commands_;
};

TEST_F(Lcm, AFloodEndsWithTheNewest) {
  setpoint_v1_t message{};
  constexpr std::int64_t kLast = 2000;
  for (message.sequence = 1; message.sequence <= kLast; ++message.sequence) {
    ASSERT_EQ(lcm_->publish(kSetpointChannel, &message), 0);
    if (message.sequence % 50 == 0) std::this_thread::sleep_for(1ms);  // the kernel's buffer is smaller than the flood
  }
  std::int64_t newest = 0;
  EXPECT_TRUE(wait_until([&] {
    const std::size_t count = port_->take_setpoints(setpoints_);
    if (count > 0) newest = setpoints_[count - 1].sequence;
    return newest == kLast;
  })) << "newest "
      << newest;
}

TEST_F(Lcm, HostileMessagesAreCountedAndNothingElse) {
  std::vector<std::uint8_t> bytes(2000, 0xFF);
  for (const std::size_t size : {0u, 1u, 7u, 8u, 423u, 424u, 425u, 2000u}) {
    lcm_->publish(kSetpointChannel, bytes.data(), static_cast<unsigned>(size));
  }
  std::int64_t undecodable = 0;
  EXPECT_TRUE(wait_until([&] { return (undecodable += port_->take_undecodable()) == 8; })) << undecodable;
  EXPECT_EQ(port_->take_setpoints(setpoints_), 0u);
}

TEST_F(Lcm, TheHandshakeArmsAndTheSetpointsCarryTheToken) {
  Publisher publisher;
  EXPECT_EQ(publisher.session(), 0);
  const std::array<double, 2> q = {0.1, 0.2}, dq = {};
  EXPECT_FALSE(publisher.publish(1, q, dq)) << "no token yet";
  std::thread bridge([&] {
    EXPECT_TRUE(wait_until(
        [&] { return port_->take_commands(commands_) > 0 && commands_[0].request == bridge::Request::Arm; }));
    wait_until([&] {
      port_->tell(ready(4711));
      port_->flush();
      std::this_thread::sleep_for(5ms);
      return port_->take_setpoints(setpoints_) > 0;
    });
  });
  EXPECT_TRUE(publisher.arm(10s));
  EXPECT_EQ(publisher.session(), 4711);
  EXPECT_TRUE(publisher.publish(123, q, dq));
  bridge.join();
  EXPECT_EQ(setpoints_[0].session, 4711);
  EXPECT_EQ(setpoints_[0].sequence, 1);
  EXPECT_EQ(setpoints_[0].count, 2);
  EXPECT_EQ(setpoints_[0].valid_mask, 3);
  EXPECT_EQ(setpoints_[0].position_rad[1], 0.2);
  EXPECT_FALSE(publisher.publish(1, q, std::array{0.0}));
  EXPECT_FALSE(publisher.publish(1, {}, {}));
  EXPECT_FALSE(publisher.publish(1, std::array{std::nan("")}, std::array{0.0}));
}

TEST_F(Lcm, EverythingToldIsHeardInOrder) {
  Publisher publisher;
  std::int64_t heard = 0;
  for (std::int64_t n = 1; n <= 100; ++n) {
    bridge::Feedback feedback;
    feedback.sequence = n;
    EXPECT_TRUE(port_->tell(feedback, bridge::State::Hold));
    port_->flush();
    ASSERT_TRUE(wait_until([&] { return publisher.poll(10ms) && publisher.feedback(); }));
    EXPECT_EQ(publisher.feedback()->sequence, ++heard);
  }
  EXPECT_EQ(publisher.feedback()->state, status_v1_t::HOLD);
  EXPECT_EQ(port_->counters().feedback_dropped, 0u);
}

TEST_F(Lcm, WhatTheTellingThreadCannotTakeIsDroppedAndCounted) {
  const bridge::Event event;
  std::size_t refused = 0;
  for (int n = 0; n < 1000; ++n) refused += port_->tell(event) ? 0u : 1u;  // nobody was woken
  EXPECT_GT(refused, 0u);
  EXPECT_EQ(port_->counters().events_dropped, refused);
}

TEST_F(Lcm, TheLoopsSideAllocatesNothing) {
  const bridge::Feedback feedback;
  const bridge::Event event;
  const bridge::Status status;
  const test::AllocationGuard guard;
  for (int n = 0; n < 50; ++n) {
    port_->tell(feedback, bridge::State::Run);
    port_->tell(event);
    port_->tell(status);
    port_->flush();
    port_->take_setpoints(setpoints_);
    port_->take_commands(commands_);
  }
  EXPECT_EQ(guard.allocations(), 0);
}

TEST_F(Lcm, ARouteOnLoopbackGivesNoWarning) { EXPECT_EQ(route_warning(kDefaultUrl), ""); }

class Url : public testing::TestWithParam<std::pair<const char*, const char*>> {};
TEST_P(Url, ThatStaysHereIsTakenAndTheOthersNeedLeave) {
  const auto [given, kept] = GetParam();
  EXPECT_EQ(checked_url(given, true), given);
  if (kept != nullptr) {
    EXPECT_EQ(checked_url(given, false), kept);
  } else {
    EXPECT_THROW(checked_url(given, false), std::invalid_argument);
  }
}
INSTANTIATE_TEST_SUITE_P(
    Urls, Url,
    testing::Values(std::pair{"udpm://239.255.76.67:7667?ttl=0", "udpm://239.255.76.67:7667?ttl=0"},
                    std::pair{"udpm://239.255.76.67:7667", "udpm://239.255.76.67:7667?ttl=0"},
                    std::pair{"udpm://?recv_buf_size=1000", "udpm://?recv_buf_size=1000&ttl=0"},
                    std::pair{"udpm://239.255.76.67:7667?recv_buf_size=1000&ttl=0",
                              "udpm://239.255.76.67:7667?recv_buf_size=1000&ttl=0"},
                    std::pair{"memq://", "memq://"},
                    std::pair<const char*, const char*>{"udpm://239.255.76.67:7667?ttl=1", nullptr},
                    std::pair<const char*, const char*>{"udpm://239.255.76.67:7667?ttl=0&ttl=1", nullptr},
                    std::pair<const char*, const char*>{"udpm://239.255.76.67:7667?ttl=00x", nullptr},
                    std::pair<const char*, const char*>{"tcpq://localhost:7700", nullptr},
                    std::pair<const char*, const char*>{"", nullptr}));

}  // namespace
}  // namespace glenoid::lcm_port
