#pragma once

#include <array>

#include "glenoid/swivel.hpp"
#include "swivel_arcs.hpp"

namespace glenoid {

/// Coarse energy at one posture of an arc.
struct EnergySample {
  double psi = 0.0, opening = 0.0;
  double energy = 0.0, slope = 0.0;   ///< slope: d energy / d psi
  Posture posture;
  GeodesicPath path;
};

struct Candidate {
  double energy = 0.0;     ///< estimated
  double psi = 0.0;
  int arc = 0;
  int nearest = 0;         ///< index of the energy sample to start from
  int edge = 0;            ///< -1 begin, +1 end, 0 interior
};

/// Global search for the swivel angle of least energy (docs/equations.md, S1-S4): scratch memory and its steps.
class SwivelSearch {
 public:
  /// Finds the feasible arcs. @return NotFinite, TargetUnreachable, LimitsInfeasible; margins in `out` are set.
  Status prepare(const ArmModel& arm, const Posture& start, const Vec3& target, ReachPlan& out) noexcept;
  /// Coarse energies, candidates and their refinement over the arcs that prepare() found.
  Status search(const ArmModel& arm, const Posture& start, const Vec3& target, ReachPlan& out) noexcept;

  [[nodiscard]] const FeasibleSet& feasible() const noexcept { return set_; }
  GeodesicSolver solver;
  ReachPlan trial;   ///< scratch for callers between calls

 private:
  // cells of 25 deg over one turn in at most kMaxArcs arcs
  static constexpr int kMaxSamples = 48;
  static constexpr int kMaxCandidates = 32;

  bool coarse_energy(const ArmModel& arm, const Posture& start, const Vec3& target, const SelfMotionLoop& loop,
                     const GeodesicPath* warm, EnergySample& sample);
  void sample_arc(const ArmModel& arm, const Posture& start, const Vec3& target, int arc);
  void find_candidates(int arc, int first);
  void add_candidate(const Candidate& candidate);
  Status refine(const ArmModel& arm, const Posture& start, const Vec3& target, const Candidate& candidate, ReachPlan& out);
  Status refine_edge(const ArmModel& arm, const Posture& start, const Vec3& target, int arc, int edge, ReachPlan& out);
  Status best_edge(const ArmModel& arm, const Posture& start, const Vec3& target, int arc, ReachPlan& out);
  Status fall_back(const ArmModel& arm, const Posture& start, ReachPlan& out);

  FeasibleSet set_;
  std::array<EnergySample, kMaxSamples> samples_;
  int sample_count_ = 0;
  std::array<Candidate, kMaxCandidates> candidates_;
  int candidate_count_ = 0;
  ReachPlan edge_;
  GeodesicPath scratch_;
};

/// Fills what a finished path tells about the reach: hand error, swivel angle, limits on the way.
void describe_reach(const ArmModel& arm, const Vec3& target, ReachPlan& plan) noexcept;

}  // namespace glenoid
