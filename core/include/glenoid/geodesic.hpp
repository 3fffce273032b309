#pragma once

#include <memory>

#include "glenoid/arm_model.hpp"
#include "glenoid/path.hpp"
#include "glenoid/status.hpp"

namespace glenoid {

/// Where a path leaves the joint limits; a geodesic knows none.
struct LimitViolation {
  bool any = false;
  LimitMargin worst;    ///< least margin on the way, negative = outside
  double lambda = 0.0;  ///< where the worst is
};

/// What was shown about a path. It is part of every result and is never hidden from the user.
struct Certificate {
  double newton_step_rad = 0.0;   ///< largest nodal change of the last full Newton step
  double gradient = 0.0;          ///< largest component of the energy gradient at the nodes, kg.m2/rad
  bool hessian_positive = false;  ///< second variation positive definite: a strict local minimum, no conjugate point
  double spectral_tail = 0.0;     ///< size of the last Legendre coefficients: interpolation error estimate
  double speed_variation = 0.0;  ///< (max - min)/mean of 1/2 q'Mq' (G7: and the lift's part) along the path; 0 in theory
  double hand_error_m = 0.0;     ///< distance of the final wrist from the target
  double transversality = 0.0;   ///< |cos| between the final momentum and the free direction; 0 at an interior minimum
  bool swivel_at_limit = false;     ///< the minimum lies at a joint limit; then the energy rises into the feasible side
  double rotation_angle_rad = 0.0;  ///< angle of R_0^T R_1
  bool long_way = false;            ///< the path turns the other way round than the short rotation (homotopy class)
  int order = 0;                    ///< intervals of the finest grid
  int iterations = 0;               ///< Newton steps over all grids
  LimitViolation limits;
};

/// Grids up to this order give sketches: paths with nodes only (see finish_path) and a certificate without tail, gradient
/// and speed variation.
inline constexpr int kSketchOrder = 12;

struct GeodesicOptions {
  double tail_tolerance = 1e-7;  ///< refine until spectral_tail is below this
  int first_order = 8;           ///< grid of the first, loose solution; orders are 6, 8, 12, 16, 20, 24, 32, 40, 48, 64
  int max_order = kMaxPathOrder;  ///< the finest grid that may be used; up to kSketchOrder the result is a sketch
  double step_tolerance = 1e-6;  ///< rad; a full Newton step below this ends the iteration, what is left is about its square
  bool long_way = false;         ///< a cold start turns the long way round: the other homotopy class
  double lift_m = 0.0;           ///< bends the path upward (G7), m; 0 = a geodesic
  bool quick = false;  ///< give up after a dozen steps on one grid, or far from resolved at order 16, without other starts
};

/// Rotations beyond it may have a cheaper geodesic the long way round, rad.
inline constexpr double kWideRotation = 2.4;

/// Geodesics of the arm's kinetic-energy metric between two postures, on SO(3) x R; docs/equations.md, G1-G6.
///
/// Owns the scratch memory: construct once, solve often; no allocation afterwards. One solver per thread.
class GeodesicSolver {
 public:
  GeodesicSolver();
  ~GeodesicSolver();
  GeodesicSolver(GeodesicSolver&&) noexcept;
  GeodesicSolver& operator=(GeodesicSolver&&) noexcept;

  /// Path from start to end in the short rotation class (or the other class where only that converges).
  /// @return NotFinite, NoConvergence. `path` and `certificate` are valid only for Ok.
  /// @alloc none
  /// @param warm  an earlier path between nearby postures to start from, or null; may be the same object as `path`.
  ///              A sketch of another order than options.first_order must have been finished.
  Status solve(const ArmModel& arm, const Posture& start, const Posture& end, const GeodesicOptions& options,
               const GeodesicPath* warm, GeodesicPath& path, Certificate& certificate) noexcept;

  /// The cheaper of the two classes where the rotation is wider than kWideRotation, else as solve from a cold start.
  Status solve_cheapest(const ArmModel& arm, const Posture& start, const Posture& end, const GeodesicOptions& options,
                        GeodesicPath& path, Certificate& certificate) noexcept;

  /// As solve, with the last node free to move on the self-motion {wrist = target}: a local minimum of the energy over the
  /// swivel angle, from the posture `guess` (docs/equations.md, S3).
  Status solve_free_end(const ArmModel& arm, const Posture& start, const Posture& guess, const Vec3& target,
                        const GeodesicOptions& options, const GeodesicPath* warm, GeodesicPath& path,
                        Certificate& certificate) noexcept;

  /// Energy gradient with respect to the end posture of the last solution, in body coordinates of that posture
  /// (delta, dphi): the final momentum p(1), kg.m2. Exact for the discrete path.
  [[nodiscard]] Vec4 end_momentum() const noexcept;

  struct Workspace;

 private:
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace glenoid
