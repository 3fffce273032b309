#include "glenoid/geodesic.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "discrete_geodesic.hpp"
#include "glenoid/kinematics.hpp"

namespace glenoid {
namespace {

constexpr int kMaxIterations = 40;  // per grid
constexpr int kQuickIterations = 12;
constexpr double kLooseStep = 3e-2;  // rad; for grids that are refined anyway
constexpr double kStepCap = 0.6;     // rad; largest nodal change of one step
constexpr double kArmijo = 1e-4;
constexpr double kQuadraticZone = 1e-4;    // rad; full steps below it are taken as they are
constexpr double kChordZone = 3e-2;        // rad; after a full step below it the same factor serves for further ones
constexpr double kChordContraction = 0.1;  // a further step must be this much smaller, else the Hessian is computed anew
constexpr double kChordTolerance = 0.1;    // of the tolerance of a full step: a further step converges linearly only
constexpr double kSaddleStep = 1e-6;       // rad; what a step must reach where the Hessian is not positive definite
constexpr double kLeastDamping = 1e-3;
constexpr double kUnresolved = 1e-2;  // spectral tail of a path that the finest grid does not resolve
constexpr double kHopeless = 2.5;     // times the energy in hand: a first guess beyond it does not become cheaper
constexpr int kFirstCertified = 16;   // coarser grids are always refined
constexpr int kRetryOrder = 24;       // first grid of a second attempt in the short class

bool finite(const Posture& p) { return p.R_TU.allFinite() && std::isfinite(p.phi); }

/// Rotation from a to b, in the short class or the long way round.
Vec3 rotation_between(const Mat3& a, const Mat3& b, bool long_way) {
  Vec3 v = rotation_vector(a.transpose() * b);
  if (long_way) {
    const double angle = v.norm();
    const Vec3 axis = angle > 1e-9 ? Vec3(v / angle) : Vec3(Vec3::UnitZ());
    v = axis * (angle - 2.0 * kPi);
  }
  return v;
}

void slerp_guess(DiscreteGeodesic& d, const Posture& a, const Posture& b, bool long_way) {
  const Vec3 v = rotation_between(a.R_TU, b.R_TU, long_way);
  const int n = d.order();
  for (int k = 0; k <= n; ++k) {
    const double t = d.grid().node[static_cast<std::size_t>(k)];
    d.posture(k) = {a.R_TU * rotation(t * v), (1.0 - t) * a.phi + t * b.phi};
  }
  d.posture(0) = a;
  d.posture(n) = b;
}

/// Nodes of an earlier path, bent so that its ends become a and b.
void warm_guess(DiscreteGeodesic& d, const GeodesicPath& warm, const Posture& a, const Posture& b) {
  const int n = d.order();
  const Posture &wa = warm.nodes[0], &wb = warm.nodes[static_cast<std::size_t>(warm.order)];
  const Vec3 da = rotation_vector(wa.R_TU.transpose() * a.R_TU), db = rotation_vector(wb.R_TU.transpose() * b.R_TU);
  for (int k = 0; k <= n; ++k) {
    const double t = d.grid().node[static_cast<std::size_t>(k)];
    const Posture p = warm.order == n ? warm.nodes[static_cast<std::size_t>(k)] : path_posture(warm, t);
    d.posture(k) = {p.R_TU * rotation((1.0 - t) * da + t * db),
                    p.phi + (1.0 - t) * (a.phi - wa.phi) + t * (b.phi - wb.phi)};
  }
  d.posture(0) = a;
  d.posture(n) = b;
}

/// Newton's iteration on one grid (docs/equations.md, G4).
struct Newton {
  DiscreteGeodesic& d;
  const ArmModel& arm;
  Certificate& certificate;
  int most_iterations;

  /// One globalised step. @return size of the full step in rad, or a negative number if no descent was possible.
  double step() {
    d.assemble(true);
    bool positive = d.factor();
    if (!positive) {
      d.assemble(false);
      if (!d.factor()) return -1.0;
    }
    certificate.hessian_positive = positive;
    const double slope = d.solve_step();
    const double size = d.step_size();
    if (!std::isfinite(size)) return -1.0;
    double scale = std::min(1.0, kStepCap / std::max(size, 1e-300));
    const double before = d.action();
    const bool settled = positive && size < kQuadraticZone;  // there the energy cannot tell steps from rounding
    while (true) {
      d.move(arm, scale);
      if (settled || d.action() <= before + kArmijo * scale * slope) break;
      scale *= 0.5;
      if (scale < kLeastDamping) return -1.0;
    }
    d.accept();
    ++certificate.iterations;
    return size;
  }

