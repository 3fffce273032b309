#pragma once

#include "glenoid/motion.hpp"

namespace glenoid {

/// Posture of a movement with derivatives with respect to the movement's own time (T1-T3); a stop is not part of it.
/// @param[out] progress  lambda and its derivatives; null if not wanted
void movement_jet(const MotionState& state, double time_s, PostureJet& out, ScalarJet* progress) noexcept;

/// Posture at a time of the importer: the movement on its stopping clock (T4).
void motion_jet(const MotionState& state, double time_s, PostureJet& out, ScalarJet& progress) noexcept;

/// Whether the arm rests at this time and from then on.
bool at_rest(const MotionState& state, double time_s) noexcept;

/// Body rates (w_TU_U, phi') and their derivatives.
void body_rates(const PostureJet& jet, PostureRates& rates, PostureRates& accelerations) noexcept;

/// Posture of a jet.
Posture jet_posture(const PostureJet& jet) noexcept;

}  // namespace glenoid
