#include "discrete_geodesic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace glenoid {
namespace {

using V4 [[gnu::vector_size(32)]] = double;

Vec4 transpose_times(const double (&J)[kEmbedding][4], const double* f, bool turning) {
  return with_rows(turning, [&J, f](auto rows) -> Vec4 {
    V4 g{};
    for (int i = 0; i < rows; ++i) g += *reinterpret_cast<const V4*>(J[i]) * f[i];
    return {g[0], g[1], g[2], g[3]};
  });
}

/// Unit null vector of the 3x4 wrist Jacobian; the axial rotation where the arm is straight.
Vec4 null_direction(const Eigen::Matrix<double, 3, 4>& J) {
  const auto minor = [&J](int a, int b, int c) { return J.col(a).dot(J.col(b).cross(J.col(c))); };
  const Vec4 n(minor(1, 2, 3), -minor(0, 2, 3), minor(0, 1, 3), -minor(0, 1, 2));
  const double size = n.norm();
  return size > 1e-14 ? Vec4(n / size) : Vec4(Vec4::UnitZ());
}

/// (J J^T)^-1 v, slightly regularised: at the straight arm the wrist cannot move outwards.
Vec3 solve_gram(const Eigen::Matrix<double, 3, 4>& J, const Vec3& v) {
  Mat3 A = J * J.transpose();
  A.diagonal().array() += 1e-12;
  return A.ldlt().solve(v);
}

}  // namespace

DiscreteGeodesic::DiscreteGeodesic()
    : grid_(&lobatto(8)),
      states_(2),
      current_(&states_[0]),
      trial_(&states_[1]),
      hessian_(static_cast<std::size_t>(tile_index(kMaxPathOrder, 0))) {}

void DiscreteGeodesic::set_order(int order) noexcept { grid_ = &lobatto(order); }

void DiscreteGeodesic::set_free_end(const Vec3* target) noexcept {
  free_end_ = target != nullptr;
  if (free_end_) target_ = *target;
}

void DiscreteGeodesic::evaluate(const ArmModel& arm) noexcept {
  upper_length_ = arm.upper_arm.length_m;
  forearm_length_ = arm.forearm.length_m;
  turning_ = arm.turning_kg_m2 != 0.0;
  if (free_end_) project_end(arm, posture(order()));
  evaluate(arm, *current_);
}

void DiscreteGeodesic::evaluate(const ArmModel& arm, State& s) noexcept {
  const auto count = static_cast<std::size_t>(order()) + 1;
  for (std::size_t k = 0; k < count; ++k) {
    embed(arm, s.posture[k], free_end_ && k + 1 == count, s.node[k]);
    // relative to the first node: S annihilates constants, and rounding then scales with the displacement
    with_rows(turning_, [&s, k](auto rows) {
      for (int i = 0; i < rows; ++i) s.momentum[k][i] = s.node[k].MF[i] - s.node[0].MF[i];
      for (int i = rows; i < kPadded; ++i) s.momentum[k][i] = 0.0;
    });
  }
  apply_to_nodes(grid_->stiffness.data(), s.momentum, order() + 1, s.force);
  energy_ = 0.0;
  for (std::size_t k = 1; k < count; ++k) {
    with_rows(turning_, [this, &s, k](auto rows) {
      for (int i = 0; i < rows; ++i) energy_ += 0.5 * (s.node[k].F[i] - s.node[0].F[i]) * s.force[k][i];
    });
  }
  raised_ = 0.0;
  if (lift_ != 0.0) add_lift(arm, s);
  s.end_gradient = transpose_times(s.node[count - 1].J, s.force[count - 1], turning_);
  if (free_end_) prepare_free_end(arm, s);
}

/// The height of the masses is linear in F: its forces are constant, one on z_U.z and one on z_F.z.
void DiscreteGeodesic::add_lift(const ArmModel& arm, State& s) noexcept {
  constexpr int kUpper = 11, kForearm = 17;  // rows of F
  const MassMoments moments = mass_moments(arm);
  const double* first = s.node[0].F;
  for (std::size_t k = 0; k <= static_cast<std::size_t>(order()); ++k) {
    const double* F = s.node[k].F;
    const double weight = lift_ * grid_->weight[k];
    height_[k] = moments.upper * (first[kUpper] - F[kUpper]) + moments.forearm * (first[kForearm] - F[kForearm]);
    raised_ += weight * height_[k];
    s.force[k][kUpper] += weight * moments.upper;
    s.force[k][kForearm] += weight * moments.forearm;
  }
}

