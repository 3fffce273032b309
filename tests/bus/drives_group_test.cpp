// Several drives on one bus, files of drive families, and that two runs are the same to the last bit.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "bus/drives_bench.hpp"
#include "host/bridge/can/memory_bus.hpp"
#include "host/drives/eds.hpp"
#include "host/drives/group.hpp"
#include "host/drives/options.hpp"
#include "host/drives/report.hpp"
#include "support/allocation_guard.hpp"

namespace glenoid::test {
namespace {

/// A memory bus with a master's port and a group of drives.
struct Bus {
  explicit Bus(int drives, std::vector<drives::ScheduledFault> faults = {})
      : master(bus.connect()), port(bus.connect()), group(*port, make(drives), std::move(faults)) {}

  static std::vector<drives::Drive> make(int count) {
    std::vector<drives::Drive> list;
    for (int k = 1; k <= count; ++k)
      list.emplace_back(drives::Profile{}, drives::Placement{static_cast<std::uint8_t>(k)});
    return list;
  }
  void send(std::uint32_t id, std::initializer_list<std::uint8_t> bytes) {
    can::Frame frame;
    frame.id = id;
    frame.size = static_cast<std::uint8_t>(bytes.size());
    std::copy(bytes.begin(), bytes.end(), frame.data.begin());
    bus.set_time(now_ns);
    master->send({&frame, 1});
  }
  void step(std::int64_t ns) {
    now_ns += ns;
    bus.set_time(now_ns);
    group.step(now_ns);
    std::array<can::Received, 64> batch;
    for (std::size_t count = batch.size(); count == batch.size();) {
      count = master->receive(batch);
      for (std::size_t k = 0; k < count; ++k) {
        if (!batch[k].own) heard.push_back(batch[k].frame);
      }
    }
  }

  can::MemoryBus bus;
  std::unique_ptr<can::Port> master, port;
  drives::DriveGroup group;
  std::int64_t now_ns = 0;
  std::vector<can::Frame> heard;
};

/// One session with faults; all frames that the drives sent.
std::vector<can::Frame> session() {
  Bus bus(6, {{100 * kMs, 2, {drives::FaultKind::Drop, 300, 0}}, {150 * kMs, 0, {drives::FaultKind::Emergency, 0, 0}}});
  bus.step(0);
  bus.step(30 * kMs);
  for (std::uint8_t node = 1; node <= 6; ++node) {
    bus.send(0x600U + node, {0x2F, 0x00, 0x18, 2, 1, 0, 0, 0});
  }
  bus.send(0x000, {0x01, 0});
  for (int k = 0; k < 200; ++k) {
    bus.send(0x080, {});
    bus.send(0x201, {0x06, 0x00});
    bus.step(2 * kMs);
  }
  return bus.heard;
}

TEST(DriveGroup, TwoRunsAreTheSameToTheLastBit) {
  const auto first = session(), second = session();
  EXPECT_GT(first.size(), 1000U);
  EXPECT_EQ(first, second);
}

TEST(DriveGroup, AnswersEverySyncOfEveryDrive) {
  Bus bus(16);
  bus.step(0);
  bus.step(30 * kMs);
  for (std::uint8_t node = 1; node <= 16; ++node) bus.send(0x600U + node, {0x2F, 0x00, 0x18, 2, 1, 0, 0, 0});
  bus.send(0x000, {0x01, 0});
  bus.step(kMs);
  bus.heard.clear();
  const AllocationGuard guard;
  bus.heard.reserve(4096);
  const long reserved = guard.allocations();
  for (int k = 0; k < 100; ++k) {
    bus.send(0x080, {});
    bus.step(2 * kMs);
  }
  EXPECT_EQ(guard.allocations(), reserved);
  std::array<int, 17> answers{};
  for (const can::Frame& frame : bus.heard) {
    if ((frame.id & 0x780U) == 0x180) ++answers.at(frame.id & 0x7FU);
  }
  for (std::size_t node = 1; node <= 16; ++node) EXPECT_EQ(answers[node], 100) << node;
  EXPECT_EQ(bus.group.counters().syncs, 100U);
  EXPECT_EQ(bus.group.counters().unanswered_syncs, 0U);
}

TEST(DriveGroup, CountsSyncsThatTheBusDidNotLetItAnswer) {
  Bus bus(6);
  bus.step(0);
  bus.step(30 * kMs);
  for (std::uint8_t node = 1; node <= 6; ++node) bus.send(0x600U + node, {0x2F, 0x00, 0x18, 2, 1, 0, 0, 0});
  bus.send(0x000, {0x01, 0});
  bus.step(kMs);
  for (int k = 0; k < 3; ++k) {
    bus.send(0x080, {});
    bus.bus.set_link(can::Link::Down);
    bus.step(2 * kMs);
    bus.bus.set_link(can::Link::Up);
  }
  EXPECT_EQ(bus.group.counters().unanswered_syncs, 3U);
}

TEST(DriveGroup, RefusesNoneTooManyAndTwins) {
  can::MemoryBus bus;
  const auto port = bus.connect();
  EXPECT_THROW(drives::DriveGroup(*port, {}), std::invalid_argument);
  EXPECT_THROW(drives::DriveGroup(*port, Bus::make(17)), std::invalid_argument);
  std::vector<drives::Drive> twins;
  for (int k = 0; k < 2; ++k) twins.emplace_back(drives::Profile{}, drives::Placement{3});
  EXPECT_THROW(drives::DriveGroup(*port, std::move(twins)), std::invalid_argument);
  EXPECT_THROW(drives::Drive({}, {0}), std::invalid_argument);
  EXPECT_THROW(drives::Drive({}, {128}), std::invalid_argument);
}

class ProfileFile : public testing::TestWithParam<std::filesystem::path> {};
std::vector<std::filesystem::path> profile_files() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(GLENOID_DRIVE_PROFILES)) files.push_back(entry.path());
  return files;
}
INSTANTIATE_TEST_SUITE_P(All, ProfileFile, testing::ValuesIn(profile_files()),
                         [](const auto& given) { return given.param.stem().string(); });

