#pragma once

#include "glenoid/motion.hpp"
#include "variables.hpp"

namespace glenoid::fmu {

/// The only place where names of the description meet members of the core. Units agree (SI, rad): values are copied.
MotionSettings settings_from(const Values& values);
MotionCommand command_from(const Values& values) noexcept;
void store(double time_s, const MotionSample& sample, Values& values) noexcept;

/// Time derivative of an output: q (orders 1, 2), dq (order 1), exo.q (orders 1, 2), exo.dq (order 1).
/// @return false for every other output or order; then `value` is unchanged.
bool output_derivative(const MotionSample& sample, int index, int order, double& value) noexcept;

/// Whether two sets of values agree in every fixed parameter, bit for bit.
bool same_fixed_parameters(const Values& a, const Values& b) noexcept;

}  // namespace glenoid::fmu
