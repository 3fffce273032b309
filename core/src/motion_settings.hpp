#pragma once

#include "glenoid/motion.hpp"

namespace glenoid {

inline constexpr double kLeastDuration = 0.05, kMostDuration = 60.0;  // s, of a movement

/// A point mirrored into the right-arm frame and back.
inline Vec3 mirror_if(bool left, const Vec3& p) { return left ? Vec3(-p.x(), p.y(), p.z()) : p; }

/// Checks what scale_subject, Rhythm, JointLimits and ExoModel do not check themselves.
/// @throws std::invalid_argument with one line per problem: variable, value, unit, rule.
void validate(const MotionSettings& settings, double start_time_s);

/// The start posture must respect the limits; the message names the angle that does not.
void validate_start(const ArmModel& arm, const Vec4& start_q);

/// Arm model of the settings, its rhythm anchored at the measured shoulder centre where there is one.
ArmModel build_arm(const MotionSettings& settings, const ScaledArm& scaled);

/// Whether a state can have come from a generator: everything finite and in range.
bool is_valid(const MotionState& state) noexcept;

}  // namespace glenoid
