#include "glenoid/exoskeleton.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "exo_shoulder.hpp"

namespace glenoid {
namespace {

/// Rotation with angular velocity and acceleration expressed in T.
struct RotationJet {
  Mat3 R;
  Vec3 w, alpha;
};

/// v/|v| with derivatives, in place. The second lacks its part along v, which no angular acceleration needs.
void normalize_jet(Vec3& v, Vec3& dv, Vec3& ddv) noexcept {
  const double f = 1.0 / v.norm();
  v *= f;
  dv *= f;
  const double rate = v.dot(dv);  // of the length, relative
  dv -= rate * v;
  ddv = f * ddv - 2.0 * rate * dv;
}

/// Upper arm from the columns x and z, orthonormalised together with their derivatives so that rates are exact (X4).
Status upper_arm_jet(const PostureJet& posture, RotationJet& out) noexcept {
  Vec3 x = posture.x, dx = posture.dx, ddx = posture.ddx, z = posture.z, dz = posture.dz, ddz = posture.ddz;
  constexpr double kTolerance = 1e-2;  // far above interpolation error, far below a wrong argument
  const double error = std::abs(x.squaredNorm() - 1.0) + std::abs(z.squaredNorm() - 1.0) + std::abs(x.dot(z));
  if (!std::isfinite(error)) return Status::NotFinite;
  if (error > kTolerance) return Status::OutOfRange;
  normalize_jet(z, dz, ddz);
  const double g = x.dot(z), dg = dx.dot(z) + x.dot(dz);
  ddx -= 2.0 * dg * dz + g * ddz;  // the part along z drops out of everything below
  dx -= dg * z + g * dz;
  x -= g * z;
  normalize_jet(x, dx, ddx);
  const Vec3 y = z.cross(x), dy = dz.cross(x) + z.cross(dx);
  out.R << x, y, z;
  out.w = out.R * Vec3(-y.dot(dz), dz.dot(x), dx.dot(y));
  out.alpha = out.R * Vec3(-dy.dot(dz) - y.dot(ddz), ddz.dot(x) + dz.dot(dx), ddx.dot(y) + dx.dot(dy));
  return Status::Ok;
}

/// Rotation of a girdle that carries the base: outer joint about a fixed axis, inner joint about an axis turned by it (X1).
RotationJet girdle_rotation(GirdleOrder order, const GirdleJet& girdle) noexcept {
  const bool protraction_first = order == GirdleOrder::ProtractionFirst;
  const int outer = protraction_first ? 0 : 1, inner = 1 - outer;
  const Mat3 Rp = Eigen::AngleAxisd(girdle.q[0], Vec3::UnitZ()).toRotationMatrix();
  const Mat3 Re = Eigen::AngleAxisd(girdle.q[1], -Vec3::UnitY()).toRotationMatrix();
  const Vec3 o = protraction_first ? Vec3(Vec3::UnitZ()) : Vec3(-Vec3::UnitY());
  const Vec3 i = protraction_first ? Vec3(-Rp.col(1)) : Vec3(Re.col(2));
  RotationJet out;
  out.R = protraction_first ? Rp * Re : Re * Rp;
  out.w = girdle.dq[outer] * o + girdle.dq[inner] * i;
  out.alpha = girdle.ddq[outer] * o + girdle.ddq[inner] * i + girdle.dq[outer] * girdle.dq[inner] * o.cross(i);
  return out;
}

RotationJet base_jet(const ExoModel& model, const GirdleJet& girdle) noexcept {
  if (!model.settings().base_follows_girdle) return {model.R_GB(), Vec3::Zero(), Vec3::Zero()};
  RotationJet out = girdle_rotation(model.settings().girdle_order, girdle);
  out.R = out.R * model.R_GB();
  return out;
}

bool all_finite(const ExoSample& sample) noexcept {
  return sample.q.allFinite() && sample.dq.allFinite() && sample.ddq.allFinite() && sample.length_m.allFinite() &&
         std::isfinite(sample.residual_m) && std::isfinite(sample.margin_rad) && std::isfinite(sample.axis_angle_rate);
}

/// Least signed distance of the shoulder joints from the device's limits, rad.
double shoulder_limit_margin(const ExoSettings& settings, const Vec3& q) noexcept {
  const Vec3 below = q - settings.lower.segment<3>(kShoulder1), above = settings.upper.segment<3>(kShoulder1) - q;
  return std::min(below.minCoeff(), above.minCoeff());
}

bool joint2_positive(const Vec3& q) noexcept {
  const double wrapped = std::remainder(q[1], 2.0 * kPi);
  return wrapped >= 0.0 && wrapped < kPi;
}

}  // namespace

Mat3 exo_base(const ExoModel& model, double protraction, double elevation) noexcept {
  GirdleJet girdle{Vec3(protraction, elevation, 0.0), Vec3::Zero(), Vec3::Zero(), 0.0};
  return base_jet(model, girdle).R;
}

Mat3 exo_upper_arm(const ExoModel& model, const Vec6& q) noexcept {
  const auto& a = model.shoulder().a;
  Mat3 R = exo_base(model, q[kGirdleProtraction], q[kGirdleElevation]);
  for (int i = 0; i < 3; ++i)
    R = R * Eigen::AngleAxisd(q[kShoulder1 + i], a[static_cast<std::size_t>(i)]).toRotationMatrix();
  return R * model.R_LU();
}

Status map_to_exo(const ExoModel& model, ExoBranch branch, const PostureJet& posture, const PointJet& centre,
                  const Vec3& near_q, ExoSample& out) noexcept {
  RotationJet arm;
  if (const Status status = upper_arm_jet(posture, arm); status != Status::Ok) return status;
  GirdleJet girdle;
  girdle_joints(model, centre, girdle);
  const RotationJet base = base_jet(model, girdle);
  const ShoulderGeometry& g = model.shoulder();

  ShoulderState state;
  const Mat3 R_BT = base.R.transpose();
  const Vec3 t = R_BT * (arm.R * g.a3_U), n = R_BT * (arm.R * g.p3_U);
  solve_shoulder(g, branch, t, n, near_q, state);
  const Vec3 w_rel = arm.w - base.w;
  const Vec3 w = R_BT * w_rel, alpha = R_BT * (arm.alpha - base.alpha - base.w.cross(w_rel));
  Vec3 dq, ddq;
  shoulder_rates(g, state, w, alpha, dq, ddq);

  ExoSample sample;
  sample.q << girdle.q.head<2>(), state.q, posture.phi;
  sample.dq << girdle.dq.head<2>(), dq, posture.dphi;
  sample.ddq << girdle.ddq.head<2>(), ddq, posture.ddphi;
  sample.length_m = Vec3(girdle.q[2], girdle.dq[2], girdle.ddq[2]);
  sample.residual_m = girdle.residual_m;
  sample.margin_rad = state.margin_rad;
  sample.singularity_rad = state.singularity_rad;
  sample.axis_angle_rad = state.axis_angle_rad;
  const Vec3 normal = g.a[0].cross(t);  // d cos(angle)/dt = a1.(w x t)
  const double sine = normal.norm();
  sample.axis_angle_rate = sine > 0.0 ? normal.dot(w) / sine : 0.0;
  if (!all_finite(sample)) return Status::NotFinite;
  out = sample;
  return state.margin_rad < -kFeasibleRounding ? Status::ExoInfeasible : Status::Ok;
}

Status choose_branch(const ExoModel& model, const Posture& posture, const Vec3& p_TS,
                     const std::optional<Vec3>& device_q, ExoStart& out) noexcept {
  if (!posture.R_TU.allFinite() || !p_TS.allFinite() || (device_q && !device_q->allFinite())) return Status::NotFinite;
  GirdleJet girdle;
  girdle_joints(model, {p_TS, Vec3::Zero(), Vec3::Zero()}, girdle);
  const Mat3 R_TB = exo_base(model, girdle.q[0], girdle.q[1]);
  const Vec3 near_q = device_q ? *device_q : middle_of_limits(model.settings(), Vec3::Zero());
  ShoulderSolution first, second;
  const Status status = shoulder_joints(model, R_TB, posture.R_TU, ExoBranch::First, near_q, first);
  const Status other = shoulder_joints(model, R_TB, posture.R_TU, ExoBranch::Second, near_q, second);
  if (status == Status::NotFinite || other == Status::NotFinite) return Status::NotFinite;

  bool take_second = false;
  if (device_q) {
    take_second = (second.q - near_q).squaredNorm() < (first.q - near_q).squaredNorm();
  } else {
    const bool first_inside = shoulder_limit_margin(model.settings(), first.q) >= 0.0;
    const bool second_inside = shoulder_limit_margin(model.settings(), second.q) >= 0.0;
    take_second = first_inside == second_inside ? (joint2_positive(second.q) && !joint2_positive(first.q))
                                                : second_inside;
  }
  out.branch = take_second ? ExoBranch::Second : ExoBranch::First;
  out.shoulder_q = take_second ? second.q : first.q;
  out.margin_rad = first.margin_rad;
  return status;
}

}  // namespace glenoid
