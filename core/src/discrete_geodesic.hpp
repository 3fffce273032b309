#pragma once

#include <array>
#include <vector>

#include "embedding.hpp"
#include "glenoid/path.hpp"
#include "kernels.hpp"
#include "lobatto.hpp"

namespace glenoid {

/// Discrete energy of a path on one Lobatto grid: value, gradient, exact Hessian (docs/equations.md, G1-G3), and optionally
/// a last node that may slide on the self-motion {wrist = target} (S3). All memory is taken at construction.
///
/// Call order: set_order, fill posture(k), set_free_end, evaluate; then assemble, factor, solve_step, move, accept in turn.
class DiscreteGeodesic {
 public:
  DiscreteGeodesic();

  void set_order(int order) noexcept;
  [[nodiscard]] int order() const noexcept { return grid_->order; }
  [[nodiscard]] const Lobatto& grid() const noexcept { return *grid_; }
  [[nodiscard]] Posture& posture(int k) noexcept { return current_->posture[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const Posture& posture(int k) const noexcept { return current_->posture[static_cast<std::size_t>(k)]; }
  /// Null: the last node is fixed.
  void set_free_end(const Vec3* target) noexcept;
  /// Bends the path upward (G7), m; 0 = a geodesic.
  void set_lift(double lift_m) noexcept { lift_ = lift_m; }

  /// Energy and forces at the current postures.
  void evaluate(const ArmModel& arm) noexcept;
  /// Hessian at the current postures; without curvature it is the Gauss-Newton matrix, always positive definite.
  void assemble(bool with_curvature) noexcept;
  [[nodiscard]] bool factor() noexcept;
  /// Newton step. @return directional derivative of the energy along it (negative).
  double solve_step() noexcept;
  /// Largest nodal change of the step, rad.
  [[nodiscard]] double step_size() const noexcept;
  /// Evaluates the postures moved by scale * step, to be kept by accept().
  void move(const ArmModel& arm, double scale) noexcept;
  void accept() noexcept;

  /// Energy of the last evaluation (evaluate or move), kg.m2.
  [[nodiscard]] double energy() const noexcept { return energy_; }
  /// What is minimised: the energy, less the lift's part (G7).
  [[nodiscard]] double action() const noexcept { return energy_ - raised_; }
  [[nodiscard]] double gradient_size() const noexcept;
  [[nodiscard]] Vec4 end_momentum() const noexcept;
  /// |cos| between the final momentum and the free direction of the last node.
  [[nodiscard]] double transversality() const noexcept;
  /// (max - min) / mean of 1/2 q'Mq' at the nodes; with a lift, of what is conserved then (G7).
  [[nodiscard]] double speed_variation() const noexcept;

  /// Order, energy and nodes; finish_path makes the rest of it.
  void store(GeodesicPath& path) const noexcept;

 private:
  static constexpr std::size_t kNodes = kMaxPathOrder + 1;
  struct State {
    std::array<Posture, kNodes> posture;
    std::array<EmbeddedNode, kNodes> node;
    alignas(32) double force[kNodes][kPadded];     ///< S * (mass F), padded
    alignas(32) double momentum[kNodes][kPadded];  ///< mass F, relative to the first node
    Vec4 free_direction;
    Eigen::Matrix<double, 3, 4> wrist;  ///< Jacobian of the wrist at the last node
    Vec4 end_gradient;
  };

  void evaluate(const ArmModel& arm, State& state) noexcept;
  void add_lift(const ArmModel& arm, State& state) noexcept;
  void prepare_free_end(const ArmModel& arm, State& state) noexcept;
  void project_end(const ArmModel& arm, Posture& end) const noexcept;
  [[nodiscard]] double free_curvature(const State& state) const noexcept;
  [[nodiscard]] int tiles() const noexcept { return order() - 1 + (free_end_ ? 1 : 0); }

  const Lobatto* grid_;
  std::vector<State> states_;
  State* current_;
  State* trial_;
  std::vector<Tile> hessian_;
  alignas(32) std::array<double, 4 * kNodes> step_{};
  alignas(32) std::array<double, 4 * kNodes> gradient_{};
  bool free_end_ = false;
  Vec3 target_ = Vec3::Zero();
  double upper_length_ = 0.0, forearm_length_ = 0.0;
  bool turning_ = false;                // whether the turning feature has a weight
  double energy_ = 0.0, raised_ = 0.0;  // raised: lift times the mean height of the masses over that of the first node
  double lift_ = 0.0;
  std::array<double, kNodes> height_{};  // of the masses at the nodes over that of the first one, kg.m
};

}  // namespace glenoid
