// The arm as load that couples the drives: its equations against the core's, its energy, and what the joints feel of it.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "glenoid/kinematics.hpp"
#include "glenoid/mass_matrix.hpp"
#include "host/bridge/can/memory_bus.hpp"
#include "host/drives/group.hpp"
#include "host/drives/servo.hpp"
#include "host/load/arm_load.hpp"
#include "support/allocation_guard.hpp"
#include "support/matchers.hpp"
#include "support/random.hpp"

namespace glenoid::test {
namespace {

using load::ArmDynamics;
using load::ArmLoad;
using load::ArmLoadSettings;
using load::Mat6;

constexpr double kDegree = kPi / 180.0;

/// An average man in a device of three axes 75 deg apart, the shoulder 17 cm from the trunk's fixed point.
ArmLoadSettings usual(const Subject& subject = {}) {
  const ScaledArm arm = scale_subject(subject);
  ArmLoadSettings settings;
  settings.upper_arm = arm.upper_arm;
  settings.forearm = arm.forearm;
  const double a = 75.0 * kDegree;
  settings.exo.axes = {Vec3::UnitZ(), Vec3(std::sin(a), 0.0, std::cos(a)), Vec3::UnitZ()};
  settings.girdle_length_m = arm.shoulder_distance_m;
  return settings;
}

ArmLoadSettings random_device(Random& random) {
  ArmLoadSettings settings = usual();
  for (Vec3& axis : settings.exo.axes) axis = random.unit_vector();
  settings.exo.base = random.vector(1.0);
  settings.exo.cuff = random.vector(1.0);
  settings.exo.girdle_order = random.uniform(0, 1) < 0.5 ? GirdleOrder::ProtractionFirst : GirdleOrder::ElevationFirst;
  settings.exo.base_follows_girdle = random.uniform(0, 1) < 0.5;
  return settings;
}

Vec6 random6(Random& random, double half_width) {
  Vec6 out;
  for (double& value : out) value = random.uniform(-half_width, half_width);
  return out;
}

/// First and second derivative at 0 of a smooth curve, of fourth order in the step.
template <class Curve>
void differentiate(const Curve& curve, Vec3& first, Vec3& second) {
  constexpr double h = 1e-3;
  const Vec3 a = curve(-2 * h), b = curve(-h), c = curve(0.0), d = curve(h), e = curve(2 * h);
  first = (a - 8 * b + 8 * d - e) / (12 * h);
  second = (-a + 16 * b - 30 * c + 16 * d - e) / (12 * h * h);
}

PostureJet jet_of(const Vec4& q, const Vec4& v) {
  const auto column = [&](int k) {
    return [&, k](double t) { return Vec3(posture_from_angles(q + t * v).R_TU.col(k)); };
  };
  PostureJet jet;
  jet.x = column(0)(0.0);
  jet.z = column(2)(0.0);
  differentiate(column(0), jet.dx, jet.ddx);
  differentiate(column(2), jet.dz, jet.ddz);
  jet.phi = q[kPhi];
  jet.dphi = v[kPhi];
  jet.ddphi = 0.0;
  return jet;
}

TEST(ArmDynamics, PulledBackThroughTIsTheMassMatrixAndTheCoriolisVectorOfTheArm) {
  Random random(41);
  int seen = 0;
  for (int k = 0; k < 200; ++k) {
    ArmLoadSettings settings = usual();
    settings.exo.base = random.vector(0.5);
    settings.gravity_m_per_s2 = 0.0;
    const Vec4 q = random_angles(random, {0.2, 2.6, 0.1, 2.4}), v = random.vector4(2.0);
    // A shoulder that stands still: then the arm's own coordinates and the device's say the same.
    RhythmSettings fixed;
    fixed.model = RhythmModel::Fixed;
    const ArmModel arm = make_arm_model({settings.upper_arm, settings.forearm, settings.girdle_length_m, {}},
                                        Rhythm(fixed, settings.girdle_length_m), JointLimits(), true);
    const Vec3 centre = arm.rhythm.position(Vec3::UnitZ());
    const ExoModel exo(settings.exo, centre);
    const PointJet still{centre, Vec3::Zero(), Vec3::Zero()};
    const auto sampled = [&](const Vec4& rates, ExoSample& out) {
      return map_to_exo(exo, ExoBranch::First, jet_of(q, rates), still, Vec3::Zero(), out);
    };
    ExoSample along;
    if (sampled(v, along) != Status::Ok || along.singularity_rad < 0.2) continue;
    Eigen::Matrix<double, 6, 4> T;
    for (int i = 0; i < 4; ++i) {
      ExoSample one;
      ASSERT_EQ(sampled(Vec4::Unit(i), one), Status::Ok);
      T.col(i) = one.dq;
    }
    Mat6 M;
    Vec6 bias;
    ArmDynamics(settings).evaluate(along.q, along.dq, M, bias);
    // Differences of fourth order: 1e-3^4 / 30 of the fifth derivative, and rounding 2e-16 / 1e-6, over sin(0.2) twice.
    EXPECT_TRUE(near(T.transpose() * M * T, mass_matrix(arm, q), 1e-9));
    EXPECT_TRUE(near(T.transpose() * (M * along.ddq + bias), coriolis_vector(arm, q, v), 1e-6));
    ++seen;
  }
  EXPECT_GT(seen, 50);
}

/// Kinetic energy of the segments from positions a short time before and after, J.
double energy_of_points(const ArmLoadSettings& settings, const Vec6& x, const Vec6& v) {
  const ExoModel exo(settings.exo, Vec3(settings.girdle_length_m, 0.0, 0.0));
  constexpr double h = 1e-4;
  double energy = 0.0;
  const auto place = [&](double t, bool forearm, const Vec3& own) -> Vec3 {
    const Vec6 at = x + t * v;
    const Mat3 R_TU = exo_upper_arm(exo, at);
    const Vec3 centre = exo_centre(exo, at, settings.girdle_length_m);
    if (!forearm) return centre + R_TU * own;
    return centre - settings.upper_arm.length_m * R_TU.col(2) +
           R_TU * (Eigen::AngleAxisd(at[kElbow], Vec3::UnitX()) * own);
  };
  for (const bool forearm : {false, true}) {
    const Segment& s = forearm ? settings.forearm : settings.upper_arm;
    // Six equal points on the principal axes have the moments of the segment: r_x^2 = 3 (I_y + I_z - I_x) / (2 m).
    const Vec3& I = s.inertia_kg_m2;
    const Vec3 square = 1.5 / s.mass_kg * Vec3(I.y() + I.z() - I.x(), I.x() + I.z() - I.y(), I.x() + I.y() - I.z());
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        const Vec3 own = Vec3(0.0, 0.0, -s.com_m) + sign * std::sqrt(square[axis]) * Vec3::Unit(axis);
        const Vec3 speed = (place(h, forearm, own) - place(-h, forearm, own)) / (2.0 * h);
        energy += 0.5 * s.mass_kg / 6.0 * speed.squaredNorm();
      }
    }
  }
  return energy;
}

