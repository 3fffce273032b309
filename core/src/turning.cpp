#include "turning.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace glenoid {

TurningFeature turning_feature(const Mat3& R_TU) noexcept {
  TurningFeature f;
  f.v = Vec2(R_TU(2, 0), R_TU(2, 1));
  f.upright = R_TU(2, 2);
  f.inverse = 1.0 / std::sqrt(f.v.squaredNorm() + kTurningWidth * kTurningWidth);
  f.t = f.inverse * f.v;
  f.v_rate << 0.0, -f.upright, f.v.y(), f.upright, 0.0, -f.v.x();
  const Eigen::RowVector3d square_rate = f.v.transpose() * f.v_rate;  // half the rate of v.v
  f.t_rate = f.inverse * f.v_rate - (f.inverse * f.inverse) * f.t * square_rate;
  return f;
}

Vec2 turning_bend(const TurningFeature& f, const Vec3& w) noexcept {
  const Vec3 vertical(f.v.x(), f.v.y(), f.upright);  // in U
  const Vec2 rate = f.v_rate * w;
  const Vec2 bend = (vertical.dot(w) * w - w.squaredNorm() * vertical).head<2>();
  const double g = f.inverse, g3 = g * g * g, half = f.v.dot(rate);
  const double g_rate = -g3 * half, g_bend = 3.0 * g3 * g * g * half * half - g3 * (rate.dot(rate) + f.v.dot(bend));
  return g * bend + 2.0 * g_rate * rate + g_bend * f.v;
}

Mat3 turning_curvature(const TurningFeature& f, const Vec2& force) noexcept {
  const double g = f.inverse, g3 = g * g * g, along = force.dot(f.v);
  const Vec2 pull = g * force - g3 * along * f.v;  // force on v: that of v's own second variation
  const Vec3 vertical(f.v.x(), f.v.y(), f.upright);
  Mat3 B = Mat3::Zero();
  B.leftCols<2>() = vertical * pull.transpose();
  const Vec3 p = f.v_rate.transpose() * f.v, r = f.v_rate.transpose() * force;
  Mat3 H = 0.5 * (B + B.transpose());
  H.diagonal().array() -= B.trace();
  H -= g3 * (p * r.transpose() + r * p.transpose());
  H += along * (3.0 * g3 * g * g * p * p.transpose() - g3 * f.v_rate.transpose() * f.v_rate);
  return H;
}

}  // namespace glenoid
