#pragma once

#include <array>

#include "glenoid/types.hpp"

namespace glenoid {

inline constexpr int kMaxPathOrder = 64;

/// A geodesic between two postures on Legendre-Gauss-Lobatto nodes over lambda in [0, 1]. Trivially copyable.
struct GeodesicPath {
  static constexpr int kChannels = 7;  ///< x_U (3), z_U (3), phi
  int order = 0;                       ///< number of intervals; order + 1 nodes; 0 = a posture at rest
  double energy = 0.0;                 ///< 1/2 q'Mq', constant along the path (its mean where there is a lift), kg.m2
  double lift_m = 0.0;                 ///< what bends the path upward (G7), m; 0 = a geodesic
  std::array<Posture, kMaxPathOrder + 1> nodes;
  /// Legendre coefficients of every channel, in blocks of eight (the last is padding).
  std::array<std::array<double, 8>, kMaxPathOrder + 1> legendre;
};

/// Second-order Taylor data of a posture with respect to lambda (or time): columns x_U, z_U and phi.
struct PostureJet {
  Vec3 x, dx, ddx;
  Vec3 z, dz, ddz;
  double phi, dphi, ddphi;
};

/// Path that stays at one posture.
void make_constant_path(const Posture& posture, GeodesicPath& out) noexcept;

/// Fills the coefficients of a path from its nodes. @alloc none
void finish_path(GeodesicPath& path) noexcept;

/// Posture and its first and second derivative with respect to lambda, clamped to [0, 1]. The columns are
/// exactly orthonormal, derivatives included. @alloc none @cost about 0.1 us for order 16
void evaluate_path(const GeodesicPath& path, double lambda, PostureJet& out) noexcept;

/// The posture alone, with an exact rotation matrix.
Posture path_posture(const GeodesicPath& path, double lambda) noexcept;

/// Angles q with first and second derivative from a posture jet. eta and zeta are brought within pi of near_q. At
/// theta = 0 the rates of eta and zeta are undefined: eta keeps near_q and rate 0, zeta carries the axial rotation.
void angles_from_jet(const PostureJet& jet, const Vec4& near_q, Vec4& q, Vec4& dq, Vec4& ddq) noexcept;

}  // namespace glenoid
