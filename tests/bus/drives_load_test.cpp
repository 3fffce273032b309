// What servos and drives feel of the arm: energy, coupling, brakes, refusals.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "bus/drives_arm.hpp"
#include "host/bridge/can/memory_bus.hpp"
#include "host/drives/group.hpp"
#include "host/drives/servo.hpp"
#include "support/allocation_guard.hpp"
#include "support/matchers.hpp"

namespace glenoid::test {
namespace {

using load::ArmDynamics;
using load::ArmLoad;
using load::ArmLoadSettings;
using load::Mat6;

/// Six servos under one arm, without drives and bus.
struct Mechanism {
  explicit Mechanism(const ArmLoadSettings& settings, const Vec6& start) : dynamics(settings), load(settings) {
    drives::Profile profile;
    profile.mechanics.encoder_counts_per_motor_rev = 1U << 28U;  // so that the steps of the encoder do not show
    for (const double q : start) servos.emplace_back(profile, q);
    for (drives::Servo& servo : servos) servo.enable();
    inertia = profile.mechanics.inertia_kg_m2;
  }

  void step(const Vec6& reference, const Vec6& rate, double step_s) {
    for (std::size_t k = 0; k < 6; ++k) states[k] = servos[k].state();
    load.act(states, loads);
    for (std::size_t k = 0; k < 6; ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      servos[k].load(loads[k]);
      servos[k].step(reference[row], rate[row], 0.0, step_s);
      const drives::JointState now = servos[k].state();
      work_J += now.torque_Nm * now.velocity_rad_per_s * step_s;
    }
  }

  [[nodiscard]] double energy_J() const {
    Vec6 x, v;
    for (std::size_t k = 0; k < 6; ++k) {
      x[static_cast<Eigen::Index>(k)] = servos[k].position();
      v[static_cast<Eigen::Index>(k)] = servos[k].velocity();
    }
    return total_energy(dynamics, x, v, inertia);
  }

  ArmDynamics dynamics;
  ArmLoad load;
  std::vector<drives::Servo> servos;
  std::array<drives::JointState, 6> states;
  std::array<drives::JointLoad, 6> loads;
  double inertia = 0.0;
  double work_J = 0.0;  ///< of the motors, less friction
};

/// What is missing in the balance of energy of a swing through a second, J.
double missing_energy(double step_s, double& turned_over) {
  const Vec6 start = (Vec6() << 0.1, 0.1, 0.3, 0.6, -0.5, 0.8).finished();
  const Vec6 way = (Vec6() << -0.2, 0.3, 1.0, 0.5, -0.8, 0.9).finished();
  Mechanism mechanism(usual(), start);
  const double before = mechanism.energy_J();
  turned_over = 0.0;
  const int steps = static_cast<int>(std::lround(1.0 / step_s));
  for (int n = 1; n <= steps; ++n) {
    const double s = n * step_s;
    const Vec6 reference = start + way * (s * s * s * (10.0 - 15.0 * s + 6.0 * s * s));
    mechanism.step(reference, way * (30.0 * s * s * (1.0 - s) * (1.0 - s)), step_s);
    turned_over = std::max(turned_over, std::abs(mechanism.energy_J() - before));
    if (n == steps / 2) return std::abs(mechanism.energy_J() - before - mechanism.work_J);  // in full motion
  }
  return 0.0;
}

TEST(ArmLoad, MotorsDoTheWorkThatTheArmGainsAndFrictionTakes) {
  double turned_over = 0.0;
  const double coarse = missing_energy(drives::kServoStep_s, turned_over);
  const double fine = missing_energy(0.5 * drives::kServoStep_s, turned_over);
  EXPECT_GT(turned_over, 1.0);
  EXPECT_LT(coarse, 0.01 * turned_over);
  EXPECT_LT(fine, 0.7 * coarse);  // the scheme is of first order: halving its step halves what is missing
}

TEST(ArmLoad, JointsWithoutCouplingDoNotFeelEachOther) {
  // Axis 1 vertical, 2 horizontal, 3 along the upper arm; elbow straight, upper arm horizontal. Then a pull on axis 1 from rest
  // accelerates nothing else, while one on axis 2 also turns the elbow, whose axis is parallel.
  ArmLoadSettings settings = usual();
  settings.exo.axes = {Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitZ()};
  settings.gravity_m_per_s2 = 0.0;
  std::array<drives::JointState, 6> states{};
  for (drives::JointState& state : states) state.inertia_kg_m2 = 0.15;
  states[kGirdleProtraction].held = states[kGirdleElevation].held = true;
  states[kShoulder2].position_rad = kPi / 2.0;
  std::array<drives::JointLoad, 6> loads;
  ArmLoad load(settings);
  states[kShoulder1].torque_Nm = 20.0;
  load.act(states, loads);
  for (std::size_t k = kShoulder2; k < 6; ++k) EXPECT_NEAR(loads[k].torque_Nm, 0.0, 1e-9);
  EXPECT_NEAR(loads[kShoulder1].torque_Nm, 0.0, 1e-9);  // and its own inertia is all that it feels
  EXPECT_GT(loads[kShoulder1].inertia_kg_m2, 0.1);
  states[kShoulder1].torque_Nm = 0.0;
  states[kShoulder2].torque_Nm = 20.0;
  load.act(states, loads);
  EXPECT_LT(loads[kElbow].torque_Nm, -1.0);  // left behind
}

TEST(ArmLoad, SignAndOffsetOfTheDrivesChangeNothingAtTheJoints) {
  Random random(45);
  ArmLoadSettings settings = usual();
  std::array<drives::JointState, 6> states;
  std::array<drives::JointLoad, 6> plain, turned;
  for (drives::JointState& s : states)
    s = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-9, 9), 0.15, false};
  ArmLoad(settings).act(states, plain);
  for (std::size_t k = 0; k < 6; ++k) {
    settings.joints[k] = {k % 2 == 0 ? -1.0 : 1.0, 0.1};
    states[k].position_rad = settings.joints[k].sign * (states[k].position_rad - 0.1);
    states[k].velocity_rad_per_s *= settings.joints[k].sign;
    states[k].torque_Nm *= settings.joints[k].sign;
  }
  ArmLoad(settings).act(states, turned);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_NEAR(turned[k].torque_Nm * settings.joints[k].sign, plain[k].torque_Nm, 1e-12);
    EXPECT_NEAR(turned[k].inertia_kg_m2, plain[k].inertia_kg_m2, 1e-14);
  }
}

