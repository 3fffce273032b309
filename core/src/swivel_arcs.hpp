#pragma once

#include <array>

#include "glenoid/kinematics.hpp"
#include "self_motion.hpp"

namespace glenoid {

/// One posture on a self-motion loop.
struct RingSample {
  double psi = 0.0;
  double opening = 0.0;
  bool exists = false;
  Posture posture;
  LimitMargin margin;
};

/// Stretch of a loop on which every posture lies within the joint limits; begin <= end, not reduced modulo 2 pi.
struct FeasibleArc {
  int loop = 0;
  double begin = 0.0, end = 0.0;
  bool whole = false;    ///< the whole loop; then begin and end are the same posture
  double nearest = 0.0;  ///< on the arc, about where the upper arm is turned least from the start
};

/// All postures of a wrist target that respect the limits (docs/equations.md, S1).
struct FeasibleSet {
  static constexpr int kRing = 72;
  static constexpr int kFineRing = 4 * kRing;
  static constexpr int kMaxJumps = 8;  ///< passes of the elevation below which the limit on eta does not apply
  static constexpr int kMaxArcs = 16;
  SelfMotion motion;
  int count = 0;
  std::array<FeasibleArc, kMaxArcs> arcs;
  LimitMargin best;                                        ///< largest margin seen over all postures of the target
  int samples = 0;                                         ///< in the ring, by growing psi
  std::array<RingSample, kFineRing + 2 * kMaxJumps> ring;  ///< scratch
};

/// Evaluates the posture at psi and its margin. `sample.opening` is used as guess.
void sample_loop(const ArmModel& arm, const Vec3& wrist, const SelfMotionLoop& loop, double psi,
                 RingSample& sample) noexcept;

/// Finds every feasible arc: a ring of samples, denser where the margin jumps; edges by a bracketed root of the margin, arcs
/// and gaps narrower than the ring's spacing by its local extrema. @alloc none
void find_feasible_arcs(const ArmModel& arm, const Posture& start, const Vec3& wrist, FeasibleSet& out) noexcept;

}  // namespace glenoid
