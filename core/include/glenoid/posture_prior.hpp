#pragma once

#include "glenoid/arm_model.hpp"
#include "glenoid/status.hpp"

namespace glenoid {

/// Length that the wrist's displacement is counted in, m: an arm. The same for every person: tables do not grow with arms.
inline constexpr double kPriorSpan = 0.54;

/// Level displacements of the wrist count up to here for the lift, m: what was measured goes no farther.
inline constexpr double kMostLevel = 0.4;

/// Coefficients of the posture prior (docs/equations.md, P1), fitted by `glenoid validate --fit`: replace them to use
/// recordings of your own.
struct PosturePriorCoefficients {
  double height_rad = 0.267;    ///< change of swivel per kPriorSpan that the wrist rises
  double lateral_rad = -0.150;  ///< and per kPriorSpan that it moves sideways, away from the trunk
  double regression = 0.259;    ///< share of the person's deviation from the common swivel that a far movement loses
  double common_rad = 0.501;    ///< swivel that people tend to
  double effort = 0.02;  ///< weight of the rotation away from the anchor, squared, against the squared error of the swivel
  double lift_per_m = 2.0;  ///< lift of the path (P3) per squared level displacement of the wrist
};

/// The posture that people choose at the end of a reach: a swivel angle that is a small change of their own at the start, and
/// little rotation of the upper arm where the target leaves the swivel angle without meaning.
///
/// A value: copy it, no memory is held. The expected swivel is a smooth function of the target that gives the anchor's own at the
/// anchor's own wrist. Nothing depends on the way taken: re-planning to the same target gives the same posture. Limits and
/// reach are the planner's business. Points are those of a right arm.
class PosturePrior {
 public:
  PosturePrior() = default;
  /// Anchors the prior at a posture that the person takes by themselves, usually the start of the first movement.
  /// @throws std::invalid_argument naming the coefficient, value, unit and rule (all finite, |.| <= 10, regression 0..1).
  PosturePrior(const PosturePriorCoefficients& coefficients, const ArmModel& arm, const Posture& anchor);

  /// Swivel angle expected for a wrist target, rad; NaN only for a target that is not finite. @alloc none
  [[nodiscard]] double swivel(const Vec3& target) const noexcept;

  /// How unlikely a final posture is, >= 0 (P2): squared chord between its swivel angle and the given one, plus `effort` times the
  /// squared angle of the upper arm's rotation from the anchor. @param swivel_rad  swivel(target)
  [[nodiscard]] double cost(const ArmModel& arm, const Posture& posture, double swivel_rad) const noexcept;

  /// How much the path between two places of the wrist is bent upward, m (P3): people lift the hand on a level way.
  [[nodiscard]] double lift(const Vec3& from, const Vec3& to) const noexcept;

  [[nodiscard]] const PosturePriorCoefficients& coefficients() const noexcept { return coefficients_; }

 private:
  PosturePriorCoefficients coefficients_{};
  Mat3 rotation_ = Mat3::Identity();  ///< of the anchor's upper arm
  Vec3 wrist_ = Vec3::Zero();         ///< of the anchor, m in T
  double own_rad_ = 0.0;  ///< swivel of the anchor, or the common one as far as the anchor's is ill-conditioned
};

}  // namespace glenoid
