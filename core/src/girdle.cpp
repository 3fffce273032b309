#include <cmath>

#include "glenoid/exoskeleton.hpp"
#include "glenoid/timing.hpp"

namespace glenoid {
namespace {

struct Polar {
  ScalarJet radius, angle;
};

/// Polar coordinates of the plane point (u, v) with derivatives; at the origin angle and angular rates are 0.
Polar polar(const ScalarJet& u, const ScalarJet& v) noexcept {
  Polar out;
  const double r = std::sqrt(u.value * u.value + v.value * v.value);
  if (!(r > 0.0)) return out;
  const double cosine = u.value / r, sine = v.value / r;
  const double dr = cosine * u.d1 + sine * v.d1;
  const double transverse = cosine * v.d1 - sine * u.d1;
  out.radius = {r, dr, cosine * u.d2 + sine * v.d2 + transverse * transverse / r};
  const double rate = transverse / r;
  out.angle = {std::atan2(v.value, u.value), rate, (cosine * v.d2 - sine * u.d2 - 2.0 * dr * rate) / r};
  return out;
}

ScalarJet coordinate(const PointJet& point, int axis) noexcept {
  return {point.p[axis], point.dp[axis], point.ddp[axis]};
}

/// Point that the drives reach; NoLength keeps the direction here and fixes the length afterwards.
PointJet reached_point(const ExoModel& model, const PointJet& centre) noexcept {
  const Vec3& rest = model.rest_centre();
  switch (model.settings().girdle_drives) {
    case GirdleDrives::Full:
    case GirdleDrives::NoLength:
      return centre;
    case GirdleDrives::VerticalOnly:
      return {Vec3(rest.x(), rest.y(), centre.p.z()), Vec3(0.0, 0.0, centre.dp.z()), Vec3(0.0, 0.0, centre.ddp.z())};
    case GirdleDrives::None:
      break;
  }
  return {rest, Vec3::Zero(), Vec3::Zero()};
}

}  // namespace

void shoulder_centre_jet(const Rhythm& rhythm, const PostureJet& posture, PointJet& out) noexcept {
  RhythmJet jet;
  rhythm.evaluate(posture.z, jet);
  out.p = jet.p_TS;
  out.dp.noalias() = jet.J_z * posture.dz;
  out.ddp.noalias() = jet.J_z * posture.ddz;
  for (int i = 0; i < 3; ++i) out.ddp[i] += posture.dz.dot(jet.H_z[static_cast<std::size_t>(i)] * posture.dz);
}

void girdle_joints(const ExoModel& model, const PointJet& centre, GirdleJet& out) noexcept {
  const PointJet reached = reached_point(model, centre);
  const bool protraction_first = model.settings().girdle_order == GirdleOrder::ProtractionFirst;
  const ScalarJet x = coordinate(reached, 0), y = coordinate(reached, 1), z = coordinate(reached, 2);
  const Polar first = protraction_first ? polar(x, y) : polar(x, z);
  const Polar second = protraction_first ? polar(first.radius, z) : polar(first.radius, y);
  const ScalarJet& protraction = protraction_first ? first.angle : second.angle;
  const ScalarJet& elevation = protraction_first ? second.angle : first.angle;
  ScalarJet length = second.radius;
  out.residual_m = (centre.p - reached.p).norm();
  if (model.settings().girdle_drives == GirdleDrives::NoLength) {
    const double link = model.rest_centre().norm();
    out.residual_m = std::abs(length.value - link);
    length = {link, 0.0, 0.0};
  }
  out.q = Vec3(protraction.value, elevation.value, length.value);
  out.dq = Vec3(protraction.d1, elevation.d1, length.d1);
  out.ddq = Vec3(protraction.d2, elevation.d2, length.d2);
}

Vec3 exo_centre(const ExoModel& model, const Vec6& q, double length_m) noexcept {
  const double cp = std::cos(q[kGirdleProtraction]), sp = std::sin(q[kGirdleProtraction]);
  const double ce = std::cos(q[kGirdleElevation]), se = std::sin(q[kGirdleElevation]);
  if (model.settings().girdle_order == GirdleOrder::ProtractionFirst) return length_m * Vec3(ce * cp, ce * sp, se);
  return length_m * Vec3(ce * cp, sp, se * cp);
}

}  // namespace glenoid
