// One suite for every bus between sockets: UDP multicast always, a CAN interface where there is one.

#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "bus/wires_network.hpp"
#include "host/bridge/can/error_frame.hpp"
#include "host/bridge/can/open_port.hpp"
#include "support/allocation_guard.hpp"
#include "support/random.hpp"

namespace glenoid::can {
namespace {

namespace test = glenoid::test;

using namespace std::chrono_literals;
using Heard = std::vector<Received>;

constexpr auto kSafety = 5s;  // nothing here takes a hundredth of it

std::string vcan() {
  const char* given = std::getenv("GLENOID_VCAN");
  return given != nullptr ? given : "vcan0";
}

Frame numbered(std::uint32_t id, std::uint8_t number = 0) { return {.id = id, .size = 1, .data = {number}}; }

/// Reads until `enough` frames are there or the safety time is over.
Heard read(Port& port, std::size_t enough) {
  Heard out;
  std::array<Received, 16> room;
  const auto end = std::chrono::steady_clock::now() + kSafety;
  while (out.size() < enough && std::chrono::steady_clock::now() < end) {
    pollfd wait = {port.descriptor(), POLLIN, 0};
    ::poll(&wait, 1, 50);
    const std::size_t count = port.receive(room);
    out.insert(out.end(), room.begin(), room.begin() + static_cast<std::ptrdiff_t>(count));
  }
  return out;
}

std::int64_t now_ns() { return std::chrono::steady_clock::now().time_since_epoch().count(); }

class Bus : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (std::string(GetParam()) == "udp") {
      if (const std::string why = test::own_network(); !why.empty()) GTEST_SKIP() << why;
      url_ = "udp:239.74.163.2";
    } else {
      url_ = "socketcan:" + vcan();
      try {
        open_port(url_);
      } catch (const std::runtime_error& error) {
        GTEST_SKIP() << error.what();
      }
      ASSERT_TRUE(is_virtual(url_)) << url_ << " may have drives on it: name a vcan interface in GLENOID_VCAN";
    }
  }
  [[nodiscard]] std::unique_ptr<Port> open(const PortOptions& options = {}) const { return open_port(url_, options); }

  std::string url_;
};
INSTANTIATE_TEST_SUITE_P(Kinds, Bus, testing::Values("udp", "socketcan"),
                         [](const auto& kind) { return std::string(kind.param); });

TEST_P(Bus, CarriesFramesInOrderToAllAndEchoesThem) {
  const auto a = open(), b = open();
  std::vector<Frame> frames;
  for (std::uint8_t n = 0; n < 100; ++n) frames.push_back(numbered(0x181, n));  // more than one system call takes
  ASSERT_EQ(a->send(frames), frames.size());
  for (Port* port : {a.get(), b.get()}) {
    const Heard heard = read(*port, frames.size());
    ASSERT_EQ(heard.size(), frames.size());
    for (std::size_t k = 0; k < frames.size(); ++k) {
      EXPECT_EQ(heard[k].frame, frames[k]);
      EXPECT_EQ(heard[k].own, port == a.get());
    }
  }
  EXPECT_EQ(a->outstanding(), 0u);
  EXPECT_EQ(a->counters().echoed, frames.size());
  EXPECT_EQ(a->counters().received, 0u);
  EXPECT_EQ(b->counters().received, frames.size());
}

TEST_P(Bus, KeepsEveryKindOfFrame) {
  const auto a = open(), b = open();
  const std::vector<Frame> frames = {
      {.id = 0, .size = 0},
      {.id = 0x7FF, .size = 8, .data = {1, 2, 3, 4, 5, 6, 7, 8}},
      {.id = 0x7FF, .size = 2, .extended = true, .data = {0xFF}},
      {.id = 0x1FFFFFFF, .size = 8, .extended = true},
      {.id = 0x181, .size = 4, .remote = true},
  };
  a->send(frames);
  const Heard heard = read(*b, frames.size());
  ASSERT_EQ(heard.size(), frames.size());
  for (std::size_t k = 0; k < frames.size(); ++k) EXPECT_EQ(heard[k].frame, frames[k]);
}

TEST_P(Bus, StampsReceptionOnTheMonotonicClock) {
  const auto a = open(), b = open();
  constexpr auto kWaits = 20ms;
  constexpr std::int64_t kHalf_ns = 10'000'000;
  // The kernel begins to stamp some time after the first socket asked for it; before that it stamps what is read.
  bool stamped_at_arrival = false;
  for (int n = 0; n < 50 && !stamped_at_arrival; ++n) {
    const std::int64_t before = now_ns();
    a->send(std::array{numbered(0x80)});
    const std::int64_t sent = now_ns();
    std::this_thread::sleep_for(kWaits);  // the frame waits: its stamp must not be the time of reading
    stamped_at_arrival = true;
    for (Port* port : {a.get(), b.get()}) {
      const Heard heard = read(*port, 1);
      ASSERT_EQ(heard.size(), 1u);
      // The stamp is taken on the wall clock and moved by the difference of two clocks read one after the other; half of
      // the wait is for an interruption between the two.
      EXPECT_GE(heard[0].time_ns, before - kHalf_ns);
      EXPECT_LE(heard[0].time_ns, now_ns());
      stamped_at_arrival = stamped_at_arrival && heard[0].time_ns <= sent + kHalf_ns;
    }
  }
  EXPECT_TRUE(stamped_at_arrival);
}