  /// Steps with the factor at hand, as long as each is much smaller than the one before. @return size of the last one
  double chord(double size, double tolerance) {
    while (size >= tolerance) {
      d.solve_step();
      const double next = d.step_size();
      if (!(next < kChordContraction * size)) return size;
      d.move(arm, 1.0);
      d.accept();
      size = next;
    }
    return size;
  }

  /// Iterates until a full step is below `tolerance`.
  bool run(double tolerance) {
    d.evaluate(arm);
    for (int i = 0; i < most_iterations; ++i) {
      double size = step();
      if (size < 0.0) return false;
      if (certificate.hessian_positive && size < kChordZone) size = chord(size, kChordTolerance * tolerance);
      certificate.newton_step_rad = size;
      if (size < tolerance && (certificate.hessian_positive || size < kSaddleStep)) return true;
    }
    return false;
  }
};

/// Whether the nodes turn the other way round than the short rotation: follows a quaternion along them.
bool turns_long_way(const DiscreteGeodesic& d) {
  Eigen::Quaterniond previous(d.posture(0).R_TU), first = previous;
  for (int k = 1; k <= d.order(); ++k) {
    Eigen::Quaterniond q(d.posture(k).R_TU);
    if (q.dot(previous) < 0.0) q.coeffs() *= -1.0;
    previous = q;
  }
  return first.dot(previous) < 0.0;
}

/// Size of the Legendre coefficients of two degrees.
double coefficient_size(const GeodesicPath& path, int degree) {
  double size = 0.0;
  for (int n = degree - 1; n <= degree; ++n) {
    for (const double c : path.legendre[static_cast<std::size_t>(n)]) size = std::max(size, std::abs(c));
  }
  return size;
}

/// Order at which the coefficients will be below `tolerance`, if they go on falling as they did over the last eight degrees.
int next_order(const GeodesicPath& path, double tolerance) {
  if (path.order < kFirstCertified) return kFirstCertified;
  double size = coefficient_size(path, path.order);
  const double fall = std::sqrt(std::sqrt(size / coefficient_size(path, path.order - 8)));  // over two degrees
  int order = path.order + 1;
  for (; fall < 1.0 && size > tolerance && order < kMaxPathOrder; order += 2) size *= fall;
  return order;
}

}  // namespace

struct GeodesicSolver::Workspace {
  DiscreteGeodesic discrete;
  GeodesicPath other;  ///< of the class that was tried second
  Vec4 end_momentum = Vec4::Zero();

