#include <gtest/gtest.h>

#include <array>

#include "host/bridge/can/memory_bus.hpp"
#include "support/allocation_guard.hpp"

namespace glenoid::can {
namespace {

Frame numbered(std::uint32_t id, std::uint8_t number = 0) { return {.id = id, .size = 1, .data = {number}}; }

std::vector<Received> all_of(Port& port) {
  std::vector<Received> out(64);
  out.resize(port.receive(out));
  return out;
}

TEST(MemoryBus, EveryPortHearsEveryFrameInOrderAndTheSenderItsEcho) {
  MemoryBus bus;
  const auto a = bus.connect(), b = bus.connect(), c = bus.connect();
  bus.set_time(42);
  const std::array<Frame, 2> frames = {numbered(0x201, 1), numbered(0x080, 2)};
  EXPECT_EQ(a->send(frames), 2u);
  for (Port* port : {a.get(), b.get(), c.get()}) {
    const auto heard = all_of(*port);
    ASSERT_EQ(heard.size(), 2u);
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_EQ(heard[k].frame, frames[k]);
      EXPECT_EQ(heard[k].time_ns, 42);
      EXPECT_EQ(heard[k].own, port == a.get());
    }
  }
  EXPECT_EQ(a->counters().echoed, 2u);
  EXPECT_EQ(b->counters().received, 2u);
}

TEST(MemoryBus, AStalledBusHoldsWhatFitsAndRefusesTheRest) {
  MemoryBus bus({.transmit_queue = 3});
  const auto a = bus.connect(), b = bus.connect();
  bus.stall(true);
  EXPECT_EQ(a->send(std::vector<Frame>(5, numbered(0x201))), 3u);
  EXPECT_EQ(a->counters().refused, 2u);
  EXPECT_EQ(a->outstanding(), 3u);
  EXPECT_TRUE(all_of(*b).empty());
  bus.stall(false);
  EXPECT_EQ(all_of(*b).size(), 3u);
  EXPECT_EQ(a->outstanding(), 0u);
}

TEST(MemoryBus, WhatIsPurgedNeverComesOut) {
  MemoryBus bus;
  const auto a = bus.connect(), b = bus.connect();
  bus.stall(true);
  a->send(std::vector<Frame>(4, numbered(0x201)));
  EXPECT_TRUE(a->purge());
  EXPECT_EQ(a->outstanding(), 0u);
  bus.stall(false);
  EXPECT_TRUE(all_of(*b).empty());
}

TEST(MemoryBus, WithoutTheRightToPurgeItSaysSoAndKeepsTheFrames) {
  MemoryBus bus({.can_purge = false});
  const auto a = bus.connect(), b = bus.connect();
  EXPECT_TRUE(a->purge()) << "nothing is queued";
  bus.stall(true);
  a->send(std::vector<Frame>(4, numbered(0x201)));
  EXPECT_FALSE(a->purge());
  EXPECT_EQ(a->outstanding(), 4u);
}

TEST(MemoryBus, ALinkThatIsDownTakesNothingAndForgetsWhatWaited) {
  MemoryBus bus;
  const auto a = bus.connect(), b = bus.connect();
  bus.stall(true);
  a->send(std::vector<Frame>(4, numbered(0x201)));
  bus.set_link(Link::Down);
  EXPECT_EQ(a->link(), Link::Down);
  EXPECT_EQ(a->send(std::vector<Frame>(1, numbered(0x201))), 0u);
  bus.set_link(Link::Up);
  bus.stall(false);
  EXPECT_TRUE(all_of(*b).empty());
}

TEST(MemoryBus, AReaderThatSleepsLosesTheNewestAndIsTold) {
  MemoryBus bus({.receive_queue = 2});
  const auto a = bus.connect(), b = bus.connect();
  for (std::uint8_t n = 0; n < 5; ++n) a->send(std::vector<Frame>(1, numbered(0x181, n)));
  const auto heard = all_of(*b);
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_EQ(heard[1].frame.data[0], 1);
  EXPECT_EQ(b->counters().overruns, 3u);
}

TEST(MemoryBus, FiltersPassTheirIdsAndErrorFrames) {
  MemoryBus bus;
  const auto a = bus.connect();
  const auto b = bus.connect({.filters = {{0x181}, {0x700, 0x780}}});
  Frame error;
  error.error = true;
  Frame extended = numbered(0x181);
  extended.extended = true;
  const std::vector<Frame> frames = {numbered(0x181), numbered(0x182), numbered(0x77F),
                                     numbered(0x680), extended,        error};
  a->send(frames);
  const auto heard = all_of(*b);
  ASSERT_EQ(heard.size(), 3u);
  EXPECT_EQ(heard[0].frame, frames[0]);
  EXPECT_EQ(heard[1].frame, frames[2]);
  EXPECT_EQ(heard[2].frame, frames[5]);
}

TEST(MemoryBus, ExchangesFramesWithoutAllocation) {
  MemoryBus bus;
  const auto a = bus.connect(), b = bus.connect();
  std::array<Received, 8> room;
  const std::array<Frame, 4> frames = {};
  const test::AllocationGuard guard;
  for (int n = 0; n < 100; ++n) {
    a->send(frames);
    a->receive(room);
    b->receive(room);
  }
  EXPECT_EQ(guard.allocations(), 0);
}

TEST(OpenPort, AMemoryUrlJoinsTheGivenBus) {
  MemoryBus bus;
  const auto a = bus.connect(), b = open_port("memory:", {.memory = &bus});
  a->send(std::vector<Frame>(1, numbered(0x181)));
  EXPECT_EQ(all_of(*b).size(), 1u);
}

class BadUrl : public testing::TestWithParam<const char*> {};
TEST_P(BadUrl, IsRefusedWithTheUrlInTheText) {
  try {
    open_port(GetParam());
    FAIL() << "opened " << GetParam();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find(GetParam()), std::string::npos) << error.what();
  }
}
INSTANTIATE_TEST_SUITE_P(Urls, BadUrl,
                         testing::Values("", "can0", "memory:", "socketcan:", "socketcan:a_name_of_sixteen", "udp:",
                                         "udp:10.0.0.1", "udp:239.74.163", "udp:239.74.163.2:", "udp:239.74.163.2:0",
                                         "udp:239.74.163.2:65536", "udp:239.74.163.2:43113x", "udp:ff15::1"));

