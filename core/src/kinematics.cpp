#include "glenoid/kinematics.hpp"

#include <cmath>

#include <Eigen/Geometry>

#include "glenoid/path.hpp"

namespace glenoid {
Posture posture_from_angles(const Vec4& q) noexcept {
  const double ce = std::cos(q[kEta]), se = std::sin(q[kEta]);
  const double ct = std::cos(q[kTheta]), st = std::sin(q[kTheta]);
  const double cz = std::cos(q[kZeta]), sz = std::sin(q[kZeta]);
  Posture p;
  p.R_TU << ce * cz - se * ct * sz, -ce * sz - se * ct * cz, se * st,  //
      se * cz + ce * ct * sz, -se * sz + ce * ct * cz, -ce * st,       //
      st * sz, st * cz, ct;
  p.phi = q[kPhi];
  return p;
}

Vec4 angles_from_posture(const Posture& posture, const Vec4& near_q) noexcept {
  PostureJet jet{};
  jet.x = posture.R_TU.col(0);
  jet.z = posture.R_TU.col(2);
  jet.dx = jet.ddx = jet.dz = jet.ddz = Vec3::Zero();
  jet.phi = posture.phi;
  Vec4 q, dq, ddq;
  angles_from_jet(jet, near_q, q, dq, ddq);
  return q;
}

double axial_rotation(const Mat3& R_TU) noexcept {
  return std::atan2(R_TU(1, 0) - R_TU(0, 1), R_TU(0, 0) + R_TU(1, 1));
}

ArmPoints forward_kinematics(const ArmModel& arm, const Posture& posture) noexcept {
  ArmPoints p;
  const Vec3 z = posture.R_TU.col(2);
  const Vec3 zf = -std::sin(posture.phi) * posture.R_TU.col(1) + std::cos(posture.phi) * z;
  p.shoulder = arm.rhythm.position(z);
  p.elbow = p.shoulder - arm.upper_arm.length_m * z;
  p.wrist = p.elbow - arm.forearm.length_m * zf;
  return p;
}

Status posture_from_points(const ArmPoints& points, const Mat3& R_near, Posture& out) noexcept {
  const Vec3 r = points.elbow - points.shoulder;
  const Vec3 f = points.wrist - points.elbow;
  if (!r.allFinite() || !f.allFinite()) return Status::NotFinite;
  const double lu = r.norm(), lf = f.norm();
  if (lu <= 0.0 || lf <= 0.0) return Status::OutOfRange;
  const Vec3 z = -r / lu;
  Vec3 c = r.cross(f);
  const double bend = c.norm();
  out.phi = std::atan2(bend, r.dot(f));
  if (bend <= 1e-13 * lu * lf) {
    // straight: the axial rotation of R_near decides
    c = R_near.col(0) - z * z.dot(R_near.col(0));
    if (c.norm() < 1e-6) c = R_near.col(1).cross(z);
  }
  c -= z * z.dot(c);
  out.R_TU.col(0) = c.normalized();
  out.R_TU.col(2) = z;
  out.R_TU.col(1) = z.cross(out.R_TU.col(0));
  return Status::Ok;
}

double swivel_angle(const ArmPoints& points) noexcept {
  const Vec3 reach = points.wrist - points.shoulder;
  const double d = reach.norm();
  if (!(d > 0.0)) return 0.0;
  const Vec3 n = reach / d;
  const Vec3 u = -Vec3::UnitZ() + n * n.z();  // a - (a.n) n with a = -z
  const Vec3 w = u.cross(n);
  const Vec3 elbow = points.elbow - points.shoulder;
  const double up = elbow.dot(u), side = elbow.dot(w);
  return std::hypot(up, side) > 1e-12 * d ? std::atan2(side, up) : 0.0;
}

Vec4 isb_from_angles(const Vec4& q) noexcept { return {q[kEta] + 0.5 * kPi, q[kTheta], q[kZeta] - 0.5 * kPi, q[kPhi]}; }

Vec4 angles_from_isb(const Vec4& isb) noexcept { return {isb[1], isb[0] - 0.5 * kPi, isb[2] + 0.5 * kPi, isb[3]}; }

}  // namespace glenoid
