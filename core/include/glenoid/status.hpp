#pragma once

namespace glenoid {

/// Result of a run-time function of the core. Numbers are fixed for life.
enum class [[nodiscard]] Status : int{
    Ok = 0,
    NotFinite = 1,          ///< an argument is NaN or infinite
    OutOfRange = 2,         ///< an argument lies outside its documented range
    TargetUnreachable = 3,  ///< no posture puts the wrist there
    LimitsInfeasible = 4,   ///< postures reach the target, but none within the joint limits
    ExoInfeasible = 5,      ///< the exoskeleton cannot follow the whole path
    NoConvergence = 6,      ///< the boundary-value solver did not converge
    NotAvailable = 7,       ///< a model that this version does not have
};

/// Short name of a status, as printed by programs ("Ok", "TargetUnreachable", ...). Never null.
const char* to_string(Status status) noexcept;

}  // namespace glenoid
