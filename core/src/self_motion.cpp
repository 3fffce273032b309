#include "self_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace glenoid {
namespace {

/// Forearm vector w - X(u) - l_u u and its derivative with respect to u.
struct Reach {
  Vec3 v;
  Mat3 dv_du;
  RhythmJet shoulder;
};

void evaluate_reach(const ArmModel& arm, const Vec3& wrist, const Vec3& u, Reach& r) {
  arm.rhythm.evaluate(-u, r.shoulder);
  r.v = wrist - r.shoulder.p_TS - arm.upper_arm.length_m * u;
  r.dv_du = r.shoulder.J_z - arm.upper_arm.length_m * Mat3::Identity();
}

void tangent_basis(const Vec3& u, Vec3& e1, Vec3& e2) {
  int k = 0;
  u.cwiseAbs().minCoeff(&k);
  e1 = (Vec3::Unit(k) - u * u[k]).normalized();
  e2 = u.cross(e1);
}

/// Minimises the elbow-wrist distance over u from a start: Newton on the sphere with halved steps.
/// @return whether it converged to a local minimum.
bool most_stretched(const ArmModel& arm, const Vec3& wrist, Vec3& u, double& distance) {
  Reach r;
  evaluate_reach(arm, wrist, u, r);
  double value = r.v.squaredNorm();
  for (int it = 0; it < 60; ++it) {
    Vec3 e1, e2;
    tangent_basis(u, e1, e2);
    Eigen::Matrix<double, 3, 2> T;
    T << e1, e2;
    const Eigen::Matrix<double, 3, 2> A = r.dv_du * T;
    const Eigen::Vector2d g = A.transpose() * r.v;
    Mat3 K = Mat3::Zero();
    for (int i = 0; i < 3; ++i) K -= r.v[i] * r.shoulder.H_z[static_cast<std::size_t>(i)];
    Eigen::Matrix2d H = A.transpose() * A + T.transpose() * K * T;
    const double radial = -r.v.dot(r.dv_du * u);
    H.diagonal().array() += radial;
    if (!(H(0, 0) > 0.0) || !(H.determinant() > 0.0)) {
      H = A.transpose() * A;
      H.diagonal().array() += std::abs(radial) + 1e-3;
    }
    const Eigen::Vector2d step = -(H.inverse() * g);
    if (step.norm() < 1e-12) break;
    double scale = std::min(1.0, 0.5 / step.norm());
    bool lower = false;
    for (int half = 0; half < 30 && !lower; ++half, scale *= 0.5) {
      const Vec3 next = (u + scale * (T * step)).normalized();
      Reach trial;
      evaluate_reach(arm, wrist, next, trial);
      if (trial.v.squaredNorm() < value) {
        u = next;
        r = trial;
        value = trial.v.squaredNorm();
        lower = true;
      }
    }
    if (!lower) break;  // at the rounding level
  }
  distance = std::sqrt(value);
  return std::isfinite(distance);
}

/// Metres inside the reach, with u turned from where it is to the direction in which the arm is most stretched; infinite where
/// there is none. `stretch_margin`: of its far side alone.
double reach_margin(const ArmModel& arm, const Vec3& wrist, Vec3& u, double& stretch_margin) {
  double distance = 0.0;
  if (!most_stretched(arm, wrist, u, distance)) return -std::numeric_limits<double>::infinity();
  Reach folded;
  evaluate_reach(arm, wrist, -u, folded);
  stretch_margin = arm.forearm.length_m - distance;
  return std::min(stretch_margin, folded.v.norm() - arm.forearm.length_m);
}

bool inside_known_loop(const ArmModel& arm, const Vec3& wrist, const SelfMotion& found, const Vec3& u) {
  for (int i = 0; i < found.count; ++i) {
    const SelfMotionLoop& loop = found.loops[static_cast<std::size_t>(i)];
    if ((u - loop.centre).norm() < 1e-6) return true;
    const double psi = std::atan2(u.dot(loop.e2), u.dot(loop.e1));
    double opening = 0.0;
    Posture p;
    const double angle = std::atan2(u.cross(loop.centre).norm(), u.dot(loop.centre));
    if (loop_posture(arm, wrist, loop, psi, opening, p) && angle < opening) return true;
  }
  return false;
}

}  // namespace

