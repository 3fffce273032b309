#include "glenoid/path.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "glenoid/kinematics.hpp"
#include "kernels.hpp"
#include "lobatto.hpp"

namespace glenoid {
namespace {

void channels(const Posture& p, double (&f)[8]) {
  for (int r = 0; r < 3; ++r) {
    f[r] = p.R_TU(r, 0);
    f[3 + r] = p.R_TU(r, 2);
  }
  f[6] = p.phi;
  f[7] = 0.0;
}

/// Makes the columns those of a rotation, with their derivatives: z unit, x unit and normal to z.
void orthonormalise(PostureJet& j) {
  const auto normalise = [](Vec3& v, Vec3& dv, Vec3& ddv) {
    const double inverse = 1.0 / v.norm();
    v *= inverse;
    dv *= inverse;
    ddv *= inverse;
    const double a = v.dot(dv);
    const double b = dv.squaredNorm() + v.dot(ddv) - a * a;  // second derivative of the norm, over the norm
    ddv += (2.0 * a * a - b) * v - 2.0 * a * dv;
    dv -= a * v;
  };
  normalise(j.z, j.dz, j.ddz);
  const double c = j.z.dot(j.x);
  const double dc = j.dz.dot(j.x) + j.z.dot(j.dx);
  const double ddc = j.ddz.dot(j.x) + 2.0 * j.dz.dot(j.dx) + j.z.dot(j.ddx);
  j.ddx -= ddc * j.z + 2.0 * dc * j.dz + c * j.ddz;
  j.dx -= dc * j.z + c * j.dz;
  j.x -= c * j.z;
  normalise(j.x, j.dx, j.ddx);
}

/// Angle a, moved by whole turns to within pi of `near`.
double near_angle(double a, double near) { return a - 2.0 * kPi * std::round((a - near) / (2.0 * kPi)); }

/// Value and derivatives of atan2(y, x) from those of y and x.
struct Jet {
  double v, d, dd;
};

Jet arc(const Jet& y, const Jet& x) {
  const double n = x.v * x.v + y.v * y.v;
  const double cross = y.d * x.v - y.v * x.d;
  const double n1 = 2.0 * (x.v * x.d + y.v * y.d);
  const double d = cross / n;
  return {std::atan2(y.v, x.v), d, (y.dd * x.v - y.v * x.dd) / n - d * n1 / n};
}

}  // namespace

void make_constant_path(const Posture& posture, GeodesicPath& out) noexcept {
  out.order = 0;
  out.energy = 0.0;
  out.lift_m = 0.0;
  out.nodes.fill(posture);
  for (auto& row : out.legendre) row.fill(0.0);
  double f[8];
  channels(posture, f);
  std::copy(f, f + 8, out.legendre[0].begin());
}

void finish_path(GeodesicPath& path) noexcept {
  const Lobatto& grid = lobatto(path.order);
  const auto count = static_cast<std::size_t>(path.order) + 1;
  for (auto& row : path.legendre) row.fill(0.0);
  for (std::size_t k = 0; k < count; ++k) {
    double f[8];
    channels(path.nodes[k], f);
    for (std::size_t m = 0; m < count; ++m) {
      const double t = grid.to_legendre[m * count + k];
      for (std::size_t i = 0; i < 8; ++i) path.legendre[m][i] += t * f[i];
    }
  }
  for (std::size_t k = count; k < path.nodes.size(); ++k) path.nodes[k] = path.nodes[count - 1];
}

void evaluate_path(const GeodesicPath& path, double lambda, PostureJet& out) noexcept {
  const double x = 2.0 * std::clamp(lambda, 0.0, 1.0) - 1.0;
  alignas(32) double series[3][8];
  legendre_series(path.legendre[0].data(), path.order, x, series);
  const auto& [v, d, dd] = series;
  // d/dlambda = 2 d/dx
  out.x = Vec3(v[0], v[1], v[2]);
  out.dx = 2.0 * Vec3(d[0], d[1], d[2]);
  out.ddx = 4.0 * Vec3(dd[0], dd[1], dd[2]);
  out.z = Vec3(v[3], v[4], v[5]);
  out.dz = 2.0 * Vec3(d[3], d[4], d[5]);
  out.ddz = 4.0 * Vec3(dd[3], dd[4], dd[5]);
  out.phi = v[6];
  out.dphi = 2.0 * d[6];
  out.ddphi = 4.0 * dd[6];
  orthonormalise(out);
}

Posture path_posture(const GeodesicPath& path, double lambda) noexcept {
  PostureJet jet;
  evaluate_path(path, lambda, jet);
  Posture p;
  p.R_TU.col(0) = jet.x;
  p.R_TU.col(1) = jet.z.cross(jet.x);
  p.R_TU.col(2) = jet.z;
  p.phi = jet.phi;
  return p;
}

void angles_from_jet(const PostureJet& j, const Vec4& near_q, Vec4& q, Vec4& dq, Vec4& ddq) noexcept {
  const Jet zx{j.z.x(), j.dz.x(), j.ddz.x()}, zy{j.z.y(), j.dz.y(), j.ddz.y()}, zz{j.z.z(), j.dz.z(), j.ddz.z()};
  constexpr double kPole = 1e-9;  // sin(theta) below which eta has no meaning
  const double h = std::hypot(zx.v, zy.v);
  const Vec3 y = j.z.cross(j.x);
  q[kPhi] = j.phi, dq[kPhi] = j.dphi, ddq[kPhi] = j.ddphi;
  if (h < kPole) {
    const double tilt = std::hypot(zx.d, zy.d);
    q[kTheta] = std::atan2(h, zz.v), dq[kTheta] = tilt, ddq[kTheta] = 0.0;
    q[kEta] = near_q[kEta], dq[kEta] = ddq[kEta] = 0.0;
    // only eta + zeta (hanging) or eta - zeta (straight up) is defined
    const double sign = zz.v > 0.0 ? 1.0 : -1.0;
    const double turn = std::atan2(j.x.y(), j.x.x());
    q[kZeta] = near_angle(sign * (turn - q[kEta]), near_q[kZeta]);
    const double spin = y.dot(j.dx);  // body rate about z: the axial rotation
    dq[kZeta] = spin, ddq[kZeta] = 0.0;
    return;
  }
  const Jet hh{h, (zx.v * zx.d + zy.v * zy.d) / h, 0.0};
  const double hdd = (zx.d * zx.d + zx.v * zx.dd + zy.d * zy.d + zy.v * zy.dd) / h - hh.d * hh.d / h;
  const Jet theta = arc({h, hh.d, hdd}, zz);
  const Jet eta = arc(zx, {-zy.v, -zy.d, -zy.dd});
  const Vec3 dy = j.dz.cross(j.x) + j.z.cross(j.dx);
  const Vec3 ddy = j.ddz.cross(j.x) + 2.0 * j.dz.cross(j.dx) + j.z.cross(j.ddx);
  const Jet zeta = arc({j.x.z(), j.dx.z(), j.ddx.z()}, {y.z(), dy.z(), ddy.z()});
  q[kTheta] = theta.v, dq[kTheta] = theta.d, ddq[kTheta] = theta.dd;
  q[kEta] = near_angle(eta.v, near_q[kEta]), dq[kEta] = eta.d, ddq[kEta] = eta.dd;
  q[kZeta] = near_angle(zeta.v, near_q[kZeta]), dq[kZeta] = zeta.d, ddq[kZeta] = zeta.dd;
}

}  // namespace glenoid
