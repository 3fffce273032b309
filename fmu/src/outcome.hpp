#pragma once

namespace glenoid::fmu {

/// Result of a call. The numbers are those of fmi2Status and fmi3Status, so that the APIs only cast.
///
/// Discard: refused, and the instance is exactly as before the call. Error: the instance is over until reset or until a
/// saved state is restored. Fatal is never used: it would condemn all instances, and there is no global state.
enum class [[nodiscard]] Outcome : int{Ok = 0, Warning = 1, Discard = 2, Error = 3};

}  // namespace glenoid::fmu
