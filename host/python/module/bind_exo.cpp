#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "bindings.hpp"
#include "glenoid/exoskeleton.hpp"
#include "glenoid/kinematics.hpp"

namespace glenoid::python {
namespace {

using namespace nb::literals;
using Release = nb::call_guard<nb::gil_scoped_release>;

Mat3 axes_of(const ExoSettings& settings) {
  Mat3 rows;
  for (int i = 0; i < 3; ++i) rows.row(i) = settings.axes[static_cast<size_t>(i)];
  return rows;
}

void set_axes(ExoSettings& settings, const Mat3& rows) {
  for (int i = 0; i < 3; ++i) settings.axes[static_cast<size_t>(i)] = rows.row(i);
}

void bind_enums(nb::module_& module) {
  nb::enum_<GirdleOrder>(module, "GirdleOrder")
      .value("ProtractionFirst", GirdleOrder::ProtractionFirst)
      .value("ElevationFirst", GirdleOrder::ElevationFirst);
  nb::enum_<GirdleDrives>(module, "GirdleDrives")
      .value("Full", GirdleDrives::Full)
      .value("NoLength", GirdleDrives::NoLength)
      .value("VerticalOnly", GirdleDrives::VerticalOnly)
      .value("NoDrives", GirdleDrives::None);
  nb::enum_<ExoBranch>(module, "ExoBranch").value("First", ExoBranch::First).value("Second", ExoBranch::Second);
  nb::enum_<ExoRefusal>(module, "ExoRefusal")
      .value("Nothing", ExoRefusal::None)
      .value("OutOfReach", ExoRefusal::OutOfReach)
      .value("Singular", ExoRefusal::Singular)
      .value("JointLimit", ExoRefusal::JointLimit);
}

void bind_settings(nb::module_& module) {
  nb::class_<ExoSettings>(module, "ExoSettings", "Parameters of a device (docs/equations.md, X1-X6).")
      .def(nb::init<>())
      .def_prop_rw("axes", &axes_of, &set_axes,
                   "Unit axes of shoulder joints 1..3, a row each, in the base frame at zero.")
      .def_rw("base_rad", &ExoSettings::base)
      .def_rw("cuff_rad", &ExoSettings::cuff)
      .def_rw("girdle_order", &ExoSettings::girdle_order)
      .def_rw("girdle_drives", &ExoSettings::girdle_drives)
      .def_rw("base_follows_girdle", &ExoSettings::base_follows_girdle)
      .def_rw("girdle_link_m", &ExoSettings::girdle_link_m)
      .def_rw("min_singularity_rad", &ExoSettings::min_singularity_rad)
      .def_rw("lower_rad", &ExoSettings::lower)
      .def_rw("upper_rad", &ExoSettings::upper);
  nb::class_<ExoModel>(module, "ExoModel", "Constant description of one device.")
      .def(nb::init<const ExoSettings&, const Vec3&>(), "settings"_a, "p_TS_ref_m"_a,
           "ValueError with a line per problem: variable, value, unit, rule.")
      .def_prop_ro("a12_rad", [](const ExoModel& model) { return model.shoulder().a12; })
      .def_prop_ro("a23_rad", [](const ExoModel& model) { return model.shoulder().a23; })
      .def_prop_ro("least_rad", [](const ExoModel& model) { return model.shoulder().least; })
      .def_prop_ro("most_rad", [](const ExoModel& model) { return model.shoulder().most; });
  module.attr("NO_EXO_LIMIT_RAD") = kNoExoLimit;
  module.def("exo_joint_name", &exo_joint_name, "joint"_a);
  module.def("exo_base", &exo_base, "model"_a, "protraction_rad"_a, "elevation_rad"_a, "Base frame in T; X1.");
  module.def("exo_upper_arm", &exo_upper_arm, "model"_a, "exo_q_rad"_a, "Upper arm in T from the six joints; X1.");
}

void bind_check(nb::module_& module) {
  nb::class_<ExoStart>(module, "ExoStart", "Assembly and shoulder joints at the start.")
      .def(nb::init<>())
      .def_ro("branch", &ExoStart::branch)
      .def_ro("shoulder_q_rad", &ExoStart::shoulder_q)
      .def_ro("margin_rad", &ExoStart::margin_rad);
  nb::class_<ExoGuide>(module, "ExoGuide", "Branch and unwrapped joints along one motion.")
      .def_ro("branch", &ExoGuide::branch);
  nb::class_<ExoPathCheck>(module, "ExoPathCheck", "What was found on the way; each `at` is a path parameter.")
      .def_ro("refusal", &ExoPathCheck::refusal)
      .def_ro("guide", &ExoPathCheck::guide)
      .def_ro("other_branch", &ExoPathCheck::other_branch)
      .def_ro("start_step_rad", &ExoPathCheck::start_step_rad)
      .def_ro("margin_rad", &ExoPathCheck::margin_rad)
      .def_ro("margin_at", &ExoPathCheck::margin_at)
      .def_ro("singularity_rad", &ExoPathCheck::singularity_rad)
      .def_ro("singularity_at", &ExoPathCheck::singularity_at)
      .def_ro("limit_margin_rad", &ExoPathCheck::limit_margin_rad)
      .def_ro("limit_at", &ExoPathCheck::limit_at)
      .def_ro("limit_joint", &ExoPathCheck::limit_joint)
      .def_ro("limit_at_upper", &ExoPathCheck::limit_at_upper)
      .def_ro("residual_m", &ExoPathCheck::residual_m)
      .def_ro("residual_at", &ExoPathCheck::residual_at);
  module.def(
      "choose_branch",
      [](const ExoModel& model, const Posture& posture, const Vec3& centre, const std::optional<Vec3>& device_q) {
        std::pair<Status, ExoStart> out;
        out.first = choose_branch(model, posture, centre, device_q, out.second);
        return out;
      },
      "model"_a, "posture"_a, "p_TS_m"_a, "device_q_rad"_a = nb::none(), "Assembly in which the device starts.");
  module.def(
      "check_path",
      [](const ExoModel& model, const GeodesicPath& path, const Rhythm& rhythm, const ExoStart& start, bool other) {
        std::pair<Status, ExoPathCheck> out;
        out.first = check_path(model, path, rhythm, start, other, out.second);
        return out;
      },
      "model"_a, "path"_a, "rhythm"_a, "start"_a, "try_other_branch"_a, Release(),
      "Whether the device can follow the whole path, and its worst places; X6.");
}

/// Joints along a path with derivatives by lambda.
nb::dict map_path(const ExoModel& model, const GeodesicPath& path, const Rhythm& rhythm, const ExoGuide& guide,
                  const Column& lambda) {
  const Eigen::Index n = lambda.size();
  Rows<6> q(n, 6), dq(n, 6), ddq(n, 6);
  Column residual(n), margin(n), singularity(n), length(n);
  Eigen::VectorXi status(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    PostureJet jet;
    PointJet centre;
    ExoSample sample;
    evaluate_path(path, lambda[i], jet);
    shoulder_centre_jet(rhythm, jet, centre);
    sample.q = sample.dq = sample.ddq = Vec6::Constant(std::numeric_limits<double>::quiet_NaN());
    status[i] = static_cast<int>(map_to_exo(model, guide.branch, jet, centre, guide_angles(guide, lambda[i]), sample));
    q.row(i) = sample.q;
    dq.row(i) = sample.dq;
    ddq.row(i) = sample.ddq;
    residual[i] = sample.residual_m;
    margin[i] = sample.margin_rad;
    singularity[i] = sample.singularity_rad;
    length[i] = sample.length_m[0];
  }
  nb::dict out;
  out["q_rad"] = q;
  out["dq_rad"] = dq;
  out["ddq_rad"] = ddq;
  out["residual_m"] = residual;
  out["margin_rad"] = margin;
  out["singularity_rad"] = singularity;
  out["length_m"] = length;
  out["status"] = status;
  return out;
}

/// Signed distance to the nearest joint limit, each joint taken modulo a turn about the middle of its range.
double limit_margin_of(const ExoSettings& settings, const Vec6& q) {
  double least = kNoExoLimit;
  for (int i = 0; i < 6; ++i) {
    const double lower = settings.lower[i], upper = settings.upper[i];
    double value = q[i];
    if (lower > -kNoExoLimit && upper < kNoExoLimit) {
      value -= 2.0 * kPi * std::round((value - 0.5 * (lower + upper)) / (2.0 * kPi));
    }
    least = std::min({least, value - lower, upper - value});
  }
  return least;
}

/// Reach of single postures: margins and joints of the branch that is deeper inside the joint limits.
nb::dict map_postures(const ExoModel& model, const Rhythm& rhythm, const Rows<4>& arm_q) {
  const Eigen::Index n = arm_q.rows();
  Rows<6> q(n, 6);
  Column margin(n), singularity(n), limit(n), residual(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vec4 angles = arm_q.row(i);
    if (!angles.allFinite()) throw std::invalid_argument("q_rad[" + std::to_string(i) + "]: must be finite");
    const Posture posture = posture_from_angles(angles);
    const Vec3 centre = rhythm.position(posture.R_TU.col(2));
    GirdleJet girdle;
    girdle_joints(model, {centre, Vec3::Zero(), Vec3::Zero()}, girdle);
    const Mat3 base = exo_base(model, girdle.q[0], girdle.q[1]);
    limit[i] = -std::numeric_limits<double>::infinity();
    residual[i] = girdle.residual_m;
    for (const ExoBranch branch : {ExoBranch::First, ExoBranch::Second}) {
      ShoulderSolution solution;
      // An unreachable posture keeps the joints of the edge; its margin says so.
      (void)shoulder_joints(model, base, posture.R_TU, branch, Vec3::Zero(), solution);
      Vec6 joints;
      joints << girdle.q.head<2>(), solution.q, posture.phi;
      const double inside = limit_margin_of(model.settings(), joints);
      margin[i] = solution.margin_rad;
      singularity[i] = solution.singularity_rad;
      if (inside > limit[i]) {
        limit[i] = inside;
        q.row(i) = joints;
      }
    }
  }
  nb::dict out;
  out["q_rad"] = q;
  out["margin_rad"] = margin;
  out["singularity_rad"] = singularity;
  out["limit_margin_rad"] = limit;
  out["residual_m"] = residual;
  return out;
}

}  // namespace

void bind_exo(nb::module_& module) {
  bind_enums(module);
  bind_settings(module);
  bind_check(module);
  module.def(
      "map_path", &map_path, "model"_a, "path"_a, "rhythm"_a, "guide"_a, "lambda_"_a,
      "Device along a path, a row per lambda: q_rad, dq_rad, ddq_rad (derivatives by lambda), residual_m, margin_rad, "
      "singularity_rad, length_m, status (numbers of Status).",
      nb::sig("def map_path(model: ExoModel, path: GeodesicPath, rhythm: Rhythm, guide: ExoGuide, "
              "lambda_: NDArray[numpy.float64]) -> dict[str, NDArray[numpy.float64]]"));
  module.def(
      "map_postures", &map_postures, "model"_a, "rhythm"_a, "q_rad"_a,
      "T of single postures (theta, eta, zeta, phi): q_rad, margin_rad, singularity_rad, limit_margin_rad (of the "
      "branch deeper inside the joint limits), residual_m.",
      nb::sig("def map_postures(model: ExoModel, rhythm: Rhythm, q_rad: NDArray[numpy.float64]) "
              "-> dict[str, NDArray[numpy.float64]]"));
}

}  // namespace glenoid::python
