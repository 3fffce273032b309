#include <nanobind/stl/pair.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>
#include <vector>

#include "bindings.hpp"
#include "glenoid/geodesic_ivp.hpp"
#include "glenoid/swivel.hpp"

namespace glenoid::python {
namespace {

using namespace nb::literals;
using Release = nb::call_guard<nb::gil_scoped_release>;

/// q, dq/dlambda, ddq/dlambda^2, each (n, 4), unwrapped from near_q along the rows.
nb::tuple path_angles(const GeodesicPath& path, const Column& lambda, Vec4 near_q) {
  Rows<4> q(lambda.size(), 4), dq(lambda.size(), 4), ddq(lambda.size(), 4);
  for (Eigen::Index i = 0; i < lambda.size(); ++i) {
    PostureJet jet;
    Vec4 value, rate, acceleration;
    evaluate_path(path, lambda[i], jet);
    angles_from_jet(jet, near_q, value, rate, acceleration);
    q.row(i) = value;
    dq.row(i) = rate;
    ddq.row(i) = acceleration;
    near_q = value;
  }
  return nb::make_tuple(q, dq, ddq);
}

/// Shoulder, elbow and wrist, each (n, 3), m in T.
nb::tuple path_points(const GeodesicPath& path, const ArmModel& arm, const Column& lambda) {
  Rows<3> shoulder(lambda.size(), 3), elbow(lambda.size(), 3), wrist(lambda.size(), 3);
  for (Eigen::Index i = 0; i < lambda.size(); ++i) {
    const ArmPoints points = forward_kinematics(arm, path_posture(path, lambda[i]));
    shoulder.row(i) = points.shoulder;
    elbow.row(i) = points.elbow;
    wrist.row(i) = points.wrist;
  }
  return nb::make_tuple(shoulder, elbow, wrist);
}

nb::tuple path_rotations(const GeodesicPath& path, const Column& lambda) {
  Rows<9> R(lambda.size(), 9);
  Column phi(lambda.size());
  for (Eigen::Index i = 0; i < lambda.size(); ++i) {
    const Posture posture = path_posture(path, lambda[i]);
    R.row(i) = flat_rotation(posture.R_TU);
    phi[i] = posture.phi;
  }
  return nb::make_tuple(rotations_to_numpy(R), phi);
}

/// Rates with which the path leaves its start, per unit lambda.
PostureRates start_rates(const GeodesicPath& path) {
  PostureJet jet;
  evaluate_path(path, 0.0, jet);
  const Vec3 y = jet.z.cross(jet.x), dy = jet.dz.cross(jet.x) + jet.z.cross(jet.dx);
  // R'  = R [w]x, so w = (z.y', x.z', y.x').
  return {Vec3(jet.z.dot(dy), jet.x.dot(jet.dz), y.dot(jet.dx)), jet.dphi};
}

void bind_path(nb::module_& module) {
  nb::class_<GeodesicPath>(module, "GeodesicPath", "Geodesic over lambda in [0, 1].")
      .def_ro("order", &GeodesicPath::order)
      .def_ro("energy_kg_m2", &GeodesicPath::energy)
      .def_ro("lift_m", &GeodesicPath::lift_m)
      .def("posture", &path_posture, "lambda_"_a)
      .def("angles", &path_angles, "lambda_"_a, "near_q_rad"_a,
           "q, dq, ddq with respect to lambda, each (n, 4) rad, unwrapped from near_q_rad.",
           nb::sig("def angles(self, lambda_: NDArray[numpy.float64], near_q_rad: NDArray[numpy.float64]) -> "
                   "tuple[NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64]]"))
      .def("points", &path_points, "arm"_a, "lambda_"_a, "Shoulder, elbow and wrist, each (n, 3) m in T.",
           nb::sig("def points(self, arm: ArmModel, lambda_: NDArray[numpy.float64]) -> tuple[NDArray[numpy.float64], "
                   "NDArray[numpy.float64], NDArray[numpy.float64]]"))
      .def("rotations", &path_rotations, "lambda_"_a, "R_TU (n, 3, 3) and phi (n,) rad.",
           nb::sig("def rotations(self, lambda_: NDArray[numpy.float64]) -> tuple[NDArray[numpy.float64], "
                   "NDArray[numpy.float64]]"))
      .def("start_rates", &start_rates, "Rates at lambda = 0, per unit lambda: what follow_geodesic takes.");
}

void bind_certificate(nb::module_& module) {
  nb::class_<LimitViolation>(module, "LimitViolation", "Where a path leaves the joint limits.")
      .def_ro("any", &LimitViolation::any)
      .def_ro("worst", &LimitViolation::worst)
      .def_ro("at_lambda", &LimitViolation::lambda);
  nb::class_<Certificate>(module, "Certificate", "What was shown about a path.")
      .def_ro("newton_step_rad", &Certificate::newton_step_rad)
      .def_ro("gradient_kg_m2", &Certificate::gradient)
      .def_ro("hessian_positive", &Certificate::hessian_positive)
      .def_ro("spectral_tail", &Certificate::spectral_tail)
      .def_ro("speed_variation", &Certificate::speed_variation)
      .def_ro("hand_error_m", &Certificate::hand_error_m)
      .def_ro("transversality", &Certificate::transversality)
      .def_ro("swivel_at_limit", &Certificate::swivel_at_limit)
      .def_ro("rotation_angle_rad", &Certificate::rotation_angle_rad)
      .def_ro("long_way", &Certificate::long_way)
      .def_ro("order", &Certificate::order)
      .def_ro("iterations", &Certificate::iterations)
      .def_ro("limits", &Certificate::limits);
}

nb::dict family_to_dict(const Family& family) {
  Column swivel(family.count), margin(family.count), energy(family.count);
  Rows<9> R(family.count, 9);
  Column phi(family.count);
  for (int i = 0; i < family.count; ++i) {
    const FamilyMember& member = family.members[static_cast<size_t>(i)];
    swivel[i] = member.swivel_rad;
    margin[i] = member.margin.margin_rad;
    energy[i] = member.energy;
    R.row(i) = flat_rotation(member.end.R_TU);
    phi[i] = member.end.phi;
  }
  nb::dict out;
  out["swivel_rad"] = swivel;
  out["margin_rad"] = margin;
  out["energy_kg_m2"] = energy;
  out["R_TU"] = rotations_to_numpy(R);
  out["phi_rad"] = phi;
  return out;
}

/// Planning functions give (status, plan); the plan's margins are valid for every status.
using Planned = std::pair<Status, ReachPlan>;

Planned plan_minimum_energy(ReachPlanner& planner, const ArmModel& arm, const Posture& start, const Vec3& target) {
  Planned out;
  out.first = planner.plan_minimum_energy(arm, start, target, out.second);
  return out;
}

Planned plan_prescribed(ReachPlanner& planner, const ArmModel& arm, const Posture& start, const Vec3& target,
                        double swivel_rad) {
  Planned out;
  out.first = planner.plan_prescribed(arm, start, target, swivel_rad, out.second);
  return out;
}

Planned plan_human_prior(ReachPlanner& planner, const ArmModel& arm, const Posture& start, const Vec3& target,
                         const PosturePrior& prior) {
  Planned out;
  out.first = planner.plan_human_prior(arm, start, target, prior, out.second);
  return out;
}

Planned plan_between(ReachPlanner& planner, const ArmModel& arm, const Posture& start, const Posture& end,
                     double lift_m) {
  Planned out;
  out.first = planner.plan_between(arm, start, end, out.second, lift_m);
  return out;
}

std::pair<Status, GeodesicPath> refine_path(const ArmModel& arm, const GeodesicPath& path, double tail_tolerance) {
  const GeodesicOptions options{.tail_tolerance = tail_tolerance, .lift_m = path.lift_m};
  std::pair<Status, GeodesicPath> out;
  Certificate certificate;
  GeodesicSolver solver;
  out.first = solver.solve(arm, path_posture(path, 0.0), path_posture(path, 1.0), options, &path, out.second,
                           certificate);
  return out;
}

nb::tuple sample_family(ReachPlanner& planner, const ArmModel& arm, const Posture& start, const Vec3& target,
                        int count) {
  if (count < 2 || count > kMaxFamily) {
    throw std::invalid_argument("count = " + std::to_string(count) + ": must be 2.." + std::to_string(kMaxFamily));
  }
  const auto family = std::make_unique<Family>();
  Status status = Status::Ok;
  {
    const nb::gil_scoped_release release;
    status = planner.sample_family(arm, start, target, count, *family);
  }
  return nb::make_tuple(status, family_to_dict(*family));
}

void bind_prior(nb::module_& module) {
  nb::class_<PosturePriorCoefficients>(module, "PosturePriorCoefficients", "Coefficients of the posture prior (P1).")
      .def(nb::init<>())
      .def_rw("height_rad", &PosturePriorCoefficients::height_rad)
      .def_rw("lateral_rad", &PosturePriorCoefficients::lateral_rad)
      .def_rw("regression", &PosturePriorCoefficients::regression)
      .def_rw("common_rad", &PosturePriorCoefficients::common_rad)
      .def_rw("effort", &PosturePriorCoefficients::effort)
      .def_rw("lift_per_m", &PosturePriorCoefficients::lift_per_m);
  nb::class_<PosturePrior>(module, "PosturePrior",
                           "Swivel angle that people choose, anchored at a posture of their own.")
      .def(nb::init<const PosturePriorCoefficients&, const ArmModel&, const Posture&>(), "coefficients"_a, "arm"_a,
           "anchor"_a)
      .def("swivel", &PosturePrior::swivel, "target_m"_a, "Expected swivel angle, rad.")
      .def("lift", &PosturePrior::lift, "from_m"_a, "to_m"_a, "Lift of the path between two places of the wrist, m; P3.")
      .def("cost", &PosturePrior::cost, "arm"_a, "posture"_a, "swivel_rad"_a, "How unlikely a final posture is; P2.");
}

void bind_reach_planner(nb::module_& module) {
  module.def("refine_path", &refine_path, "arm"_a, "path"_a, "tail_tolerance"_a, Release(),
             "The same geodesic on as many nodes as bring its spectral tail below the tolerance, at most 65.");
  nb::class_<ReachPlan>(module, "ReachPlan")
      .def(nb::init<>())
      .def_ro("path", &ReachPlan::path)
      .def_ro("certificate", &ReachPlan::certificate)
      .def_ro("swivel_rad", &ReachPlan::swivel_rad)
      .def_ro("reach_margin_m", &ReachPlan::reach_margin_m)
      .def_ro("best_margin", &ReachPlan::best_margin);
  nb::class_<ReachPlanner>(module, "ReachPlanner", "Plans reaches; one per thread. Planning releases the GIL.")
      .def(nb::init<>())
      .def("plan_minimum_energy", &plan_minimum_energy, "arm"_a, "start"_a, "target_m"_a, Release(),
           "Globally least energy over all feasible swivel angles; S1-S4.")
      .def("plan_prescribed", &plan_prescribed, "arm"_a, "start"_a, "target_m"_a, "swivel_rad"_a, Release(),
           "The posture with this swivel angle that is nearest in energy.")
      .def("plan_human_prior", &plan_human_prior, "arm"_a, "start"_a, "target_m"_a, "prior"_a, Release(),
           "The posture within the limits that the prior finds least unlikely, the path lifted; P1-P3.")
      .def("plan_between", &plan_between, "arm"_a, "start"_a, "end"_a, "lift_m"_a = 0.0, Release(),
           "Given end posture; lift_m bends the path upward (G7).")
      .def("sample_family", &sample_family, "arm"_a, "start"_a, "target_m"_a, "count"_a,
           "Family of final postures over the self-motion: swivel_rad, margin_rad, energy_kg_m2, R_TU, phi_rad.",
           nb::sig(
               "def sample_family(self, arm: ArmModel, start: Posture, target_m: NDArray[numpy.float64], count: int) "
               "-> tuple[Status, dict[str, NDArray[numpy.float64]]]"));
}

void bind_follow(nb::module_& module) {
  nb::class_<FollowOptions>(module, "FollowOptions")
      .def(nb::init<>())
      .def_rw("relative_tolerance", &FollowOptions::relative_tolerance)
      .def_rw("absolute_tolerance", &FollowOptions::absolute_tolerance)
      .def_rw("stiff", &FollowOptions::stiff)
      .def_rw("samples", &FollowOptions::samples)
      .def_rw("lift_m", &FollowOptions::lift_m);
  nb::class_<FollowResult>(module, "FollowResult")
      .def_ro("postures", &FollowResult::postures)
      .def_ro("end_rates", &FollowResult::end_rates)
      .def_ro("energy_drift", &FollowResult::energy_drift)
      .def_ro("steps", &FollowResult::steps);
  module.def(
      "follow_geodesic",
      [](const ArmModel& arm, const Posture& start, const PostureRates& rates, const FollowOptions& options) {
        std::pair<Status, FollowResult> out;
        out.first = follow_geodesic(arm, start, rates, options, out.second);
        return out;
      },
      "arm"_a, "start"_a, "rates"_a, "options"_a = FollowOptions(), Release(),
      "Exponential map by SUNDIALS CVODE: the geodesic that leaves `start` with `rates` per unit lambda.");
}

}  // namespace

void bind_planner(nb::module_& module) {
  bind_path(module);
  bind_certificate(module);
  bind_prior(module);
  bind_reach_planner(module);
  bind_follow(module);
}

}  // namespace glenoid::python
