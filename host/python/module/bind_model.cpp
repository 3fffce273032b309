#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <vector>

#include "bindings.hpp"
#include "glenoid/kinematics.hpp"
#include "glenoid/mass_matrix.hpp"

namespace glenoid::python {
namespace {

using namespace nb::literals;

void bind_subject(nb::module_& module) {
  nb::class_<Segment>(module, "Segment", "Rigid segment along its local -z axis.")
      .def_ro("length_m", &Segment::length_m)
      .def_ro("mass_kg", &Segment::mass_kg)
      .def_ro("com_m", &Segment::com_m)
      .def_rw("inertia_kg_m2", &Segment::inertia_kg_m2);
  nb::class_<Subject>(module, "Subject", "What is known of a person; None is scaled from stature and mass.")
      .def(nb::init<>())
      .def_rw("stature_m", &Subject::stature_m)
      .def_rw("mass_kg", &Subject::mass_kg)
      .def_rw("female", &Subject::female)
      .def_rw("left_arm", &Subject::left_arm)
      .def_rw("upper_arm_length_m", &Subject::upper_arm_length_m, nb::arg().none())
      .def_rw("forearm_length_m", &Subject::forearm_length_m, nb::arg().none())
      .def_rw("shoulder_distance_m", &Subject::shoulder_distance_m, nb::arg().none())
      .def_rw("upper_arm_mass_kg", &Subject::upper_arm_mass_kg, nb::arg().none())
      .def_rw("forearm_mass_kg", &Subject::forearm_mass_kg, nb::arg().none())
      .def_rw("upper_arm_com_m", &Subject::upper_arm_com_m, nb::arg().none())
      .def_rw("forearm_com_m", &Subject::forearm_com_m, nb::arg().none())
      .def_rw("upper_arm_inertia_kg_m2", &Subject::upper_arm_inertia_kg_m2, nb::arg().none())
      .def_rw("forearm_inertia_kg_m2", &Subject::forearm_inertia_kg_m2, nb::arg().none());
  nb::class_<ScalingEntry>(module, "ScalingEntry", "Which figure came from where.")
      .def_ro("name", &ScalingEntry::name)
      .def_ro("value", &ScalingEntry::value)
      .def_ro("unit", &ScalingEntry::unit)
      .def_ro("source", &ScalingEntry::source);
  nb::class_<ScaledArm>(module, "ScaledArm", "Segments of one person.")
      .def_ro("upper_arm", &ScaledArm::upper_arm)
      .def_ro("forearm", &ScaledArm::forearm)
      .def_ro("shoulder_distance_m", &ScaledArm::shoulder_distance_m)
      .def_ro("turning_kg_m2", &ScaledArm::turning_kg_m2)
      .def_ro("report", &ScaledArm::report);
  module.def("apply_axial_factor", &apply_axial_factor, "scaled"_a, "factor"_a,
             "Makes turning about the segments' own axes dearer in the metric, in place (M5, M6).");
  module.def("scale_subject", &scale_subject, "subject"_a,
             "Segment data of a person (docs/equations.md, A1-A4). ValueError names field, value, unit and rule.");
}

void bind_rhythm(nb::module_& module) {
  nb::enum_<RhythmModel>(module, "RhythmModel")
      .value("Fixed", RhythmModel::Fixed)
      .value("SoltaniZarrin2017", RhythmModel::SoltaniZarrin2017)
      .value("Measured", RhythmModel::Measured);
  nb::class_<MeasuredRhythm>(module, "MeasuredRhythm", "Coefficients of the measured rhythm (R5).")
      .def(nb::init<>())
      .def_rw("slope_m", &MeasuredRhythm::slope_m, "Nine numbers, row by row.")
      .def_rw("shoulder_distance_m", &MeasuredRhythm::shoulder_distance_m);
  nb::class_<RhythmSettings>(module, "RhythmSettings")
      .def(nb::init<>())
      .def_rw("model", &RhythmSettings::model)
      .def_rw("gain", &RhythmSettings::gain)
      .def_rw("smoothing_rad", &RhythmSettings::smoothing_rad)
      .def_rw("measured", &RhythmSettings::measured);
  nb::class_<Rhythm>(module, "Rhythm", "Glenohumeral centre as a function of the upper-arm direction.")
      .def(nb::init<const RhythmSettings&, double>(), "settings"_a, "shoulder_distance_m"_a)
      .def("anchor", &Rhythm::anchor, "z_TU"_a, "p_TS_m"_a, "Shifts the model so that it gives p_TS_m at z_TU.")
      .def("position", &Rhythm::position, "z_TU"_a, "Centre in T, m, for the third column of R_TU.");
}

void bind_limits(nb::module_& module) {
  nb::class_<JointLimits>(module, "JointLimits", "Limits on (theta, eta, eta + zeta, phi), rad.")
      .def(nb::init<>())
      .def_rw("lower_rad", &JointLimits::lower)
      .def_rw("upper_rad", &JointLimits::upper);
  nb::class_<LimitMargin>(module, "LimitMargin")
      .def_ro("margin_rad", &LimitMargin::margin_rad)
      .def_ro("angle", &LimitMargin::angle)
      .def_ro("at_upper", &LimitMargin::at_upper);
  module.def("limit_margin", &limit_margin, "limits"_a, "posture"_a, "Signed distance to the nearest limit.");
  module.def("limited_angles", &limited_angles, "posture"_a, "(theta, eta, eta + zeta, phi) of a posture, rad.");
}

void bind_posture(nb::module_& module) {
  nb::class_<Posture>(module, "Posture", "Posture without a chart: rotation R_TU (3, 3) and elbow flexion, rad.")
      .def(nb::init<>())
      .def_rw("R_TU", &Posture::R_TU)
      .def_rw("phi_rad", &Posture::phi);
  nb::class_<PostureRates>(module, "PostureRates", "Body angular velocity of the upper arm and elbow rate.")
      .def(nb::init<>())
      .def_rw("w_TU_U", &PostureRates::w_TU_U)
      .def_rw("phi", &PostureRates::phi);
  nb::class_<ArmPoints>(module, "ArmPoints", "Joint points in T, m.")
      .def_ro("shoulder_m", &ArmPoints::shoulder)
      .def_ro("elbow_m", &ArmPoints::elbow)
      .def_ro("wrist_m", &ArmPoints::wrist);
}

std::vector<Posture> solve_inverse_kinematics(const ArmModel& arm, const Vec3& wrist, double swivel) {
  IkSolutions solutions;
  if (inverse_kinematics(arm, wrist, swivel, solutions) != Status::Ok) {
    return {};
  }
  return {solutions.postures.begin(), solutions.postures.begin() + solutions.count};
}

void bind_arm(nb::module_& module) {
  nb::class_<ArmModel>(module, "ArmModel", "Constant description of one right arm.")
      .def_ro("upper_arm", &ArmModel::upper_arm)
      .def_ro("forearm", &ArmModel::forearm)
      .def_ro("rhythm", &ArmModel::rhythm)
      .def_ro("limits", &ArmModel::limits)
      .def_ro("moving_shoulder", &ArmModel::moving_shoulder);
  module.def("make_arm_model", &make_arm_model, "arm"_a, "rhythm"_a, "limits"_a, "moving_shoulder"_a);
  module.def("posture_from_angles", &posture_from_angles, "q_rad"_a, "Posture of q = (theta, eta, zeta, phi); K1.");
  module.def("angles_from_posture", &angles_from_posture, "posture"_a, "near_q_rad"_a,
             "q of a posture, eta and zeta within pi of near_q_rad.");
  module.def("isb_from_angles", &isb_from_angles, "q_rad"_a, "ISB angles and elbow flexion, rad; K6.");
  module.def("forward_kinematics", &forward_kinematics, "arm"_a, "posture"_a,
             "Joint points about the moving centre; K2.");
  module.def("swivel_angle", &swivel_angle, "points"_a, "Swivel angle, rad; 0 = elbow lowest; K4.");
  module.def("inverse_kinematics", &solve_inverse_kinematics, "arm"_a, "wrist_m"_a, "swivel_rad"_a,
             "Every posture with the wrist there and this swivel angle; an empty list if there is none; K7.");
  module.def("girdle_coordinates", &girdle_coordinates, "p_TS_m"_a, "(phi_ed rad, phi_pr rad, d_SG m); R1.");
  module.def("mass_matrix", &mass_matrix, "arm"_a, "q_rad"_a, "M(q), kg.m2; M1.");
  module.def("coriolis_vector", &coriolis_vector, "arm"_a, "q_rad"_a, "v_rad"_a, "C(q, v) v; M2.");
  module.def("body_mass_matrix", &body_mass_matrix, "arm"_a, "posture"_a, "Metric in body rates, kg.m2; M3.");
}

}  // namespace

void bind_model(nb::module_& module) {
  bind_posture(module);
  bind_subject(module);
  bind_rhythm(module);
  bind_limits(module);
  bind_arm(module);
}

}  // namespace glenoid::python
