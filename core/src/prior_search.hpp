#pragma once

#include "swivel_arcs.hpp"

namespace glenoid {

/// The posture within the limits whose swivel angle is nearest to the given one (docs/equations.md, P2): samples of each
/// feasible arc with its ends, then a golden-section search between the best sample's neighbours.
/// @return false when no arc holds a posture. @alloc none
bool nearest_feasible_posture(const ArmModel& arm, const Vec3& target, const FeasibleSet& feasible, double swivel_rad,
                              Posture& out) noexcept;

}  // namespace glenoid
