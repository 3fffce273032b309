#pragma once

#include "glenoid/geodesic.hpp"

namespace glenoid::test {

/// What a brute-force sweep over the swivel angle finds; independent of the planner's choice of candidates.
struct Reference {
  bool reachable = false;
  bool feasible = false;
  int widest_arc = 0;       ///< largest number of consecutive swivel angles with a feasible posture
  double energy = 0.0;      ///< least energy over all feasible postures, kg.m2
  double swivel_rad = 0.0;  ///< where it is
  int unsolved = 0;         ///< feasible postures to which no geodesic was found
};

/// Sweeps `count` swivel angles, all solutions of each, inside the limits; energies converged to about 1e-9 relative.
Reference sweep_swivel(const ArmModel& arm, const Posture& start, const Vec3& target, int count, GeodesicSolver& solver);

/// Energy of the geodesic between two postures, converged to about 1e-9 relative; infinity when there is none. There may be several
/// geodesics between distant postures: with `near`, the one beside that path.
double converged_energy(const ArmModel& arm, const Posture& start, const Posture& end, GeodesicSolver& solver,
                        const GeodesicPath* near = nullptr);

}  // namespace glenoid::test
