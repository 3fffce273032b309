#pragma once

#include <Eigen/Core>

namespace glenoid {

using Vec3 = Eigen::Vector3d;
using Vec4 = Eigen::Vector4d;
using Mat3 = Eigen::Matrix3d;
using Mat4 = Eigen::Matrix4d;

inline constexpr double kPi = 3.14159265358979323846;

/// Posture of the arm without a chart: nothing is singular at the hanging arm.
///
/// R_TU  rotation of the upper arm U in the thorax frame T; the upper arm points along -z of U and the
///       elbow turns about +x of U (docs/equations.md, K1).
/// phi   elbow flexion in rad, 0 = straight.
struct Posture {
  Mat3 R_TU = Mat3::Identity();
  double phi = 0.0;
};

/// Rates of a posture that need no chart: w_TU_U is the angular velocity of the upper arm expressed in U, rad/s
/// (or rad per unit of the path parameter); phi the elbow rate.
struct PostureRates {
  Vec3 w_TU_U = Vec3::Zero();
  double phi = 0.0;
};

/// Index of each arm angle in q = (theta, eta, zeta, phi); docs/conventions.md.
enum ArmAngle : int { kTheta = 0, kEta = 1, kZeta = 2, kPhi = 3 };

}  // namespace glenoid
