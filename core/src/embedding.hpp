#pragma once

#include <type_traits>

#include "glenoid/arm_model.hpp"

namespace glenoid {

/// Tangent of the configuration space at a posture: (rotation vector in U, elbow angle).
using Tangent = Vec4;

inline constexpr int kColumns = 18;  ///< six columns of F, three coordinates each
inline constexpr int
    kEmbedding = 20;  ///< and the two coordinates of the turning feature (M6), left alone where it has no weight

/// Calls f with the number of rows in use as a compile-time constant: the turning feature costs nothing where it is off.
template <class Function>
auto with_rows(bool turning, Function&& f) {
  return turning ? f(std::integral_constant<int, kEmbedding>()) : f(std::integral_constant<int, kColumns>());
}

/// Embedding F of one posture and its Jacobian in body coordinates (docs/equations.md, E1, E4). Row 3c + r is coordinate r
/// of column c of F = (p_TS, x_U, y_U, z_U, y_F, z_F); rows kColumns and kColumns + 1 are the turning feature.
struct alignas(32) EmbeddedNode {
  double J[kEmbedding][4];   ///< dF / d(delta, phi) with R <- R exp[delta]
  double MJ[kEmbedding][4];  ///< mass * J
  double F[kEmbedding];
  double MF[kEmbedding];  ///< mass * F
  Mat3 R;
  Mat3 R_F;
  RhythmJet shoulder;
};

/// Fills a node. The rhythm is evaluated only when `with_shoulder` is set (or the metric needs it).
void embed(const ArmModel& arm, const Posture& posture, bool with_shoulder, EmbeddedNode& node) noexcept;

/// Second variation of force . F along R exp[t delta], phi + t dphi: the symmetric 4x4 matrix of docs/equations.md, E5.
Mat4 embedding_curvature(const EmbeddedNode& node, const double force[kEmbedding], bool with_shoulder,
                         bool turning) noexcept;

/// Jacobian of the wrist in body coordinates, 3x4, m. The node must have been embedded with its shoulder.
Eigen::Matrix<double, 3, 4> wrist_jacobian(const ArmModel& arm, const EmbeddedNode& node) noexcept;

/// Moves a posture along a tangent: R exp[delta], phi + dphi.
Posture retract(const Posture& posture, const Tangent& step) noexcept;

/// Rotation vector of R (angle in [0, pi]) and the rotation of a rotation vector.
Vec3 rotation_vector(const Mat3& R) noexcept;
Mat3 rotation(const Vec3& rotation_vector) noexcept;

/// Rotation about x.
Mat3 rotation_x(double angle) noexcept;

}  // namespace glenoid