TEST(Filters, OfMasterAndDrivesLetEachHearTheOther) {
  MemoryBus bus;
  const std::array<std::uint8_t, 3> nodes = {1, 2, 0x7E};
  const auto master = bus.connect({.filters = master_filters(nodes, 0x7F)});
  const auto drives = bus.connect({.filters = drive_filters(nodes, 0x7F)});
  std::size_t to_drives = 3;  // NMT, SYNC, the master's heartbeat
  master->send(std::vector<Frame>{numbered(0), numbered(0x80), numbered(0x77F)});
  for (const std::uint8_t node : nodes) {
    for (const std::uint32_t base : {0x200u, 0x300u, 0x400u, 0x500u, 0x600u}) {
      to_drives += master->send(std::vector<Frame>{numbered(base + node)});
    }
  }
  EXPECT_EQ(all_of(*drives).size(), to_drives);
  EXPECT_EQ(all_of(*master).size(), to_drives) << "echoes pass the filter too";
  std::size_t to_master = 0;
  for (const std::uint8_t node : nodes) {
    for (const std::uint32_t base : {0x080u, 0x180u, 0x280u, 0x380u, 0x480u, 0x580u, 0x700u}) {
      to_master += drives->send(std::vector<Frame>{numbered(base + node)});
    }
  }
  EXPECT_EQ(all_of(*master).size(), to_master);
  EXPECT_TRUE(all_of(*drives).empty());
}

}  // namespace
}  // namespace glenoid::can
