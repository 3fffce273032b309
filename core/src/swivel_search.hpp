#pragma once

#include <array>

#include "glenoid/swivel.hpp"
#include "swivel_arcs.hpp"

namespace glenoid {

/// Coarse energy at one posture of an arc.
struct EnergySample {
  double psi = 0.0, opening = 0.0;
  double energy = 0.0, slope = 0.0;  ///< slope: d energy / d psi
  double rotation = 0.0;             ///< angle from the start, rad
  Posture posture;
  Vec4 momentum = Vec4::Zero();  ///< p(1), body coordinates of the posture
  GeodesicPath path;
};

struct Candidate {
  double energy = 0.0;  ///< estimated
  double psi = 0.0;
  int arc = 0;
  int nearest = 0;  ///< place of the energy sample to start from
  int cell = 0;     ///< place of the sample at the begin of its cell; interior candidates only
  int edge = 0;     ///< -1 begin, +1 end, 0 interior
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
  ReachPlan trial;  ///< scratch for callers between calls

 private:
  // cells of 25 deg, or 8 deg where two geodesics may compete, over one turn in at most kMaxArcs arcs
  static constexpr int kMaxSamples = 64;
  static constexpr int kMaxCandidates = 32;

  [[nodiscard]] const SelfMotionLoop& loop_of(int arc) const;
  /// Sample by its place along the arcs.
  EnergySample& sample(int place) {
    return samples_[static_cast<std::size_t>(order_[static_cast<std::size_t>(place)])];
  }
  [[nodiscard]] bool contested(const EnergySample& sample) const noexcept;
  bool sample_energy(const ArmModel& arm, const Posture& start, const Vec3& target, const SelfMotionLoop& loop,
                     const GeodesicOptions& options, EnergySample* beside, EnergySample& sample);
  EnergySample* add_sample(const ArmModel& arm, const Posture& start, const Vec3& target, int arc, double psi,
                           EnergySample* beside);
  void sweep(const ArmModel& arm, const Posture& start, const Vec3& target, int arc, double end, EnergySample* beside);
  bool try_cold(const ArmModel& arm, const Posture& start, const GeodesicOptions& options, bool solved,
                EnergySample& sample);
  void sample_arc(const ArmModel& arm, const Posture& start, const Vec3& target, int arc);
  void find_candidates(int arc, int first);
  void add_candidate(const Candidate& candidate);
  Status refine(const ArmModel& arm, const Posture& start, const Vec3& target, const Candidate& candidate,
                ReachPlan& out);
  Status refine_interior(const ArmModel& arm, const Posture& start, const Vec3& target, const Posture& guess,
                         const GeodesicPath& warm, ReachPlan& out);
  Status refine_cell(const ArmModel& arm, const Posture& start, const Vec3& target, const Candidate& candidate,
                     ReachPlan& out);
  bool narrow_cell(const ArmModel& arm, const Posture& start, const Vec3& target, const SelfMotionLoop& loop,
                   const GeodesicOptions& options, double width);
  Status refine_edge(const ArmModel& arm, const Posture& start, const Vec3& target, int arc, int edge,
                     const GeodesicPath* warm, ReachPlan& out);
  Status best_edge(const ArmModel& arm, const Posture& start, const Vec3& target, int arc, ReachPlan& out);
  Status fall_back(const ArmModel& arm, const Posture& start, ReachPlan& out);

  FeasibleSet set_;
  std::array<EnergySample, kMaxSamples> samples_;
  std::array<int, kMaxSamples> order_;  ///< of the samples: along each arc
  int sample_count_ = 0;
  double least_ = 0.0;  ///< energy of the cheapest sample so far
  std::array<Candidate, kMaxCandidates> candidates_;
  int candidate_count_ = 0;
  EnergySample low_, high_, middle_;  ///< bracket of a minimum inside a cell
  ReachPlan edge_, edges_;
  EnergySample coarse_;
  GeodesicPath scratch_;
};

/// Fills what a finished path tells about the reach: hand error, swivel angle, limits on the way.
void describe_reach(const ArmModel& arm, const Vec3& target, ReachPlan& plan) noexcept;

}  // namespace glenoid
