#include "glenoid/arm_model.hpp"

#include <stdexcept>
#include <string>

namespace glenoid {
namespace {

/// Second moments of mass about the centre of mass along the principal axes (diagonal of the pseudo-inertia).
Vec3 second_moments(const Segment& s, const char* name) {
  const Vec3& I = s.inertia_kg_m2;
  const Vec3 p = 0.5 * Vec3(I.y() + I.z() - I.x(), I.x() + I.z() - I.y(), I.x() + I.y() - I.z());
  if (!(s.length_m > 0.0) || !(s.mass_kg > 0.0) || !(I.minCoeff() > 0.0) || !(p.minCoeff() >= 0.0)) {
    throw std::invalid_argument(std::string(name) +
                                ": length, mass and principal inertias must be > 0 and fulfil the triangle inequality");
  }
  return p;
}

}  // namespace

MassMoments mass_moments(const ArmModel& arm) noexcept {
  const Segment &u = arm.upper_arm, &f = arm.forearm;
  return {u.mass_kg * u.com_m + f.mass_kg * u.length_m, f.mass_kg * f.com_m};
}

double mass_height(const ArmModel& arm, const Posture& posture) noexcept {
  const MassMoments moments = mass_moments(arm);
  const double forearm_z = -std::sin(posture.phi) * posture.R_TU(2, 1) + std::cos(posture.phi) * posture.R_TU(2, 2);
  return -moments.upper * posture.R_TU(2, 2) - moments.forearm * forearm_z;
}

ArmModel make_arm_model(const ScaledArm& arm, const Rhythm& rhythm, const JointLimits& limits, bool moving_shoulder) {
  validate(limits);
  ArmModel model;
  model.upper_arm = arm.upper_arm;
  model.forearm = arm.forearm;
  model.rhythm = rhythm;
  model.limits = limits;
  model.moving_shoulder = moving_shoulder;
  model.turning_kg_m2 = arm.turning_kg_m2;

  const Segment& u = arm.upper_arm;
  const Segment& f = arm.forearm;
  const Vec3 pu = second_moments(u, "upper arm");
  const Vec3 pf = second_moments(f, "forearm");
  auto& M = model.mass;
  const auto pair = [&M](int row, int col, double value) { M(row, col) = M(col, row) = value; };
  M(1, 1) = pu.x() + pf.x();  // x_F = x_U
  M(2, 2) = pu.y();
  M(3, 3) = pu.z() + u.mass_kg * u.com_m * u.com_m + f.mass_kg * u.length_m * u.length_m;
  M(4, 4) = pf.y();
  M(5, 5) = pf.z() + f.mass_kg * f.com_m * f.com_m;
  pair(3, 5, f.mass_kg * u.length_m * f.com_m);
  if (moving_shoulder) {
    M(0, 0) = u.mass_kg + f.mass_kg;
    pair(0, 3, -(u.mass_kg * u.com_m + f.mass_kg * u.length_m));
    pair(0, 5, -f.mass_kg * f.com_m);
  }
  return model;
}

}  // namespace glenoid
