#include "exo_shoulder.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace glenoid {
namespace {

constexpr double kSharedAxis = 2.5e-13;   // rad: joints 1 and 3 share one axis; R is then off by less than 5e-13
constexpr double kSingularVolume = 1e-6;  // |a1.(b2 x b3)| below which rates are least squares

/// v turned about the unit axis by the angle with cosine c and sine s.
Vec3 turned(const Vec3& axis, double c, double s, const Vec3& v) noexcept {
  return c * v + s * axis.cross(v) + (1.0 - c) * axis.dot(v) * axis;
}

/// Half of the interior angle at a2 of the spherical triangle a1, a2, Rot(a2, q2) a3, by the half-angle formula (X2).
struct HalfAngle {
  double c, s;
};

HalfAngle half_interior_angle(const ShoulderGeometry& g, double sin_half, double cos_half) noexcept {
  const double s2 = (sin_half * g.cos_diff - cos_half * g.sin_diff) * (sin_half * g.cos_diff + cos_half * g.sin_diff);
  const double c2 = (g.sin_sum * cos_half - g.cos_sum * sin_half) * (g.sin_sum * cos_half + g.cos_sum * sin_half);
  const double s = std::sqrt(std::max(s2, 0.0)), c = std::sqrt(std::max(c2, 0.0));
  const double length = std::sqrt(c * c + s * s);  // sqrt(sin a12 sin a23): never small
  return {c / length, s / length};
}

/// Column of least length under J: unit null vector of a Jacobian of rank 2.
Vec3 null_direction(const Mat3& J) noexcept {
  Vec3 best = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    const Vec3 normal = J.row(i).transpose().cross(J.row((i + 1) % 3).transpose());
    if (normal.squaredNorm() > best.squaredNorm()) best = normal;
  }
  return best.normalized();
}

/// Solves J x = b; in the singular set the least-squares solution with nothing along the null direction.
class RateSolver {
 public:
  explicit RateSolver(const ShoulderGeometry& g, const ShoulderState& state) noexcept {
    inverse_.row(0) = state.b2.cross(state.b3);
    const double volume = g.a[0].dot(inverse_.row(0).transpose());
    if (std::abs(volume) > kSingularVolume) {
      inverse_.row(1) = state.b3.cross(g.a[0]);
      inverse_.row(2) = g.a[0].cross(state.b2);
      inverse_ /= volume;
      return;
    }
    Mat3 J;
    J << g.a[0], state.b2, state.b3;
    const Vec3 v = null_direction(J);
    inverse_ = (J.transpose() * J + v * v.transpose()).inverse() * J.transpose();
  }
  [[nodiscard]] Vec3 operator()(const Vec3& b) const noexcept { return inverse_ * b; }

 private:
  Mat3 inverse_;
};

}  // namespace

Vec3 unwrapped(const Vec3& q, const Vec3& near_q) noexcept {
  constexpr double kTurn = 2.0 * kPi;
  Vec3 out;
  for (int i = 0; i < 3; ++i) out[i] = q[i] + kTurn * std::nearbyint((near_q[i] - q[i]) / kTurn);
  return out;
}

Vec3 middle_of_limits(const ExoSettings& settings, const Vec3& otherwise) noexcept {
  Vec3 out = otherwise;
  for (int i = 0; i < 3; ++i) {
    const double lower = settings.lower[kShoulder1 + i], upper = settings.upper[kShoulder1 + i];
    if (lower > -kNoExoLimit && upper < kNoExoLimit) out[i] = 0.5 * (lower + upper);
  }
  return out;
}

void solve_shoulder(const ShoulderGeometry& g, ExoBranch branch, const Vec3& t, const Vec3& n, const Vec3& near_q,
                    ShoulderState& out) noexcept {
  const double side = static_cast<double>(branch);
  const double sin_half = 0.5 * (t - g.a[0]).norm(), cos_half = 0.5 * (t + g.a[0]).norm();
  out.axis_angle_rad = 2.0 * std::atan2(sin_half, cos_half);
  out.margin_rad = std::min(out.axis_angle_rad - g.least, g.most - out.axis_angle_rad);

  const HalfAngle half = half_interior_angle(g, sin_half, cos_half);
  const double C = 2.0 * std::atan2(half.s, half.c);
  const double cos_C = (half.c - half.s) * (half.c + half.s), sin_C = side * 2.0 * half.s * half.c;
  out.singularity_rad = std::min(C, kPi - C);
  const Vec3 w = g.c23 * g.a[1] + g.s23 * (cos_C * g.u2 + sin_C * g.v2);

  const Vec3 W = g.a[0].cross(w), T = g.a[0].cross(t);
  const double x1 = W.dot(T), y1 = g.a[0].dot(W.cross(T));
  const double length1 = std::sqrt(x1 * x1 + y1 * y1);
  double q1 = near_q[0], c1 = 0.0, s1 = 0.0;
  if (length1 > kSharedAxis * kSharedAxis) {
    q1 = std::atan2(y1, x1);
    c1 = x1 / length1;
    s1 = y1 / length1;
  } else {
    c1 = std::cos(q1);
    s1 = std::sin(q1);
  }
  out.b2 = turned(g.a[0], c1, s1, g.a[1]);
  out.b3 = turned(g.a[0], c1, s1, w);

  const double c2 = g.cos_psi * cos_C - g.sin_psi * sin_C, s2 = g.sin_psi * cos_C + g.cos_psi * sin_C;
  const Vec3 p = turned(g.a[1], c2, -s2, turned(g.a[0], c1, -s1, n));
  out.q = unwrapped(Vec3(q1, g.psi + side * C, std::atan2(g.s3.dot(p), g.p3.dot(p))), near_q);
}

void shoulder_rates(const ShoulderGeometry& g, const ShoulderState& state, const Vec3& w, const Vec3& alpha, Vec3& dq,
                    Vec3& ddq) noexcept {
  const RateSolver solve(g, state);
  dq = solve(w);
  const Vec3 db2 = dq[0] * g.a[0].cross(state.b2);
  const Vec3 db3 = (dq[0] * g.a[0] + dq[1] * state.b2).cross(state.b3);
  ddq = solve(alpha - dq[1] * db2 - dq[2] * db3);
}

Status shoulder_joints(const ExoModel& model, const Mat3& R_TB, const Mat3& R_TU, ExoBranch branch, const Vec3& near_q,
                       ShoulderSolution& out) noexcept {
  if (!R_TB.allFinite() || !R_TU.allFinite() || !near_q.allFinite()) return Status::NotFinite;
  const ShoulderGeometry& g = model.shoulder();
  const Vec3 t = R_TB.transpose() * (R_TU * g.a3_U), n = R_TB.transpose() * (R_TU * g.p3_U);
  ShoulderState state;
  solve_shoulder(g, branch, t, n, near_q, state);
  out = {state.q, state.margin_rad, state.singularity_rad, state.axis_angle_rad};
  return state.margin_rad < -kFeasibleRounding ? Status::ExoInfeasible : Status::Ok;
}

}  // namespace glenoid
