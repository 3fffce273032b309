// The rig: bridge core and six drives in lock-step, whatever is made to go wrong around them.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "host/rig/rig.hpp"

namespace glenoid::test {
namespace {

using bridge::Request;
using bridge::State;
using rig::DisturbanceKind;

constexpr std::int64_t kMs = 1'000'000, kStart_ns = 1'000'000'000;
constexpr int kReady = 5000;  // cycles that start-up and arming may take

/// Six nominal drives on one bus.
bridge::Config six_drives() { return bridge::load_config(GLENOID_RIG_CONFIG); }

/// A slow swing of all joints from where they stand, for as long as asked.
std::vector<rig::PlannedSetpoint> swing(std::int64_t from_ns, double seconds, std::size_t joints) {
  std::vector<rig::PlannedSetpoint> out;
  const std::int64_t period_ns = 2 * kMs, count = std::llround(seconds * 500.0);
  for (std::int64_t k = 0; k < count; ++k) {
    rig::PlannedSetpoint& planned = out.emplace_back();
    planned.due_ns = planned.setpoint.time_ns = from_ns + k * period_ns;
    planned.setpoint.sequence = k + 1;
    planned.setpoint.count = static_cast<std::int32_t>(joints);
    planned.setpoint.valid_mask = (1 << joints) - 1;
    const double phase = 2.0 * std::numbers::pi * 2e-3 * static_cast<double>(k);
    for (std::size_t j = 0; j < joints; ++j) {
      planned.setpoint.position_rad[j] = 0.02 * (1.0 - std::cos(phase));
      planned.setpoint.velocity_rad_per_s[j] = 0.02 * 2.0 * std::numbers::pi * std::sin(phase);
    }
  }
  return out;
}

/// In motion; half a second of it is still to come.
std::unique_ptr<rig::Rig> in_motion() {
  const bridge::Config config = six_drives();
  auto rig = std::make_unique<rig::Rig>(config, std::vector<rig::DriveSetup>(config.settings.joints.size()),
                                        rig::RigOptions{kStart_ns, 1});
  EXPECT_TRUE(rig->configure(kReady));
  rig->run(5);
  rig->request(Request::Arm);
  EXPECT_TRUE(rig->run_until(State::Ready, kReady));
  rig->play(swing(rig->now_ns(), 1.0, config.settings.joints.size()));
  rig->run(50);
  rig->request(Request::Start);
  EXPECT_TRUE(rig->run_until(State::Run, 100));
  rig->run(150);
  EXPECT_EQ(rig->bridge().state(), State::Run);
  return rig;
}

TEST(Rig, SameCallsGiveTheSameBits) {
  const auto first = in_motion(), second = in_motion();
  const rig::Record &a = first->record(), &b = second->record();
  ASSERT_EQ(a.cycles.size(), b.cycles.size());
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t k = 0; k < a.frames.size(); ++k) {
    ASSERT_EQ(a.frames[k].time_ns, b.frames[k].time_ns);
    ASSERT_TRUE(a.frames[k].frame == b.frames[k].frame) << k;
  }
  for (std::size_t k = 0; k < a.cycles.size(); ++k) ASSERT_EQ(a.cycles[k].position_rad, b.cycles[k].position_rad);
}

TEST(Rig, ClockStandsAtTheNextSyncAndRecordsHaveOneRowACycle) {
  const auto rig = in_motion();
  const std::vector<rig::CycleRecord>& cycles = rig->record().cycles;
  for (std::size_t k = 0; k < cycles.size(); ++k)
    ASSERT_EQ(cycles[k].time_ns, kStart_ns + 2 * kMs * static_cast<std::int64_t>(k));
  EXPECT_EQ(rig->now_ns(), cycles.back().time_ns + 2 * kMs);
}

/// Everything that can be made to happen, and whether the motion may go on.
struct Trouble {
  const char* name;
  DisturbanceKind kind;
  drives::Fault fault;
  bool ends;
};
class RigTrouble : public testing::TestWithParam<Trouble> {};
INSTANTIATE_TEST_SUITE_P(
    Kinds, RigTrouble,
    testing::Values(Trouble{"small_delay", DisturbanceKind::Drive, {drives::FaultKind::Delay, 2000, 0}, false},
                    Trouble{"drop", DisturbanceKind::Drive, {drives::FaultKind::Drop, 500, 0}, true},
                    Trouble{"stall", DisturbanceKind::Drive, {drives::FaultKind::Stall, 0, 0}, true},
                    Trouble{"emergency", DisturbanceKind::Drive, {drives::FaultKind::Emergency, 0x2310, 0}, true},
                    Trouble{"reboot", DisturbanceKind::Drive, {drives::FaultKind::Reboot, 0, 0}, true},
                    Trouble{"bus_off", DisturbanceKind::Drive, {drives::FaultKind::BusOff, 0, 0}, true},
                    Trouble{"drive_heartbeat", DisturbanceKind::DriveHeartbeat, {}, true},
                    Trouble{"master_heartbeat", DisturbanceKind::MasterHeartbeat, {}, true},
                    Trouble{"estop_message", DisturbanceKind::EStopMessage, {}, true},
                    Trouble{"estop_input", DisturbanceKind::EStopInput, {}, true},
                    Trouble{"bus_silent", DisturbanceKind::BusSilent, {}, true},
                    Trouble{"bus_stalled", DisturbanceKind::BusStalled, {}, true},
                    Trouble{"link_down", DisturbanceKind::LinkDown, {}, true}),
    [](const auto& given) { return std::string(given.param.name); });

TEST_P(RigTrouble, EndsTheMotionOrIsBorneAndTheJointsComeToRest) {
  const auto rig = in_motion();
  rig->schedule({GetParam().kind, rig->now_ns(), 300 * kMs, 2, 0, GetParam().fault});
  rig->run(140);
  const bool stopped = rig->bridge().state() == State::Stop || rig->bridge().state() == State::Fault;
  EXPECT_EQ(stopped, GetParam().ends);
  rig->run(500);  // the stream has ended, and so has the trouble
  EXPECT_NE(rig->bridge().state(), State::Run);
  for (std::size_t j = 0; j < six_drives().settings.joints.size(); ++j)
    EXPECT_LT(std::abs(rig->drive(j).view().velocity_rad_per_s), 0.02) << j;
}

}  // namespace
}  // namespace glenoid::test