  double guess_energy(const ArmModel& arm, const Posture& start, const Posture& end, const GeodesicOptions& options);
  Status run(const ArmModel& arm, const Posture& start, const Posture& end, const Vec3* target,
             const GeodesicOptions& options, const GeodesicPath* warm, GeodesicPath& path, Certificate& c);
};

/// Energy of the path that a cold start begins with, kg.m2.
double GeodesicSolver::Workspace::guess_energy(const ArmModel& arm, const Posture& start, const Posture& end,
                                               const GeodesicOptions& options) {
  discrete.set_order(options.first_order);
  slerp_guess(discrete, start, end, options.long_way);
  discrete.set_free_end(nullptr);
  discrete.set_lift(0.0);
  discrete.evaluate(arm);
  return discrete.energy();
}

Status GeodesicSolver::Workspace::run(const ArmModel& arm, const Posture& start, const Posture& end, const Vec3* target,
                                      const GeodesicOptions& options, const GeodesicPath* warm, GeodesicPath& path,
                                      Certificate& c) {
  DiscreteGeodesic& d = discrete;
  d.set_order(std::min(options.first_order, options.max_order));
  if (warm != nullptr) {
    warm_guess(d, *warm, start, end);
  } else {
    slerp_guess(d, start, end, options.long_way);
  }
  d.set_free_end(target);
  d.set_lift(options.lift_m);
  const bool sketch = options.max_order <= kSketchOrder;
  while (true) {
    Newton newton{d, arm, c, options.quick ? kQuickIterations : kMaxIterations};
    const bool refine_anyway = d.order() < kFirstCertified && d.order() < options.max_order;
    const bool converged = newton.run(refine_anyway ? kLooseStep : options.step_tolerance);
    const bool last = d.order() >= options.max_order;
    if (!converged && (last || options.quick)) return Status::NoConvergence;
    d.store(path);
    if (last && sketch) break;
    finish_path(path);
    c.spectral_tail = coefficient_size(path, path.order);
    const bool done = converged && !refine_anyway && c.spectral_tail <= options.tail_tolerance;
    if ((last || (options.quick && !refine_anyway)) && c.spectral_tail > kUnresolved) {
      return Status::NoConvergence;  // a solution of the discrete problem, but not of the continuous one
    }
    if (done || last) break;
    d.set_order(std::min(next_order(path, options.tail_tolerance), options.max_order));
    for (int k = 0; k <= d.order(); ++k) {
      const bool fixed = k == 0 || k == d.order();
      d.posture(k) = fixed ? (k == 0 ? path.nodes[0] : path.nodes[static_cast<std::size_t>(path.order)])
                           : path_posture(path, d.grid().node[static_cast<std::size_t>(k)]);
    }
  }
  c.order = d.order();
  c.long_way = turns_long_way(d);
  end_momentum = d.end_momentum();
  if (!sketch) {
    c.gradient = d.gradient_size();
    c.speed_variation = d.speed_variation();
  }
  return Status::Ok;
}

GeodesicSolver::GeodesicSolver() : workspace_(std::make_unique<Workspace>()) {}
GeodesicSolver::~GeodesicSolver() = default;
GeodesicSolver::GeodesicSolver(GeodesicSolver&&) noexcept = default;
GeodesicSolver& GeodesicSolver::operator=(GeodesicSolver&&) noexcept = default;

Status GeodesicSolver::solve(const ArmModel& arm, const Posture& start, const Posture& end,
                             const GeodesicOptions& options, const GeodesicPath* warm, GeodesicPath& path,
                             Certificate& certificate) noexcept {
  if (!finite(start) || !finite(end)) return Status::NotFinite;
  Workspace& w = *workspace_;
  certificate = Certificate{};
  Status status = w.run(arm, start, end, nullptr, options, warm, path, certificate);
  if (status != Status::Ok && warm != nullptr)
    status = w.run(arm, start, end, nullptr, options, nullptr, path, certificate);
  GeodesicOptions other = options;
  if (status != Status::Ok && options.max_order > kRetryOrder) {
    other.first_order = kRetryOrder;
    status = w.run(arm, start, end, nullptr, other, nullptr, path, certificate);
  }
  if (status != Status::Ok) {
    other.long_way = !options.long_way;
    status = w.run(arm, start, end, nullptr, other, nullptr, path, certificate);
  }
  if (status != Status::Ok) return status;
  certificate.rotation_angle_rad = rotation_vector(start.R_TU.transpose() * end.R_TU).norm();
  return Status::Ok;
}

Status GeodesicSolver::solve_cheapest(const ArmModel& arm, const Posture& start, const Posture& end,
                                      const GeodesicOptions& options, GeodesicPath& path,
                                      Certificate& certificate) noexcept {
  const Status status = solve(arm, start, end, options, nullptr, path, certificate);
  if (status == Status::NotFinite) return status;
  if (status == Status::Ok && certificate.rotation_angle_rad <= kWideRotation) return status;
  const Vec4 momentum = end_momentum();
  GeodesicOptions round = options;
  round.long_way = !options.long_way;
  if (status == Status::Ok && !(workspace_->guess_energy(arm, start, end, round) < kHopeless * path.energy))
    return status;
  Certificate other;
  const Status second = solve(arm, start, end, round, nullptr, workspace_->other, other);
  if (second == Status::Ok && (status != Status::Ok || workspace_->other.energy < path.energy)) {
    path = workspace_->other;
    certificate = other;
    return second;
  }
  workspace_->end_momentum = momentum;
  return status;
}

Status GeodesicSolver::solve_free_end(const ArmModel& arm, const Posture& start, const Posture& guess,
                                      const Vec3& target, const GeodesicOptions& options, const GeodesicPath* warm,
                                      GeodesicPath& path, Certificate& certificate) noexcept {
  if (!finite(start) || !finite(guess) || !target.allFinite()) return Status::NotFinite;
  Workspace& w = *workspace_;
  certificate = Certificate{};
  Status status = w.run(arm, start, guess, &target, options, warm, path, certificate);
  if (status != Status::Ok && warm != nullptr && !options.quick) {
    status = w.run(arm, start, guess, &target, options, nullptr, path, certificate);
  }
  if (status != Status::Ok) return status;
  const Posture& end = path.nodes[static_cast<std::size_t>(path.order)];
  certificate.rotation_angle_rad = rotation_vector(start.R_TU.transpose() * end.R_TU).norm();
  certificate.transversality = w.discrete.transversality();
  certificate.hand_error_m = (forward_kinematics(arm, end).wrist - target).norm();
  return Status::Ok;
}

Vec4 GeodesicSolver::end_momentum() const noexcept { return workspace_->end_momentum; }

}  // namespace glenoid
