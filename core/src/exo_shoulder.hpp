#pragma once

#include "glenoid/exoskeleton.hpp"

namespace glenoid {

/// T solved at one instant: joints, joint axes and distances, all in the base frame B.
struct ShoulderState {
  Vec3 q;
  Vec3 b2, b3;  ///< directions of the second and the third axis of the device
  double margin_rad;
  double singularity_rad;
  double axis_angle_rad;  ///< between the first and the third axis
};

/// Closed form X2, X3. t and n are the directions of a3 and p3 under R* = R_TB^T R_TU C^T. Never NaN for finite input.
/// Outside the feasible set b3 is as near to t as the device gets.
void solve_shoulder(const ShoulderGeometry& g, ExoBranch branch, const Vec3& t, const Vec3& n, const Vec3& near_q,
                    ShoulderState& out) noexcept;

/// Rates X4 from the angular velocity w and acceleration alpha of R* in B.
void shoulder_rates(const ShoulderGeometry& g, const ShoulderState& state, const Vec3& w, const Vec3& alpha, Vec3& dq,
                    Vec3& ddq) noexcept;

/// Angles shifted by whole turns to within pi of near_q.
Vec3 unwrapped(const Vec3& q, const Vec3& near_q) noexcept;

/// Middle of each shoulder joint's range; `otherwise` where it has no limits. Angles near it are those the device can take.
Vec3 middle_of_limits(const ExoSettings& settings, const Vec3& otherwise) noexcept;

inline constexpr double kFeasibleRounding = 1e-12;  // rad: a margin above minus this is feasible

}  // namespace glenoid
