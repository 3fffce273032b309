#pragma once

#include "glenoid/types.hpp"

namespace glenoid {

using Vec2 = Eigen::Vector2d;

/// Where the vertical stands in the cross-section of the upper arm, t = v / sqrt(v.v + kTurningWidth^2) with v = (x_U.z, y_U.z),
/// and how it changes with a rotation R exp[delta]; docs/equations.md, M6. Away from the vertical arm t is the unit vector at
/// the angle of the axial rotation zeta, at the vertical arm it is 0: its rate is what turning the arm costs.
struct TurningFeature {
  Vec2 v = Vec2::Zero();
  Vec2 t = Vec2::Zero();
  Eigen::Matrix<double, 2, 3> v_rate = Eigen::Matrix<double, 2, 3>::Zero();  ///< dv / d delta
  Eigen::Matrix<double, 2, 3> t_rate = Eigen::Matrix<double, 2, 3>::Zero();  ///< dt / d delta
  double inverse = 0.0;                                                      ///< 1 / sqrt(v.v + kTurningWidth^2)
  double upright = 0.0;                                                      ///< z_U.z
};

/// Sine of the angle to the vertical at which half of the turning is felt.
inline constexpr double kTurningWidth = 0.1;

TurningFeature turning_feature(const Mat3& R_TU) noexcept;

/// Second derivative of t along R exp[s w] at s = 0: what is left of t'' when the body rate w is constant.
Vec2 turning_bend(const TurningFeature& feature, const Vec3& w) noexcept;

/// Second variation of force.t along R exp[s delta]: the symmetric matrix of the quadratic form in delta.
Mat3 turning_curvature(const TurningFeature& feature, const Vec2& force) noexcept;

}  // namespace glenoid