void DiscreteGeodesic::prepare_free_end(const ArmModel& arm, State& s) noexcept {
  s.wrist = wrist_jacobian(arm, s.node[static_cast<std::size_t>(order())]);
  s.free_direction = null_direction(s.wrist);
}

void DiscreteGeodesic::project_end(const ArmModel& arm, Posture& end) const noexcept {
  constexpr int kPasses = 8;
  for (int i = 0; i < kPasses; ++i) {
    EmbeddedNode node;
    embed(arm, end, true, node);
    const Vec3 wrist = node.shoulder.p_TS - arm.upper_arm.length_m * node.R.col(2) -
                       arm.forearm.length_m * node.R_F.col(2);
    const Vec3 error = target_ - wrist;
    if (error.squaredNorm() < 1e-28) return;
    const auto J = wrist_jacobian(arm, node);
    end = retract(end, J.transpose() * solve_gram(J, error));
  }
}

double DiscreteGeodesic::free_curvature(const State& s) const noexcept {
  const auto last = static_cast<std::size_t>(order());
  const Vec3 multiplier = solve_gram(s.wrist, s.wrist * s.end_gradient);
  double force[kEmbedding];
  std::copy(s.force[last], s.force[last] + kEmbedding, force);
  for (int r = 0; r < 3; ++r) {
    force[r] -= multiplier[r];
    force[9 + r] += upper_length_ * multiplier[r];
    force[15 + r] += forearm_length_ * multiplier[r];
  }
  const Mat4 H = embedding_curvature(s.node[last], force, true, turning_);
  return s.free_direction.dot(H * s.free_direction);
}

void DiscreteGeodesic::assemble(bool with_curvature) noexcept {
  const State& s = *current_;
  const int n = order();
  const auto count = static_cast<std::size_t>(n) + 1;
  const bool shoulder = s.node[1].MJ[0][0] != 0.0 || s.node[1].MJ[0][1] != 0.0 || s.node[1].F[0] != 0.0;
  for (int j = 1; j < n; ++j) {
    const auto row = static_cast<std::size_t>(j);
    Tile* tile = hessian_.data() + tile_index(j - 1, 0);
    gram_row(s.node[row], &s.node[1], &grid_->stiffness[row * count + 1], j, turning_, tile);
    if (with_curvature) {
      const Mat4 H = embedding_curvature(s.node[row], s.force[row], shoulder, turning_);
      for (int a = 0; a < 4; ++a) {
        for (int b = 0; b < 4; ++b) tile[j - 1].c[a][b] += H(b, a);
      }
    }
  }
  if (!free_end_) return;

  // The last block has one variable, the slide along the free direction; the other three are padding.
  const auto last = static_cast<std::size_t>(n);
  Tile* tile = hessian_.data() + tile_index(n - 1, 0);
  const auto reduce = [&s](Tile& T) {
    for (auto& column : T.c) {
      double sum = 0.0;
      for (int a = 0; a < 4; ++a) sum += s.free_direction[a] * column[a];
      column[0] = sum;
      column[1] = column[2] = column[3] = 0.0;
    }
  };
  gram_row(s.node[last], &s.node[1], &grid_->stiffness[last * count + 1], n, turning_, tile);
  for (int k = 0; k + 1 < n; ++k) reduce(tile[k]);
  Tile& corner = tile[n - 1];
  double own = 0.0;
  for (int a = 0; a < 4; ++a) {
    for (int b = 0; b < 4; ++b) own += s.free_direction[a] * corner.c[a][b] * s.free_direction[b];
  }
  if (with_curvature) own += free_curvature(s);
  corner = Tile{};
  corner.c[0][0] = own;
  for (int a = 1; a < 4; ++a) corner.c[a][a] = 1.0;
}

bool DiscreteGeodesic::factor() noexcept { return tiled_cholesky(hessian_.data(), tiles()); }

