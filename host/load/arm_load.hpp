#pragma once

// The arm that an exoskeleton carries, as the load that couples its drives.

#include <array>

#include "glenoid/exoskeleton.hpp"
#include "glenoid/subject.hpp"
#include "host/drives/load.hpp"

namespace glenoid::load {

using Mat6 = Eigen::Matrix<double, 6, 6>;
inline constexpr double kStandardGravity_m_per_s2 = 9.80665;  // exact by definition, 3rd CGPM 1901

/// From a drive to the joint of the device: joint = sign * drive + offset_rad.
struct JointDirection {
  double sign = 1.0;
  double offset_rad = 0.0;
};

/// An arm in a device, on the right-hand side (a left arm is the mirrored problem with the same joints).
struct ArmLoadSettings {
  Segment upper_arm, forearm;  ///< forearm and hand together
  ExoSettings exo;
  double girdle_length_m = 0.0;  ///< from the fixed trunk point to the shoulder; it stays what it is
  double gravity_m_per_s2 = kStandardGravity_m_per_s2;
  std::array<JointDirection, 6> joints;  ///< in the order of ExoJoint
};

/// M(x) and h(x, v) in  M a + h = tau  for the six joints x of the device (docs/drives.md, "The arm as load").
///
/// The arm is rigidly strapped to the device: R_TU, phi and the shoulder are those of its forward kinematics (X1, X5).
/// Then M = J' m J and h = J' m (J' v - g) with the constant mass m of docs/equations.md, E1-E3, and J = dF/dx, exactly.
class ArmDynamics {
 public:
  /// @throws std::invalid_argument naming variable, value, unit and rule; also for girdle drives that are a vertical slide.
  explicit ArmDynamics(const ArmLoadSettings& settings);

  /// @param[in]  x     joints, rad, order of ExoJoint
  /// @param[in]  v     their rates, rad/s
  /// @param[out] M     kg.m2, symmetric, positive semidefinite: joints that cannot move the arm have zero rows
  /// @param[out] bias  h, Nm: gravity, Coriolis and centrifugal
  /// @alloc none
  void evaluate(const Vec6& x, const Vec6& v, Mat6& M, Vec6& bias) const noexcept;

  /// Potential energy of gravity, J, zero with all masses at the height of the fixed trunk point.
  [[nodiscard]] double potential_J(const Vec6& x) const noexcept;

 private:
  ExoModel exo_;
  Mat6 mass_;
  double girdle_length_m_;
  Vec3 gravity_;
};

/// The drives of one device under its arm. All drives of the group must be those of the joints, in their order.
///
/// Each joint gets the inertia that it truly feels with the others free, 1 / ((J + M)^-1)_kk, and the torque that gives it the
/// acceleration of the whole mechanism; the torques of the other motors are those of the servo step before.
class ArmLoad final : public drives::Load {
 public:
  explicit ArmLoad(const ArmLoadSettings& settings) : dynamics_(settings), joints_(settings.joints) {}

  [[nodiscard]] std::size_t joints() const noexcept override { return joints_.size(); }
  void act(std::span<const drives::JointState> joints, std::span<drives::JointLoad> loads) noexcept override;

 private:
  ArmDynamics dynamics_;
  std::array<JointDirection, 6> joints_;
};

}  // namespace glenoid::load