TEST(ArmLoad, AHeldJointIsAWallForTheOthers) {
  // With joints 1 and 3 free and coupled, joint 1 feels less inertia than with joint 3 held.
  ArmLoadSettings settings = usual();
  std::array<drives::JointState, 6> states{};
  for (drives::JointState& state : states) state.inertia_kg_m2 = 0.15;
  std::array<drives::JointLoad, 6> free, held;
  states[kElbow].position_rad = 1.2;
  states[kShoulder2].position_rad = 0.9;
  ArmLoad load(settings);
  load.act(states, free);
  for (drives::JointState& state : states) state.held = true;
  states[kShoulder1].held = false;
  load.act(states, held);
  Mat6 M;
  Vec6 bias;
  Vec6 x = Vec6::Zero();
  x[kElbow] = 1.2;
  x[kShoulder2] = 0.9;
  ArmDynamics(settings).evaluate(x, Vec6::Zero(), M, bias);
  EXPECT_NEAR(held[kShoulder1].inertia_kg_m2, M(kShoulder1, kShoulder1), 1e-12);
  EXPECT_NEAR(held[kShoulder1].torque_Nm, -bias[kShoulder1], 1e-12);
  EXPECT_LT(free[kShoulder1].inertia_kg_m2, held[kShoulder1].inertia_kg_m2 - 1e-3);
}

TEST(ArmLoad, IsRefusedWithNameValueUnitAndRule) {
  ArmLoadSettings settings = usual();
  settings.girdle_length_m = 170.0;
  EXPECT_TRUE(
      contains(refusal([&] { ArmLoad{settings}; }), "girdle_length_m = 170.000000 m: must be above 0 and below 1"));
  settings = usual();
  settings.exo.girdle_drives = GirdleDrives::VerticalOnly;
  EXPECT_TRUE(contains(refusal([&] { ArmLoad{settings}; }), "VerticalOnly are a slide"));
  settings = usual();
  settings.gravity_m_per_s2 = -1.0;
  EXPECT_TRUE(contains(refusal([&] { ArmLoad{settings}; }), "gravity_m_per_s2"));
}

class CarriedByDrives : public testing::Test {
 protected:
  drives::DriveGroup group_of(std::size_t count) {
    std::vector<drives::Drive> all;
    for (std::size_t k = 0; k < count; ++k)
      all.emplace_back(drives::Profile{}, drives::Placement{static_cast<std::uint8_t>(k + 1), 0.3, 1});
    return {*port_, std::move(all)};
  }
  can::MemoryBus bus_{{32, 4096, true}};
  std::unique_ptr<can::Port> port_ = bus_.connect();
};

TEST_F(CarriedByDrives, NeedsOneDriveAJoint) {
  auto group = group_of(5);
  EXPECT_EQ(refusal([&] { group.carry(std::make_unique<ArmLoad>(usual())); }), "load of 6 joints on 5 drives");
}

TEST_F(CarriedByDrives, BrakesHoldTheArm) {
  auto group = group_of(6);
  group.carry(std::make_unique<ArmLoad>(usual()));
  for (std::int64_t ms = 0; ms < 1000; ++ms) group.step(ms * 1'000'000);
  for (const drives::Drive& drive : group.drives()) EXPECT_EQ(drive.view().position_rad, 0.3);
}

TEST_F(CarriedByDrives, WithoutBrakesTheArmFallsAndAllocatesNothing) {
  drives::Profile profile;
  profile.mechanics.brake = false;
  std::vector<drives::Drive> all;
  for (std::uint8_t node = 1; node <= 6; ++node) all.emplace_back(profile, drives::Placement{node, 0.5, 1});
  drives::DriveGroup group(*port_, std::move(all));
  group.carry(std::make_unique<ArmLoad>(usual()));
  const ArmDynamics dynamics(usual());
  const auto height = [&] {
    Vec6 x;
    for (Eigen::Index k = 0; k < 6; ++k) x[k] = group.drives()[static_cast<std::size_t>(k)].view().position_rad;
    return dynamics.potential_J(x);
  };
  const double before = height();
  group.step(0);
  const AllocationGuard guard;
  for (std::int64_t ms = 1; ms < 500; ++ms) group.step(ms * 1'000'000);
  EXPECT_EQ(guard.allocations(), 0);
  EXPECT_LT(height(), before - 0.1);
}

}  // namespace
}  // namespace glenoid::test
