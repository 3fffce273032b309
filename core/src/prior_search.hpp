#pragma once

#include "glenoid/posture_prior.hpp"
#include "swivel_arcs.hpp"

namespace glenoid {

/// The posture within the limits that the prior finds least unlikely (docs/equations.md, P2): samples of each feasible arc with its
/// ends, then a golden-section search between the neighbours of each arc's best sample.
/// @return false when no arc holds a posture. @alloc none
bool most_likely_posture(const ArmModel& arm, const Vec3& target, const FeasibleSet& feasible,
                         const PosturePrior& prior, Posture& out) noexcept;

}  // namespace glenoid