TEST_P(Bus, GivesOwnAndForeignFramesInTheOrderOfTime) {
  const auto a = open(), b = open();
  for (const auto& [port, id] : {std::pair{&a, 1u}, {&b, 2u}, {&a, 3u}, {&b, 4u}}) {
    (*port)->send(std::array{numbered(0x180 + id)});
    std::this_thread::sleep_for(20ms);  // more than two readings of clocks may lie apart
  }
  const Heard heard = read(*a, 4);
  ASSERT_EQ(heard.size(), 4u);
  for (std::uint32_t k = 0; k < 4; ++k) {
    EXPECT_EQ(heard[k].frame.id, 0x181u + k);
    EXPECT_EQ(heard[k].own, k % 2 == 0);
  }
}

TEST_P(Bus, SplitsBatchesOfFramesOfAnyLength) {
  const auto a = open(), b = open();
  test::Random random(73);
  std::vector<Frame> frames;
  for (int n = 0; n < 200; ++n) {
    const auto size = static_cast<std::uint8_t>(random.uniform(0.0, 8.99));
    frames.push_back({.id = static_cast<std::uint32_t>(random.uniform(0.0, 2047.0)), .size = size});
    for (std::size_t k = 0; k < size; ++k) frames.back().data[k] = static_cast<std::uint8_t>(n + static_cast<int>(k));
    if (n % 3 == 0) frames.insert(frames.end(), 6, frames.back());  // runs of one length
  }
  ASSERT_EQ(a->send(frames), frames.size());
  const Heard heard = read(*b, frames.size());
  ASSERT_EQ(heard.size(), frames.size());
  for (std::size_t k = 0; k < frames.size(); ++k) EXPECT_EQ(heard[k].frame, frames[k]) << k;
}

TEST_P(Bus, FiltersInFrontOfTheReader) {
  const auto a = open();
  const auto b = open({.filters = {{0x181}, {0x700, 0x780}}});
  a->send(std::vector<Frame>{numbered(0x182), numbered(0x181), numbered(0x601), numbered(0x77F)});
  const Heard heard = read(*b, 2);
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_EQ(heard[0].frame.id, 0x181u);
  EXPECT_EQ(heard[1].frame.id, 0x77Fu);
  EXPECT_EQ(b->counters().received, 2u);
}

TEST_P(Bus, CountsEchoesThatNobodyWantsToSee) {
  const auto a = open({.echo = false}), b = open();
  a->send(std::vector<Frame>(5, numbered(0x201)));
  ASSERT_EQ(read(*b, 5).size(), 5u);
  b->send(std::array{numbered(0x181)});
  const Heard heard = read(*a, 1);
  ASSERT_EQ(heard.size(), 1u);
  EXPECT_EQ(heard[0].frame.id, 0x181u);
  EXPECT_EQ(a->counters().echoed, 5u);
  EXPECT_EQ(a->outstanding(), 0u);
}

TEST_P(Bus, TellsHowManyFramesWereLostBecauseNobodyRead) {
  const auto a = open(), b = open({.receive_buffer_bytes = 4096});
  std::size_t sent = 0;
  for (int n = 0; n < 40; ++n) {
    sent += a->send(std::vector<Frame>(50, numbered(0x181)));
    read(*a, 50);  // its own echoes
  }
  Heard heard = read(*b, 1);
  a->send(std::array{numbered(0x182)});  // the kernel tells the count with the next frame
  ++sent;
  const Heard last = read(*b, 1);
  const PortCounters counters = b->counters();
  EXPECT_GT(counters.overruns, 0u);
  EXPECT_EQ(counters.received + counters.overruns, sent);
}

TEST_P(Bus, DeliversErrorFramesPastTheFilter) {
  const auto a = open();
  const auto b = open({.filters = {{0x181}}});
  a->send(std::array{make_error(ControllerState::Off, 255, 0)});
  const Heard heard = read(*b, 1);
  ASSERT_EQ(heard.size(), 1u);
  EXPECT_EQ(decode_error(heard[0].frame).state, ControllerState::Off);
}

TEST_P(Bus, ExchangesFramesWithoutAllocation) {
  const auto a = open(), b = open();
  std::array<Received, 32> room;
  const std::array<Frame, 7> frames = {};
  a->send(frames);
  read(*b, 7);
  const test::AllocationGuard guard;
  for (int n = 0; n < 50; ++n) {
    a->send(frames);
    a->receive(room);
    b->receive(room);
  }
  EXPECT_EQ(guard.allocations(), 0);
}

