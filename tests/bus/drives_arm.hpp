#pragma once

// Arms in devices for the tests of the load.

#include <cmath>

#include "host/load/arm_load.hpp"
#include "support/random.hpp"

namespace glenoid::test {

/// An average man in a device of three axes 75 deg apart, the shoulder 17 cm from the trunk's fixed point.
inline load::ArmLoadSettings usual(const Subject& subject = {}) {
  const ScaledArm arm = scale_subject(subject);
  load::ArmLoadSettings settings;
  settings.upper_arm = arm.upper_arm;
  settings.forearm = arm.forearm;
  const double a = 75.0 * kPi / 180.0;
  settings.exo.axes = {Vec3::UnitZ(), Vec3(std::sin(a), 0.0, std::cos(a)), Vec3::UnitZ()};
  settings.girdle_length_m = arm.shoulder_distance_m;
  return settings;
}

inline load::ArmLoadSettings random_device(Random& random) {
  load::ArmLoadSettings settings = usual();
  for (Vec3& axis : settings.exo.axes) axis = random.unit_vector();
  settings.exo.base = random.vector(1.0);
  settings.exo.cuff = random.vector(1.0);
  settings.exo.girdle_order = random.uniform(0, 1) < 0.5 ? GirdleOrder::ProtractionFirst : GirdleOrder::ElevationFirst;
  settings.exo.base_follows_girdle = random.uniform(0, 1) < 0.5;
  return settings;
}

inline Vec6 random6(Random& random, double half_width) {
  Vec6 out;
  for (double& value : out) value = random.uniform(-half_width, half_width);
  return out;
}

/// Kinetic energy of the arm and of a rotor of J at every joint, and potential, J.
inline double total_energy(const load::ArmDynamics& dynamics, const Vec6& x, const Vec6& v, double J) {
  load::Mat6 M;
  Vec6 bias;
  dynamics.evaluate(x, v, M, bias);
  return 0.5 * v.dot(M * v) + 0.5 * J * v.squaredNorm() + dynamics.potential_J(x);
}

}  // namespace glenoid::test
