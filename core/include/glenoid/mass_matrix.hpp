#pragma once

#include "glenoid/arm_model.hpp"

namespace glenoid {

/// M(q) in the Euler chart, kg.m2, symmetric, positive definite for theta in (0, pi); docs/equations.md, M1.
/// For users and tests: the solver itself never leaves SO(3) x R.
Mat4 mass_matrix(const ArmModel& arm, const Vec4& q) noexcept;

/// C(q, v) v in the Euler chart; docs/equations.md, M2. Analytic derivatives. The geodesic equation is M a + C v = 0.
Vec4 coriolis_vector(const ArmModel& arm, const Vec4& q, const Vec4& v) noexcept;

/// Metric in body rates (w_TU_U, phi'), regular at the hanging arm; docs/equations.md, M3.
Mat4 body_mass_matrix(const ArmModel& arm, const Posture& posture) noexcept;

/// Acceleration of a geodesic in body rates: solves body_mass_matrix * a = -b(posture, rates); docs/equations.md, M4.
/// @param lift_m  of a path that is bent upward: minus lift_m times the gradient of mass_height on the right (G7)
PostureRates geodesic_acceleration(const ArmModel& arm, const Posture& posture, const PostureRates& rates,
                                   double lift_m = 0.0) noexcept;

}  // namespace glenoid
