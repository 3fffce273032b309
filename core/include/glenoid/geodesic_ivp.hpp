#pragma once

#include <vector>

#include "glenoid/arm_model.hpp"
#include "glenoid/status.hpp"

namespace glenoid {

struct FollowOptions {
  double relative_tolerance = 1e-11;
  double absolute_tolerance = 1e-12;
  bool stiff = false;   ///< BDF instead of Adams
  int samples = 101;    ///< uniform in lambda over [0, 1], at least 2
  double lift_m = 0.0;  ///< of the path that is followed (G7)
};

struct FollowResult {
  std::vector<Posture> postures;  ///< at the samples
  PostureRates end_rates;         ///< d/dlambda at lambda = 1
  double energy_drift = 0.0;  ///< largest change since the start of what is conserved, 1/2 q'Mq' and the lift's part, per 1/2 q'Mq'
  long steps = 0;
};

/// Exponential map: the geodesic that leaves `start` with `rates` (per unit lambda), integrated by SUNDIALS CVODE.
///
/// Equation  M4 with R' = R [w]x, integrated chart-free (unit quaternion and elbow angle).
/// An independent check of the boundary-value solution: shot with its own initial rates, it must arrive at its end.
///
/// @return NotFinite, OutOfRange (samples < 2), NoConvergence when the integrator stops.
/// Allocates; not for the control loop.
Status follow_geodesic(const ArmModel& arm, const Posture& start, const PostureRates& rates,
                       const FollowOptions& options, FollowResult& out);

}  // namespace glenoid
