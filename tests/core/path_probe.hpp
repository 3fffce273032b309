#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "glenoid/geodesic.hpp"
#include "glenoid/kinematics.hpp"
#include "glenoid/mass_matrix.hpp"
#include "reach_task.hpp"
#include "support/arms.hpp"
#include "support/environment.hpp"

namespace glenoid::test {

inline std::string replay(std::uint64_t index) { return "random case " + std::to_string(index); }

inline Posture posture_deg(double theta, double eta, double zeta, double phi) {
  return posture_from_angles(Vec4(theta, eta, zeta, phi) * kDegree);
}

inline Mat3 skew(const Vec3& w) {
  Mat3 out;
  out << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
  return out;
}

/// Rodrigues' rotation.
inline Mat3 rotation(const Vec3& v) {
  const double half = 0.5 * v.norm();
  const double sinc_half = half < 1e-4 ? 1.0 - half * half / 6.0 : std::sin(half) / half;
  const double sinc = half < 1e-4 ? 1.0 - 4.0 * half * half / 6.0 : std::sin(2.0 * half) / (2.0 * half);
  return Mat3::Identity() + sinc * skew(v) + 0.5 * sinc_half * sinc_half * skew(v) * skew(v);
}

/// Angle between two rotations, accurate near zero.
inline double rotation_distance(const Mat3& a, const Mat3& b) {
  return 2.0 * std::asin(std::min(1.0, (a - b).norm() / (2.0 * std::sqrt(2.0))));
}

inline double posture_distance(const Posture& a, const Posture& b) {
  return std::hypot(rotation_distance(a.R_TU, b.R_TU), a.phi - b.phi);
}

inline Posture displaced(const Posture& posture, const Vec4& tangent) {
  return {posture.R_TU * rotation(tangent.head<3>()), posture.phi + tangent[3]};
}

inline Posture posture_of(const PostureJet& jet) {
  Posture out;
  out.R_TU << jet.x, jet.z.cross(jet.x), jet.z;
  out.phi = jet.phi;
  return out;
}

/// Body rates (w_TU_U, phi') of a jet: R' = R [w]x read off the columns x and z.
inline Vec4 body_rates(const PostureJet& jet) {
  const Mat3 R = posture_of(jet).R_TU;
  const Vec3 dx = R.transpose() * jet.dx, dz = R.transpose() * jet.dz;  // (0, w_z, -w_y) and (w_y, -w_x, 0)
  return {-dz.y(), 0.5 * (dz.x() - dx.z()), dx.y(), jet.dphi};
}

inline PostureRates as_rates(const Vec4& v) { return {v.head<3>(), v[3]}; }

/// Kinetic energy 1/2 v'Mv of the arm at a point of a path, from the metric in body rates.
inline double energy_at(const ArmModel& arm, const GeodesicPath& path, double lambda) {
  PostureJet jet;
  evaluate_path(path, lambda, jet);
  const Vec4 v = body_rates(jet);
  return 0.5 * v.dot(body_mass_matrix(arm, path_posture(path, lambda)) * v);
}

/// Momentum M v in body coordinates at a point of a path.
inline Vec4 momentum_at(const ArmModel& arm, const GeodesicPath& path, double lambda) {
  PostureJet jet;
  evaluate_path(path, lambda, jet);
  return body_mass_matrix(arm, path_posture(path, lambda)) * body_rates(jet);
}

inline const Posture& path_end(const GeodesicPath& path) { return path.nodes[static_cast<std::size_t>(path.order)]; }

/// Solves to a tail of 1e-11 (or as far as the largest order goes).
inline Status solve_tightly(GeodesicSolver& solver, const ArmModel& arm, const Posture& start, const Posture& end,
                            GeodesicPath& path, Certificate& certificate) {
  GeodesicOptions options;
  options.tail_tolerance = 1e-10;
  return solver.solve(arm, start, end, options, nullptr, path, certificate);
}

}  // namespace glenoid::test
