#pragma once

#include <array>

#include "glenoid/arm_model.hpp"
#include "glenoid/path.hpp"
#include "glenoid/timing.hpp"

namespace glenoid {

/// lambda as a function of the fraction of the hand's way, for minimum jerk along the hand path (docs/equations.md, T2).
struct HandClock {
  static constexpr int kOrder = 40;
  std::array<double, kOrder + 1> legendre{};  ///< coefficients of lambda(h), h in [0, 1]
};

/// Fits the clock of a path. @return false where the hand hardly moves or almost pauses on the way, so that its way is no
/// usable clock (the caller then keeps the Riemannian one). @alloc none
bool fit_hand_clock(const ArmModel& arm, const GeodesicPath& path, HandClock& out) noexcept;

/// lambda at hand fraction h, with derivatives with respect to h.
ScalarJet hand_lambda(const HandClock& clock, double h) noexcept;

}  // namespace glenoid
