#include "glenoid/mass_matrix.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "glenoid/kinematics.hpp"
#include "turning.hpp"

namespace glenoid {
namespace {

/// Columns (p_TS, x_U, y_U, z_U, y_F, z_F) in T, or a derivative of them.
using Embedding = Eigen::Matrix<double, 3, 6>;

/// The columns of F that are fixed in a segment, expressed in U: constants x, y, z and the forearm's y and z.
struct ForearmAxes {
  Vec3 y, z;
  explicit ForearmAxes(double phi) : y(0.0, std::cos(phi), std::sin(phi)), z(0.0, -std::sin(phi), std::cos(phi)) {}
};

/// First derivative of F with respect to the body rates (w_TU_U, phi'), one matrix per rate.
std::array<Embedding, 4> tangents(const Mat3& R_TU, const ForearmAxes& forearm, const RhythmJet& rhythm) noexcept {
  std::array<Embedding, 4> J;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Vec3 w = Vec3::Unit(k);
    Embedding& column = J[static_cast<std::size_t>(k)];
    for (Eigen::Index a = 0; a < 3; ++a) column.col(1 + a) = R_TU * w.cross(Vec3::Unit(a));
    column.col(4) = R_TU * w.cross(forearm.y);
    column.col(5) = R_TU * w.cross(forearm.z);
    column.col(0) = rhythm.J_z * column.col(3);
  }
  J[3].setZero();
  J[3].col(4) = R_TU * forearm.z;
  J[3].col(5) = -(R_TU * forearm.y);
  return J;
}

/// J' v: what the second derivative of F is when the body rates are constant.
Embedding tangent_rate(const Mat3& R_TU, const ForearmAxes& forearm, const RhythmJet& rhythm,
                       const PostureRates& v) noexcept {
  const Vec3& w = v.w_TU_U;
  const auto centripetal = [&w](const Vec3& u) -> Vec3 { return w.cross(w.cross(u)); };
  const double square = v.phi * v.phi;
  Embedding rate;
  for (Eigen::Index a = 0; a < 3; ++a) rate.col(1 + a) = R_TU * centripetal(Vec3::Unit(a));
  rate.col(4) = R_TU * (centripetal(forearm.y) + 2.0 * v.phi * w.cross(forearm.z) - square * forearm.y);
  rate.col(5) = R_TU * (centripetal(forearm.z) - 2.0 * v.phi * w.cross(forearm.y) - square * forearm.z);
  const Vec3 dz = R_TU * w.cross(Vec3::UnitZ());
  rate.col(0) = rhythm.J_z * rate.col(3);
  for (std::size_t k = 0; k < 3; ++k) rate(static_cast<Eigen::Index>(k), 0) += dz.dot(rhythm.H_z[k] * dz);
  return rate;
}

double inner(const Embedding& a, const Embedding& b) noexcept { return a.cwiseProduct(b).sum(); }

/// Metric in body rates and the force b in  M a + b = 0; equations M3 and M4. Exact, since the metric is the pull-back of a
/// constant one: M = J'(mass x I)J and b = J'(mass x I) J' v; the turning feature (M6) adds its two rows.
struct BodyDynamics {
  Mat4 M;
  Vec4 b;
};

void add_turning(double weight, const Mat3& R_TU, const Vec3& w, BodyDynamics& out) noexcept {
  const TurningFeature feature = turning_feature(R_TU);
  out.M.topLeftCorner<3, 3>() += weight * feature.t_rate.transpose() * feature.t_rate;
  out.b.head<3>() += weight * feature.t_rate.transpose() * turning_bend(feature, w);
}

BodyDynamics body_dynamics(const ArmModel& arm, const Posture& posture, const PostureRates& v) noexcept {
  RhythmJet rhythm;
  arm.rhythm.evaluate(posture.R_TU.col(2), rhythm);
  const ForearmAxes forearm(posture.phi);
  const std::array<Embedding, 4> J = tangents(posture.R_TU, forearm, rhythm);
  const Embedding bent = tangent_rate(posture.R_TU, forearm, rhythm, v) * arm.mass;
  BodyDynamics out;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Embedding momentum = J[i] * arm.mass;
    for (std::size_t j = 0; j <= i; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      out.M(row, column) = out.M(column, row) = inner(momentum, J[j]);
    }
    out.b[row] = inner(bent, J[i]);
  }
  if (arm.turning_kg_m2 != 0.0) add_turning(arm.turning_kg_m2, posture.R_TU, v.w_TU_U, out);
  return out;
}

/// Body rates per Euler rate, (w_TU_U, phi') = G(q) q', and the part of their derivative that is quadratic in q'.
struct RateMap {
  Mat4 G = Mat4::Zero();
  Vec4 G_rate_v = Vec4::Zero();
};

RateMap rate_map(const Vec4& q, const Vec4& v) noexcept {
  const double st = std::sin(q[kTheta]), ct = std::cos(q[kTheta]);
  const double sz = std::sin(q[kZeta]), cz = std::cos(q[kZeta]);
  RateMap map;
  map.G << cz, sz * st, 0.0, 0.0, -sz, cz * st, 0.0, 0.0, 0.0, ct, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  const double dt = v[kTheta], de = v[kEta], dz = v[kZeta];
  map.G_rate_v << -sz * dz * dt + (cz * dz * st + sz * ct * dt) * de,
      -cz * dz * dt + (-sz * dz * st + cz * ct * dt) * de, -st * dt * de, 0.0;
  return map;
}

PostureRates rates_of(const Vec4& v) noexcept { return {v.head<3>(), v[3]}; }

}  // namespace

Mat4 mass_matrix(const ArmModel& arm, const Vec4& q) noexcept {
  const RateMap map = rate_map(q, Vec4::Zero());
  const Mat4 body = body_mass_matrix(arm, posture_from_angles(q));
  const Mat4 M = map.G.transpose() * body * map.G;
  return 0.5 * (M + M.transpose());
}

Vec4 coriolis_vector(const ArmModel& arm, const Vec4& q, const Vec4& v) noexcept {
  const RateMap map = rate_map(q, v);
  const BodyDynamics body = body_dynamics(arm, posture_from_angles(q), rates_of(map.G * v));
  return map.G.transpose() * (body.b + body.M * map.G_rate_v);
}

Mat4 body_mass_matrix(const ArmModel& arm, const Posture& posture) noexcept {
  return body_dynamics(arm, posture, PostureRates()).M;
}

PostureRates geodesic_acceleration(const ArmModel& arm, const Posture& posture, const PostureRates& rates,
                                   double lift_m) noexcept {
  BodyDynamics body = body_dynamics(arm, posture, rates);
  if (lift_m != 0.0) {
    const std::array<Embedding, 4> J = tangents(posture.R_TU, ForearmAxes(posture.phi), RhythmJet());
    const MassMoments moments = mass_moments(arm);
    for (std::size_t i = 0; i < 4; ++i) {
      body.b[static_cast<Eigen::Index>(i)] -= lift_m * (moments.upper * J[i](2, 3) + moments.forearm * J[i](2, 5));
    }
  }
  return rates_of(body.M.llt().solve(-body.b));
}

}  // namespace glenoid