double reach_margin_near(const ArmModel& arm, const Vec3& wrist, Vec3 u) noexcept {
  double stretch_margin = 0.0;
  return reach_margin(arm, wrist, u, stretch_margin);
}

void find_self_motion(const ArmModel& arm, const Vec3& wrist, SelfMotion& out) noexcept {
  constexpr double kFarthest = 1e6;  // m from the thorax; squares of what is farther may overflow
  constexpr double kStartElevations[] = {0.6, 1.3, 2.0, 2.6};  // rad; the shoulder there decides the first direction
  out.count = 0;
  out.reach_margin_m = -wrist.stableNorm();
  if (!(wrist.stableNorm() < kFarthest)) return;
  const bool moves = arm.rhythm.settings().model != RhythmModel::Fixed && arm.rhythm.settings().gain > 0.0;
  for (const double elevation : kStartElevations) {
    Vec3 towards = wrist - arm.rhythm.position(Vec3::UnitZ());
    towards.z() = 0.0;
    towards = towards.norm() > 1e-9 ? Vec3(towards.normalized()) : Vec3(Vec3::UnitY());
    const Vec3 start = std::sin(elevation) * towards - std::cos(elevation) * Vec3::UnitZ();
    const Vec3 chord = wrist - arm.rhythm.position(-start);
    if (!(chord.norm() > 1e-9)) continue;
    Vec3 u = chord.normalized();
    double stretch_margin = 0.0;
    const double margin = reach_margin(arm, wrist, u, stretch_margin);
    if (std::isfinite(margin)) {
      out.reach_margin_m = std::max(out.reach_margin_m, margin);
      if (margin >= 0.0 && out.count < SelfMotion::kMaxLoops && !inside_known_loop(arm, wrist, out, u)) {
        SelfMotionLoop& loop = out.loops[static_cast<std::size_t>(out.count++)];
        loop.centre = u;
        tangent_basis(u, loop.e1, loop.e2);
        loop.stretch_margin_m = stretch_margin;
      }
    }
    if (!moves) break;
  }
}

bool loop_posture(const ArmModel& arm, const Vec3& wrist, const SelfMotionLoop& loop, double psi, double& opening,
                  Posture& out) noexcept {
  const Vec3 ray = std::cos(psi) * loop.e1 + std::sin(psi) * loop.e2;
  const double lf = arm.forearm.length_m;
  double low = 0.0, high = kPi;
  double beta = opening > 0.0 ? opening : 0.5;
  Reach r;
  Vec3 u;
  bool found = false;
  for (int it = 0; it < 80; ++it) {
    const double c = std::cos(beta), s = std::sin(beta);
    u = c * loop.centre + s * ray;
    evaluate_reach(arm, wrist, u, r);
    const double g = r.v.squaredNorm() - lf * lf;
    if (found) break;
    (g < 0.0 ? low : high) = beta;
    const double slope = 2.0 * r.v.dot(r.dv_du * (c * ray - s * loop.centre));
    double next = slope > 0.0 ? beta - g / slope : -1.0;
    // Newton's error after this step is the square of it: one more evaluation at the accepted angle, then done
    found = std::abs(next - beta) < 1e-7 * beta || high - low < 1e-15;
    if (!found && !(next > low && next < high)) next = 0.5 * (low + high);
    beta = next;
  }
  if (std::abs(r.v.norm() - lf) > 1e-9) return false;
  opening = beta;
  const Vec3 c = u.cross(r.v);
  const double bend = c.norm();
  out.phi = std::atan2(bend, u.dot(r.v));
  Vec3 x = bend > 1e-12 * lf ? c : Vec3(ray.cross(loop.centre));
  x -= u * u.dot(x);
  out.R_TU.col(0) = x.normalized();
  out.R_TU.col(2) = -u;
  out.R_TU.col(1) = out.R_TU.col(2).cross(out.R_TU.col(0));
  return true;
}

}  // namespace glenoid
