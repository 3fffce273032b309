#pragma once

#include <array>
#include <memory>

#include "glenoid/geodesic.hpp"
#include "glenoid/kinematics.hpp"
#include "glenoid/posture_prior.hpp"

namespace glenoid {

enum class SwivelMode : int { MinimumEnergy = 1, Prescribed = 2, HumanPrior = 3 };

/// One member of the family of final postures that reach the target, for plots.
struct FamilyMember {
  double swivel_rad = 0.0;
  Posture end;
  LimitMargin margin;
  double energy = 0.0;  ///< coarse energy of the path to it, kg.m2; NaN where it was not computed
};

inline constexpr int kMaxFamily = 512;

struct Family {
  int count = 0;
  std::array<FamilyMember, kMaxFamily> members;
};

struct ReachPlan {
  GeodesicPath path;
  Certificate certificate;
  double swivel_rad = 0.0;
  double reach_margin_m = 0.0;
  /// Best limit margin over the postures that reach the target: tells by how much LimitsInfeasible failed.
  LimitMargin best_margin;
};

/// From a posture and a wrist target to a path: which final posture (swivel angle) and the geodesic to it.
///
/// Owns the scratch memory: construct once, plan often; no allocation afterwards. One planner per thread.
class ReachPlanner {
 public:
  ReachPlanner();
  ~ReachPlanner();
  ReachPlanner(ReachPlanner&&) noexcept;
  ReachPlanner& operator=(ReachPlanner&&) noexcept;

  /// Globally least energy over all feasible swivel angles; docs/equations.md, S1-S4.
  /// @return NotFinite, TargetUnreachable, LimitsInfeasible, NoConvergence; the margins in `out` are valid for these too.
  Status plan_minimum_energy(const ArmModel& arm, const Posture& start, const Vec3& target, ReachPlan& out) noexcept;

  /// As plan_minimum_energy for a target near that of an earlier path: the minimum that continues it is found by one local
  /// solution; the global search runs only where that leaves the limits or does not converge (docs/equations.md, S5).
  /// @param previous  path that `start` lies on, at previous_lambda; may be out.path
  Status replan_minimum_energy(const ArmModel& arm, const Posture& start, const Vec3& target,
                               const GeodesicPath& previous, double previous_lambda, ReachPlan& out) noexcept;

  /// The posture with the given swivel angle that is nearest to the start in energy.
  Status plan_prescribed(const ArmModel& arm, const Posture& start, const Vec3& target, double swivel_rad,
                         ReachPlan& out) noexcept;

  /// The posture within the limits that the prior finds least unlikely, on a path lifted as it says (docs/equations.md, P1-P3).
  Status plan_human_prior(const ArmModel& arm, const Posture& start, const Vec3& target, const PosturePrior& prior,
                          ReachPlan& out) noexcept;

  /// Given end posture. The wrist target is that of the end posture. @param lift_m  bends the path upward (G7)
  Status plan_between(const ArmModel& arm, const Posture& start, const Posture& end, ReachPlan& out,
                      double lift_m = 0.0) noexcept;

  /// Family of final postures over the whole self-motion with energies of the paths to them, `count` (2..kMaxFamily) of
  /// them, ordered by swivel angle. @return also OutOfRange for a bad count.
  Status sample_family(const ArmModel& arm, const Posture& start, const Vec3& target, int count, Family& out) noexcept;

  struct Workspace;

 private:
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace glenoid
