#pragma once

#include "glenoid/arm_model.hpp"
#include "glenoid/status.hpp"

namespace glenoid {

/// Coefficients of the posture prior (docs/equations.md, P1), fitted by `glenoid validate --fit`: replace them to use
/// recordings of your own.
struct PosturePriorCoefficients {
  double height_rad = 0.273;    ///< change of swivel per arm length that the wrist rises
  double lateral_rad = -0.128;  ///< and per arm length that it moves sideways, away from the trunk
  double regression = 0.252;    ///< share of the person's deviation from the common swivel that a far movement loses
  double common_rad = 0.524;    ///< swivel that people tend to
};

/// The swivel angle that people choose at the end of a reach: a small change of their own at the start, anchored there.
///
/// A value: copy it, no memory is held. It is a smooth function of the target that gives the anchor's own swivel angle at the
/// anchor's own wrist, and does not depend on the way taken: re-planning to the same target gives the same posture. Limits and
/// reach are the planner's business. Points are those of a right arm.
class PosturePrior {
 public:
  PosturePrior() = default;
  /// Anchors the prior at a posture that the person takes by themselves, usually the start of the first movement.
  /// @throws std::invalid_argument naming the coefficient, value, unit and rule (all finite, |.| <= 10, regression 0..1).
  PosturePrior(const PosturePriorCoefficients& coefficients, const ArmModel& arm, const Posture& anchor);

  /// Swivel angle expected for a wrist target, rad; NaN only for a target that is not finite. @alloc none
  [[nodiscard]] double swivel(const Vec3& target) const noexcept;

  [[nodiscard]] const PosturePriorCoefficients& coefficients() const noexcept { return coefficients_; }

 private:
  PosturePriorCoefficients coefficients_{};
  Vec3 wrist_ = Vec3::Zero();  ///< of the anchor, m in T
  double length_m_ = 1.0;      ///< upper arm and forearm
  double own_rad_ = 0.0;       ///< swivel of the anchor, or the common one as far as the anchor's is ill-conditioned
};

}  // namespace glenoid
