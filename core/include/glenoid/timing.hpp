#pragma once

namespace glenoid {

enum class TimingLaw : int {
  MinimumJerkRiemannian = 1,  ///< minimum jerk of the Riemannian arc length (docs/equations.md, T1)
  MinimumJerkHand = 2,        ///< minimum jerk of the hand's arc length (T2)
  MinimumJerkHoming = 3,      ///< minimum jerk of the Riemannian arc length with a homing tail in slow movements (T5)
};

/// Value with first and second derivative.
struct ScalarJet {
  double value = 0.0, d1 = 0.0, d2 = 0.0;
};

/// s(u) = 10u^3 - 15u^4 + 6u^5 for u = (t - start)/duration clamped to [0, 1]; derivatives with respect to t. T1.
ScalarJet minimum_jerk(double t, double start, double duration) noexcept;

inline constexpr double kHomingTail = 0.8;  // per unit of ln(duration / 1 s); fitted to measured reaches, T5

/// Minimum jerk that peaks early: s(u + b u (1 - u)) with b = tail ln(duration / 1 s) in 0..0.6; derivatives with respect to t.
/// At rest with zero acceleration at both ends, monotone. T5.
ScalarJet homing_minimum_jerk(double t, double start, double duration, double tail = kHomingTail) noexcept;

/// Quintic that starts at (0, v, a) and rests at 0 after `duration`: what is left of an earlier motion when a new one starts.
/// Together with minimum_jerk it is the minimum-jerk motion from a moving state (T3).
ScalarJet fading_motion(double t, double start, double duration, double v, double a) noexcept;

/// Virtual clock of a controlled stop: runs at rate 1 until `start`, comes smoothly to a halt within `duration` and stays.
/// Returned: virtual time, its rate and its second derivative (T4).
ScalarJet stopping_clock(double t, double start, double duration) noexcept;

}  // namespace glenoid