double DiscreteGeodesic::solve_step() noexcept {
  const State& s = *current_;
  const auto size = static_cast<std::size_t>(4 * tiles());
  for (std::size_t k = 1; 4 * k <= size; ++k) {
    const Vec4 g = transpose_times(s.node[k].J, s.force[k], turning_);
    std::copy(g.data(), g.data() + 4, &gradient_[4 * (k - 1)]);
  }
  if (free_end_) {
    double* g = &gradient_[size - 4];
    g[0] = s.end_gradient.dot(s.free_direction);
    g[1] = g[2] = g[3] = 0.0;
  }
  for (std::size_t i = 0; i < size; ++i) step_[i] = -gradient_[i];
  tiled_solve(hessian_.data(), tiles(), step_.data());
  double slope = 0.0;
  for (std::size_t i = 0; i < size; ++i) slope += step_[i] * gradient_[i];
  return slope;
}

double DiscreteGeodesic::step_size() const noexcept {
  const auto size = static_cast<std::size_t>(4 * tiles());
  double largest = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    if (!(std::abs(step_[i]) <= largest)) largest = std::abs(step_[i]);
  }
  return largest;
}

void DiscreteGeodesic::move(const ArmModel& arm, double scale) noexcept {
  const int n = order();
  const auto last = static_cast<std::size_t>(n);
  trial_->posture[0] = current_->posture[0];
  for (int k = 1; k < n; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double* d = &step_[4 * (i - 1)];
    trial_->posture[i] = retract(current_->posture[i], scale * Vec4(d[0], d[1], d[2], d[3]));
  }
  trial_->posture[last] = current_->posture[last];
  if (free_end_) {
    trial_->posture[last] = retract(current_->posture[last], scale * step_[4 * (last - 1)] * current_->free_direction);
    project_end(arm, trial_->posture[last]);
  }
  evaluate(arm, *trial_);
}

void DiscreteGeodesic::accept() noexcept { std::swap(current_, trial_); }

double DiscreteGeodesic::gradient_size() const noexcept {
  double largest = 0.0;
  for (int k = 1; k < order(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    largest = std::max(largest,
                       transpose_times(current_->node[i].J, current_->force[i], turning_).cwiseAbs().maxCoeff());
  }
  return largest;
}

Vec4 DiscreteGeodesic::end_momentum() const noexcept { return current_->end_gradient; }

double DiscreteGeodesic::transversality() const noexcept {
  const double size = current_->end_gradient.norm();
  return size > 0.0 ? std::abs(current_->end_gradient.dot(current_->free_direction)) / size : 0.0;
}

double DiscreteGeodesic::speed_variation() const noexcept {
  alignas(32) double shift[kNodes][kPadded], velocity[kNodes][kPadded], momentum[kNodes][kPadded];
  const int count = order() + 1, rows = turning_ ? kEmbedding : kColumns;
  const auto& node = current_->node;
  for (int k = 0; k < count; ++k) {
    const double* F = node[static_cast<std::size_t>(k)].F;
    for (int i = 0; i < kPadded; ++i) shift[k][i] = i < rows ? F[i] - node[0].F[i] : 0.0;
  }
  apply_to_nodes(grid_->derivative.data(), shift, count, velocity);
  apply_to_nodes(grid_->derivative.data(), current_->momentum, count, momentum);
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (int k = 0; k < count; ++k) {
    double twice = 0.0;
    for (int i = 0; i < kPadded; ++i) twice += velocity[k][i] * momentum[k][i];
    const double conserved = 0.5 * twice + (lift_ != 0.0 ? lift_ * height_[static_cast<std::size_t>(k)] : 0.0);
    least = std::min(least, conserved);
    most = std::max(most, conserved);
  }
  return energy_ > 0.0 ? (most - least) / energy_ : 0.0;
}

void DiscreteGeodesic::store(GeodesicPath& path) const noexcept {
  path.order = order();
  path.energy = energy_;
  path.lift_m = lift_;
  for (int k = 0; k <= order(); ++k) path.nodes[static_cast<std::size_t>(k)] = posture(k);
}

}  // namespace glenoid