TEST_P(ProfileFile, LoadsBootsAndHasWhatItSays) {
  const drives::Profile profile = drives::load_profile(GetParam());
  EXPECT_EQ(profile.name, GetParam().stem().string());
  DriveBench bench(profile);
  bench.wait(100 * kMs);
  for (const drives::ObjectDefault& object : profile.objects) {
    EXPECT_EQ(bench.upload(object.address.index, object.address.sub).value, object.value);
  }
  for (const drives::Address& address : profile.absent) {
    EXPECT_NE(bench.upload(address.index, address.sub == 0xFF ? std::uint8_t{0} : address.sub).abort, 0U);
  }
  EXPECT_EQ(drives::electronic_data_sheet(profile).find("\n[1006]\n") == std::string::npos,
            bench.upload(0x1006).abort != 0);
}

TEST(ProfileMistakes, AreNamed) {
  const auto reason = [](const std::string& text) -> std::string {
    const auto file = std::filesystem::temp_directory_path() / "glenoid_profile_test.yaml";
    std::ofstream(file) << text;
    try {
      const drives::Drive drive(drives::load_profile(file), {1});
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(reason("name: a\n"), "accepted");
  EXPECT_NE(reason("nmae: a\n").find("unknown key nmae"), std::string::npos);
  EXPECT_NE(reason("mechanics: {inertia_kg_m2: -1}\n").find("must be above 0"), std::string::npos);
  EXPECT_NE(reason("mechanics: {no_load_speed_ratio: 0.5}\n").find("must be above 1"), std::string::npos);
  EXPECT_NE(reason("absent: 5\n").find("absent: must be a list"), std::string::npos);
  EXPECT_NE(reason("mechanics: {inertia_kg_m2: heavy}\n").find("wrong type"), std::string::npos);
  EXPECT_NE(reason("objects: {6007: 3}\n").find("6007h"), std::string::npos);
  EXPECT_NE(reason("objects: {\"5FFFh\": 3}\n").find("no object 5FFFh"), std::string::npos);
  EXPECT_NE(reason("objects: {\"6060h\": 300}\n").find("must be -128 to 127"), std::string::npos);
}

TEST(FaultWords, AreReadAndMistakesAreNamed) {
  const drives::ScheduledFault fault = drives::parse_fault("node=3,at=2.5,kind=bus-off,amount=7,ms=40");
  EXPECT_EQ(fault.node, 3);
  EXPECT_EQ(fault.at_ns, 2'500'000'000);
  EXPECT_EQ(fault.fault.kind, drives::FaultKind::BusOff);
  EXPECT_EQ(fault.fault.amount, 7U);
  EXPECT_EQ(fault.fault.duration_ms, 40U);
  for (const char* wrong :
       {"node=3", "kind=nonsense", "kind=emcy,at=soon", "kind=emcy,node=300", "kind=emcy,when=1", "x"}) {
    EXPECT_THROW(drives::parse_fault(wrong), std::invalid_argument) << wrong;
  }
  for (int k = 0; k < drives::kFaultKinds; ++k) {
    const auto kind = static_cast<drives::FaultKind>(k);
    EXPECT_EQ(drives::fault_kind(drives::name(kind)), kind);
  }
}

}  // namespace
}  // namespace glenoid::test
