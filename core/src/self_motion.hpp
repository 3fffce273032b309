#pragma once

#include <array>

#include "glenoid/arm_model.hpp"

namespace glenoid {

/// One closed curve of postures that put the wrist at the same point (docs/equations.md, K7).
///
/// It is the set {u : |w - X(u) - l_u u| = l_f} of upper-arm directions u around `centre`, the direction in which the arm
/// is most stretched; psi turns around that centre, so nothing is singular where the swivel angle is.
struct SelfMotionLoop {
  Vec3 centre, e1, e2;          ///< orthonormal
  double stretch_margin_m = 0;  ///< l_f minus the elbow-wrist distance at the centre
};

struct SelfMotion {
  static constexpr int kMaxLoops = 3;
  int count = 0;
  std::array<SelfMotionLoop, kMaxLoops> loops;
  double reach_margin_m = 0.0;  ///< metres inside the reach of the best shoulder position; negative = unreachable
};

/// Finds every loop for a wrist target. @alloc none
void find_self_motion(const ArmModel& arm, const Vec3& wrist, SelfMotion& out) noexcept;

/// Metres inside the reach of the shoulder position that belongs to the most stretched arm near the upper-arm direction u;
/// negative = unreachable from there. @alloc none
double reach_margin_near(const ArmModel& arm, const Vec3& wrist, Vec3 u) noexcept;

/// Posture at angle psi of a loop. `opening` is the angle between u and the centre: guess in (0 = none), solution out.
/// @return false where the ray at psi meets no posture.
bool loop_posture(const ArmModel& arm, const Vec3& wrist, const SelfMotionLoop& loop, double psi, double& opening,
                  Posture& out) noexcept;

}  // namespace glenoid
