#include "glenoid/geodesic_ivp.hpp"

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "glenoid/mass_matrix.hpp"

namespace glenoid {
namespace {

// State: unit quaternion of R_TU (x, y, z, w), phi, w_TU_U, phi'.
constexpr Eigen::Index kStates = 9;
using State = Eigen::Matrix<double, kStates, 1>;
constexpr long kMaxSteps = 200'000;

struct ContextDeleter {
  void operator()(SUNContext context) const noexcept { SUNContext_Free(&context); }
};
struct VectorDeleter {
  void operator()(N_Vector vector) const noexcept { N_VDestroy(vector); }
};
struct MatrixDeleter {
  void operator()(SUNMatrix matrix) const noexcept { SUNMatDestroy(matrix); }
};
struct LinearDeleter {
  void operator()(SUNLinearSolver solver) const noexcept { SUNLinSolFree(solver); }
};
struct NonlinearDeleter {
  void operator()(SUNNonlinearSolver solver) const noexcept { SUNNonlinSolFree(solver); }
};
struct CvodeDeleter {
  void operator()(void* memory) const noexcept { CVodeFree(&memory); }
};

template <class Pointer, class Deleter>
using Owned = std::unique_ptr<std::remove_pointer_t<Pointer>, Deleter>;

Posture posture_of(const State& y) noexcept {
  const Eigen::Quaterniond unit(y.head<4>().normalized());
  return {unit.toRotationMatrix(), y[4]};
}

PostureRates rates_of(const State& y) noexcept { return {y.segment<3>(5), y[8]}; }

State state_of(const Posture& posture, const PostureRates& rates) noexcept {
  State y;
  y << Eigen::Quaterniond(posture.R_TU).normalized().coeffs(), posture.phi, rates.w_TU_U, rates.phi;
  return y;
}

double energy_of(const ArmModel& arm, const State& y) noexcept {
  const Vec4 v = y.tail<4>();
  return 0.5 * v.dot(body_mass_matrix(arm, posture_of(y)) * v);
}

/// What the derivative needs beside the state.
struct Equation {
  const ArmModel& arm;
  double lift_m;
};

/// Right-hand side; SUNDIALS: 0 = done, > 0 = try a smaller step.
int derivative(realtype /*lambda*/, N_Vector y_vector, N_Vector dy_vector, void* user) noexcept {
  const Eigen::Map<const State> y(N_VGetArrayPointer(y_vector));
  Eigen::Map<State> dy(N_VGetArrayPointer(dy_vector));
  if (!y.allFinite()) return 1;
  const PostureRates rates = rates_of(y);
  const Equation& equation = *static_cast<const Equation*>(user);
  const PostureRates accelerations = geodesic_acceleration(equation.arm, posture_of(y), rates, equation.lift_m);
  const Eigen::Quaterniond q(y.head<4>());
  const Eigen::Quaterniond w(0.0, rates.w_TU_U.x(), rates.w_TU_U.y(), rates.w_TU_U.z());
  dy << 0.5 * (q * w).coeffs(), rates.phi, accelerations.w_TU_U, accelerations.phi;
  return dy.allFinite() ? 0 : 1;
}

/// CVODE and everything that it needs, freed in the reverse order.
class Integrator {
 public:
  /// Check ready() before use. CVODE reads `start` and `equation` by address: both outlive the integrator.
  Integrator(Equation& equation, const FollowOptions& options, State& start) {
    SUNContext context = nullptr;
    if (SUNContext_Create(nullptr, &context) != 0) return;
    context_.reset(context);
    y_.reset(N_VMake_Serial(kStates, start.data(), context));
    memory_.reset(CVodeCreate(options.stiff ? CV_BDF : CV_ADAMS, context));
    if (!y_ || !memory_) return;
    void* cvode = memory_.get();
    // The default handler prints; this library reports by status only.
    ready_ = CVodeSetErrFile(cvode, nullptr) == CV_SUCCESS &&
             CVodeInit(cvode, derivative, 0.0, y_.get()) == CV_SUCCESS &&
             CVodeSStolerances(cvode, options.relative_tolerance, options.absolute_tolerance) == CV_SUCCESS &&
             CVodeSetUserData(cvode, &equation) == CV_SUCCESS && CVodeSetMaxNumSteps(cvode, kMaxSteps) == CV_SUCCESS &&
             CVodeSetStopTime(cvode, 1.0) == CV_SUCCESS && (options.stiff ? use_newton() : use_fixed_point());
  }

