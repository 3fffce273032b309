#pragma once

#include "glenoid/limits.hpp"
#include "glenoid/rhythm.hpp"
#include "glenoid/subject.hpp"

namespace glenoid {

/// Constant description of one arm: segments, rhythm, limits and the metric built from them.
///
/// The kinetic energy of the arm is exactly 1/2 trace(F' mass F'^T) with F the 3x6 matrix of columns
/// (p_TS, x_U, y_U, z_U, y_F, z_F) in T; docs/equations.md, E1-E3. `mass` is constant, so the metric needs neither M nor C.
/// A cost of turning may be added to it (M6).
struct ArmModel {
  Segment upper_arm;
  Segment forearm;
  Rhythm rhythm;
  JointLimits limits;
  bool moving_shoulder = true;  ///< whether the shoulder's velocity enters the metric
  Eigen::Matrix<double, 6, 6> mass = Eigen::Matrix<double, 6, 6>::Zero();
  double turning_kg_m2 = 0.0;  ///< weight of turning the upper arm about itself in the metric (M6), >= 0
};

/// First moments of the masses about the shoulder's centre, kg.m: their height is -upper * z_U.z - forearm * z_F.z (G7).
struct MassMoments {
  double upper = 0.0, forearm = 0.0;
};
MassMoments mass_moments(const ArmModel& arm) noexcept;

/// Height of the arm's masses over the shoulder's centre, kg.m (G7).
double mass_height(const ArmModel& arm, const Posture& posture) noexcept;

/// Builds the model of a right arm (a left arm is the mirrored problem; see motion.hpp).
/// @throws std::invalid_argument naming variable, value, unit and rule.
ArmModel make_arm_model(const ScaledArm& arm, const Rhythm& rhythm, const JointLimits& limits, bool moving_shoulder);

}  // namespace glenoid