TEST_P(Bus, HasNothingToReadWhereNothingWasSent) {
  const auto a = open();
  std::array<Received, 4> room;
  EXPECT_EQ(a->receive(room), 0u);
  EXPECT_EQ(a->link(), Link::Up);
  EXPECT_TRUE(a->purge());
}

// What only SocketCAN has: an interface that can go. The test's own one, so that nobody else's is switched off.
class Interface : public testing::Test {
 protected:
  void SetUp() override {
    if (!run("ip link add " + name_ + " type vcan 2>/dev/null"))
      GTEST_SKIP() << "may not make a vcan interface, or no CAN";
    made_ = true;
    ASSERT_TRUE(run("ip link set " + name_ + " up"));
    ASSERT_TRUE(is_virtual(url_));
  }
  void TearDown() override {
    if (made_) run("ip link del " + name_);
  }

  static bool run(const std::string& command) { return std::system(command.c_str()) == 0; }

  const std::string name_ = "glv" + std::to_string(::getpid());
  const std::string url_ = "socketcan:" + name_;
  bool made_ = false;
};

TEST_F(Interface, SwitchedOffIsDownRefusesAndComesBack) {
  const auto a = open_port(url_);
  std::array<Received, 4> room;
  ASSERT_TRUE(run("ip link set " + name_ + " down"));
  EXPECT_EQ(a->send(std::array{numbered(0x201)}), 0u);
  EXPECT_EQ(a->link(), Link::Down);
  EXPECT_EQ(a->counters().refused, 1u);
  a->receive(room);
  EXPECT_EQ(a->link(), Link::Down);
  ASSERT_TRUE(run("ip link set " + name_ + " up"));
  a->receive(room);
  EXPECT_EQ(a->link(), Link::Up);
  EXPECT_EQ(a->send(std::array{numbered(0x201)}), 1u);
  EXPECT_EQ(read(*a, 1).size(), 1u);
}

TEST_F(Interface, SwitchedOffIsSeenByAReaderThatSendsNothing) {
  const auto a = open_port(url_);
  ASSERT_TRUE(run("ip link set " + name_ + " down"));
  std::array<Received, 4> room;
  a->receive(room);
  EXPECT_EQ(a->link(), Link::Down);
}

TEST_F(Interface, RemovedIsGoneAndItsSuccessorIsJoined) {
  const auto a = open_port(url_);
  std::array<Received, 4> room;
  if (!run("ip link del " + name_)) GTEST_SKIP() << "may not remove " << name_;
  a->receive(room);
  EXPECT_EQ(a->send(std::array{numbered(0x201)}), 0u);
  EXPECT_EQ(a->link(), Link::Gone);
  ASSERT_TRUE(run("ip link add " + name_ + " type vcan && ip link set " + name_ + " up"));
  a->receive(room);
  EXPECT_EQ(a->link(), Link::Up);
  const auto b = open_port(url_);
  b->send(std::array{numbered(0x181)});
  EXPECT_EQ(read(*a, 1).size(), 1u);
}

// A vcan that was loaded with echo=1 sends frames through the queue of the interface, where netem holds them: a bus on which
// nobody acknowledges.
class StalledInterface : public Interface {
 protected:
  void SetUp() override {
    Interface::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    std::ifstream parameter("/sys/module/vcan/parameters/echo");
    if (parameter.get() != 'Y') GTEST_SKIP() << "vcan is not loaded with echo=1";
    ASSERT_TRUE(run("ip link set " + name_ + " txqueuelen 20"));
    if (!run("tc qdisc add dev " + name_ + " root netem delay 2s limit 10")) GTEST_SKIP() << "no netem";
  }
};

TEST_F(StalledInterface, HoldsFramesThatCountAsOutstandingAndRefusesTheRest) {
  const auto a = open_port(url_);
  const std::size_t taken = a->send(std::vector<Frame>(30, numbered(0x201)));
  EXPECT_LT(taken, 30u);
  EXPECT_EQ(a->outstanding(), taken);
  EXPECT_EQ(a->counters().refused, 30 - taken);
}

TEST_F(StalledInterface, SendsNothingAfterAPurge) {
  const auto a = open_port(url_), b = open_port(url_);
  ASSERT_GT(a->send(std::vector<Frame>(5, numbered(0x201))), 0u);
  EXPECT_TRUE(a->purge());
  EXPECT_EQ(a->outstanding(), 0u);
  EXPECT_EQ(a->link(), Link::Up);
  std::this_thread::sleep_for(2500ms);  // longer than the bus holds frames
  std::array<Received, 16> room;
  EXPECT_EQ(b->receive(room), 0u);
}

}  // namespace
}  // namespace glenoid::can
