#pragma once

#include <array>

#include "glenoid/arm_model.hpp"
#include "glenoid/status.hpp"

namespace glenoid {

/// Joint points of the arm in T, m.
struct ArmPoints {
  Vec3 shoulder, elbow, wrist;
};

/// R = Rz(eta) Rx(theta) Rz(zeta) and phi from q = (theta, eta, zeta, phi), rad; docs/equations.md, K1.
Posture posture_from_angles(const Vec4& q) noexcept;

/// q from a posture; theta in [0, pi], phi unchanged. eta and zeta are brought within pi of near_q. At theta = 0
/// (or pi), where only eta + zeta (eta - zeta) is defined, eta is taken from near_q.
Vec4 angles_from_posture(const Posture& posture, const Vec4& near_q) noexcept;

/// Axial rotation tau = eta + zeta of the swing-twist decomposition; defined for every theta < pi; docs/equations.md, K5.
double axial_rotation(const Mat3& R_TU) noexcept;

/// Forward kinematics about the moving centre; docs/equations.md, K2.
ArmPoints forward_kinematics(const ArmModel& arm, const Posture& posture) noexcept;

/// Posture of the paper's eq. (3) from three joint points, in the well-conditioned form; docs/equations.md, K3.
/// @return NotFinite, or OutOfRange when two points coincide. A straight elbow leaves the axial rotation undefined:
///         R_near decides it.
Status posture_from_points(const ArmPoints& points, const Mat3& R_near, Posture& out) noexcept;

/// Swivel angle of a posture: 0 = elbow lowest, positive = elbow lateral (right arm), rad; docs/equations.md, K4.
/// 0 where it is undefined (wrist straight above or below the shoulder, or the arm straight).
double swivel_angle(const ArmPoints& points) noexcept;

/// ISB (Wu 2005, Y-X-Y) angles (plane of elevation, elevation, axial rotation) and elbow flexion, rad, from q; K6.
Vec4 isb_from_angles(const Vec4& q) noexcept;
Vec4 angles_from_isb(const Vec4& isb) noexcept;

inline constexpr int kMaxIkSolutions = 8;

struct IkSolutions {
  int count = 0;
  std::array<Posture, kMaxIkSolutions> postures;
  /// Metres by which the target lies inside the reach of the best shoulder position; negative when unreachable.
  double reach_margin_m = 0.0;
};

/// Every posture that puts the wrist at `wrist` with the given swivel angle (model about the moving centre; K7).
/// @return Ok with count >= 1; TargetUnreachable with count 0 and the (possibly negative) margin; NotFinite.
/// @alloc none
Status inverse_kinematics(const ArmModel& arm, const Vec3& wrist, double swivel_rad, IkSolutions& out) noexcept;

}  // namespace glenoid