TEST(ArmDynamics, EnergyIsThatOfPointMassesOnTheDevicesForwardKinematics) {
  Random random(42);
  for (int k = 0; k < 100; ++k) {
    const ArmLoadSettings settings = random_device(random);
    const Vec6 x = random6(random, 1.5), v = random6(random, 1.0);
    Mat6 M;
    Vec6 bias;
    ArmDynamics(settings).evaluate(x, v, M, bias);
    const double energy = 0.5 * v.dot(M * v);
    // Central differences: h^2 / 6 of a third derivative below 6^3 (six joints at 1 rad/s), relative.
    EXPECT_NEAR(energy, energy_of_points(settings, x, v), 1e-8 / 6.0 * 216.0 * (1.0 + energy));
    EXPECT_TRUE(near(M, M.transpose(), 0.0));
  }
}

TEST(ArmDynamics, WeightIsTheGradientOfThePotential) {
  Random random(43);
  for (int k = 0; k < 100; ++k) {
    const ArmLoadSettings settings = random_device(random);
    const ArmDynamics dynamics(settings);
    const Vec6 x = random6(random, 1.5);
    Mat6 M;
    Vec6 weight;
    dynamics.evaluate(x, Vec6::Zero(), M, weight);
    constexpr double h = 1e-5;
    for (int i = 0; i < 6; ++i) {
      const Vec6 step = h * Vec6::Unit(i);
      const double slope = (dynamics.potential_J(x + step) - dynamics.potential_J(x - step)) / (2.0 * h);
      EXPECT_NEAR(weight[i], slope, 1e-8);  // h^2 / 6 of 20 J, and rounding 1e-15 * 20 J / h
    }
  }
}

/// Acceleration of the unpowered mechanism with a rotor of J at every joint.
Vec6 free_acceleration(const ArmDynamics& dynamics, const Vec6& x, const Vec6& v, double J) {
  Mat6 M;
  Vec6 bias;
  dynamics.evaluate(x, v, M, bias);
  return (M + J * Mat6::Identity()).llt().solve(-bias);
}

double total_energy(const ArmDynamics& dynamics, const Vec6& x, const Vec6& v, double J) {
  Mat6 M;
  Vec6 bias;
  dynamics.evaluate(x, v, M, bias);
  return 0.5 * v.dot(M * v) + 0.5 * J * v.squaredNorm() + dynamics.potential_J(x);
}

TEST(ArmDynamics, FreeMotionUnderGravityKeepsItsEnergy) {
  Random random(44);
  constexpr double J = 0.15;
  for (int k = 0; k < 10; ++k) {
    const ArmDynamics dynamics(random_device(random));
    Vec6 x = random6(random, 1.0), v = random6(random, 1.0);
    const double before = total_energy(dynamics, x, v, J);
    constexpr double h = 1e-3;
    for (int n = 0; n < 1000; ++n) {  // Runge and Kutta's fourth order
      const Vec6 a1 = free_acceleration(dynamics, x, v, J), v2 = v + 0.5 * h * a1;
      const Vec6 a2 = free_acceleration(dynamics, x + 0.5 * h * v, v2, J), v3 = v + 0.5 * h * a2;
      const Vec6 a3 = free_acceleration(dynamics, x + 0.5 * h * v2, v3, J), v4 = v + h * a3;
      const Vec6 a4 = free_acceleration(dynamics, x + h * v3, v4, J);
      x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
      v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
    // h^4 over 1 s at rates of some rad/s: (h w)^4 w with w = 10 rad/s, of 10 J.
    EXPECT_NEAR(total_energy(dynamics, x, v, J), before, 1e-6);
  }
}

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