  [[nodiscard]] bool ready() const noexcept { return ready_; }

  /// Advances the state to lambda. False when CVODE stops before.
  bool advance(double lambda) noexcept {
    realtype reached = 0.0;
    const int flag = CVode(memory_.get(), lambda, y_.get(), &reached, CV_NORMAL);
    return flag == CV_SUCCESS || flag == CV_TSTOP_RETURN;
  }

  [[nodiscard]] bool count_steps(long& steps) const noexcept {
    return CVodeGetNumSteps(memory_.get(), &steps) == CV_SUCCESS;
  }

 private:
  bool use_newton() {
    matrix_.reset(SUNDenseMatrix(kStates, kStates, context_.get()));
    if (!matrix_) return false;
    linear_.reset(SUNLinSol_Dense(y_.get(), matrix_.get(), context_.get()));
    return linear_ && CVodeSetLinearSolver(memory_.get(), linear_.get(), matrix_.get()) == CV_SUCCESS;
  }

  bool use_fixed_point() {
    nonlinear_.reset(SUNNonlinSol_FixedPoint(y_.get(), 0, context_.get()));
    return nonlinear_ && CVodeSetNonlinearSolver(memory_.get(), nonlinear_.get()) == CV_SUCCESS;
  }

  Owned<SUNContext, ContextDeleter> context_;
  Owned<N_Vector, VectorDeleter> y_;
  Owned<SUNMatrix, MatrixDeleter> matrix_;
  Owned<SUNLinearSolver, LinearDeleter> linear_;
  Owned<SUNNonlinearSolver, NonlinearDeleter> nonlinear_;
  std::unique_ptr<void, CvodeDeleter> memory_;
  bool ready_ = false;
};

bool finite(const Posture& posture, const PostureRates& rates) noexcept {
  return posture.R_TU.allFinite() && std::isfinite(posture.phi) && rates.w_TU_U.allFinite() && std::isfinite(rates.phi);
}

}  // namespace

Status follow_geodesic(const ArmModel& arm, const Posture& start, const PostureRates& rates,
                       const FollowOptions& options, FollowResult& out) {
  if (!finite(start, rates) || !std::isfinite(options.relative_tolerance) ||
      !std::isfinite(options.absolute_tolerance) || !std::isfinite(options.lift_m)) {
    return Status::NotFinite;
  }
  if (options.samples < 2 || options.relative_tolerance <= 0.0 || options.absolute_tolerance <= 0.0) {
    return Status::OutOfRange;
  }
  State y = state_of(start, rates);
  Equation equation{arm, options.lift_m};
  Integrator integrator(equation, options, y);
  if (!integrator.ready()) return Status::NoConvergence;

  const double energy = energy_of(arm, y), height = mass_height(arm, start);
  FollowResult result;
  result.postures.reserve(static_cast<std::size_t>(options.samples));
  result.postures.push_back(posture_of(y));
  for (int k = 1; k < options.samples; ++k) {
    if (!integrator.advance(static_cast<double>(k) / (options.samples - 1))) return Status::NoConvergence;
    result.postures.push_back(posture_of(y));
    const double fallen = options.lift_m * (height - mass_height(arm, result.postures.back()));
    if (energy > 0.0) {
      result.energy_drift = std::max(result.energy_drift, std::abs((energy_of(arm, y) - fallen) / energy - 1.0));
    }
  }
  result.end_rates = rates_of(y);
  if (!integrator.count_steps(result.steps)) return Status::NoConvergence;
  out = std::move(result);
  return Status::Ok;
}

}  // namespace glenoid
