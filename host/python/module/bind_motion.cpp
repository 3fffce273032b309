#include <nanobind/stl/optional.h>

#include <stdexcept>
#include <string>

#include "bindings.hpp"
#include "glenoid/motion.hpp"

namespace glenoid::python {
namespace {

using namespace nb::literals;

void bind_settings(nb::module_& module) {
  nb::enum_<SwivelMode>(module, "SwivelMode")
      .value("MinimumEnergy", SwivelMode::MinimumEnergy)
      .value("Prescribed", SwivelMode::Prescribed)
      .value("HumanPrior", SwivelMode::HumanPrior);
  nb::enum_<TimingLaw>(module, "TimingLaw")
      .value("MinimumJerkRiemannian", TimingLaw::MinimumJerkRiemannian)
      .value("MinimumJerkHand", TimingLaw::MinimumJerkHand)
      .value("MinimumJerkHoming", TimingLaw::MinimumJerkHoming);
  nb::enum_<MotionStatus>(module, "MotionStatus", "What the arm is doing; numbers are those of the FMU's status.")
      .value("Idle", MotionStatus::Idle)
      .value("Moving", MotionStatus::Moving)
      .value("Arrived", MotionStatus::Arrived)
      .value("Stopped", MotionStatus::Stopped)
      .value("TargetUnreachable", MotionStatus::TargetUnreachable)
      .value("LimitsInfeasible", MotionStatus::LimitsInfeasible)
      .value("ExoInfeasible", MotionStatus::ExoInfeasible)
      .value("SolverFailed", MotionStatus::SolverFailed);
  module.attr("HUMAN_AXIAL_FACTOR") = kHumanAxialFactor;
  module.def("effective_axial_factor", &effective_axial_factor, "factor"_a, "mode"_a,
             "A given factor, and for 0 that of people with HumanPrior, else 1.");
  nb::class_<MotionSettings>(module, "MotionSettings", "Everything that is fixed before the first movement.")
      .def(nb::init<>())
      .def_rw("subject", &MotionSettings::subject)
      .def_rw("rhythm", &MotionSettings::rhythm)
      .def_rw("moving_shoulder", &MotionSettings::moving_shoulder)
      .def_rw("axial_factor", &MotionSettings::axial_factor)
      .def_rw("swivel_mode", &MotionSettings::swivel_mode)
      .def_rw("swivel_prescribed_rad", &MotionSettings::swivel_prescribed_rad)
      .def_rw("posture_prior", &MotionSettings::posture_prior)
      .def_rw("duration_s", &MotionSettings::duration_s)
      .def_rw("timing", &MotionSettings::timing)
      .def_rw("limits", &MotionSettings::limits)
      .def_rw("start_q_rad", &MotionSettings::start_q)
      .def_rw("shoulder_start_m", &MotionSettings::shoulder_start_m, nb::arg().none())
      .def_rw("exo", &MotionSettings::exo);
}

/// Columns of a sampled motion, n rows each.
struct Samples {
  explicit Samples(Eigen::Index n)
      : q(n, 4),
        dq(n, 4),
        ddq(n, 4),
        shoulder(n, 3),
        elbow(n, 3),
        wrist(n, 3),
        girdle(n, 3),
        swivel(n),
        progress(n),
        energy(n),
        misalignment(n),
        exo_q(n, 6),
        exo_dq(n, 6),
        exo_ddq(n, 6),
        exo_residual(n),
        status(n) {}

  void set(Eigen::Index i, const MotionSample& sample) {
    q.row(i) = sample.q;
    dq.row(i) = sample.dq;
    ddq.row(i) = sample.ddq;
    shoulder.row(i) = sample.shoulder;
    elbow.row(i) = sample.elbow;
    wrist.row(i) = sample.wrist;
    girdle.row(i) = sample.girdle;
    swivel[i] = sample.swivel;
    progress[i] = sample.progress;
    energy[i] = sample.energy;
    misalignment[i] = sample.misalignment;
    exo_q.row(i) = sample.exo_q;
    exo_dq.row(i) = sample.exo_dq;
    exo_ddq.row(i) = sample.exo_ddq;
    exo_residual[i] = sample.exo_residual;
    status[i] = static_cast<int>(sample.status);
  }

  [[nodiscard]] nb::dict to_dict() const {
    nb::dict out;
    out["q_rad"] = q;
    out["dq_rad_per_s"] = dq;
    out["ddq_rad_per_s2"] = ddq;
    out["shoulder_m"] = shoulder;
    out["elbow_m"] = elbow;
    out["wrist_m"] = wrist;
    out["girdle"] = girdle;
    out["swivel_rad"] = swivel;
    out["progress"] = progress;
    out["energy_kg_m2"] = energy;
    out["misalignment_m"] = misalignment;
    out["exo_q_rad"] = exo_q;
    out["exo_dq_rad_per_s"] = exo_dq;
    out["exo_ddq_rad_per_s2"] = exo_ddq;
    out["exo_residual_m"] = exo_residual;
    out["status"] = status;
    return out;
  }

  Rows<4> q, dq, ddq;
  Rows<3> shoulder, elbow, wrist, girdle;
  Column swivel, progress, energy, misalignment;
  Rows<6> exo_q, exo_dq, exo_ddq;
  Column exo_residual;
  Eigen::VectorXi status;
};

nb::dict sample_motion(const MotionGenerator& generator, const Column& time_s) {
  Samples samples(time_s.size());
  {
    const nb::gil_scoped_release release;
    for (Eigen::Index i = 0; i < time_s.size(); ++i) {
      MotionSample sample;
      if (generator.sample(time_s[i], sample) != Status::Ok) {
        throw std::invalid_argument("time_s[" + std::to_string(i) + "]: must be finite");
      }
      samples.set(i, sample);
    }
  }
  return samples.to_dict();
}

void command_motion(MotionGenerator& generator, double time_s, const Vec3& target_m, bool enable, bool stop) {
  Status status = Status::Ok;
  {
    const nb::gil_scoped_release release;
    status = generator.command(time_s, {target_m, enable, stop});
  }
  if (status != Status::Ok) {
    throw std::invalid_argument("time_s, target_m: must be finite");
  }
}

Column homing_progress(const Column& time_s, double duration_s, double tail) {
  return time_s.unaryExpr([=](double t) { return homing_minimum_jerk(t, 0.0, duration_s, tail).value; });
}

void set_duration(MotionGenerator& generator, double duration_s) {
  if (generator.set_duration(duration_s) != Status::Ok) {
    throw std::invalid_argument("duration_s = " + std::to_string(duration_s) + " s: must be 0.05..60 s");
  }
}

}  // namespace

void bind_motion(nb::module_& module) {
  bind_settings(module);
  module.attr("HOMING_TAIL") = kHomingTail;
  module.def("homing_progress", &homing_progress, "time_s"_a, "duration_s"_a, "tail"_a = kHomingTail,
             "Progress 0..1 of the law MinimumJerkHoming (T5); tail 0 is minimum jerk.");
  nb::class_<MotionGenerator>(module, "MotionGenerator", "Plans and samples movements of one arm in time.")
      .def(nb::init<const MotionSettings&, double>(), "settings"_a, "start_time_s"_a = 0.0)
      .def("command", &command_motion, "time_s"_a, "target_m"_a, "enable"_a = true, "stop"_a = false,
           "Takes the inputs that hold from time_s on. ValueError if one is not finite; nothing changes then.")
      .def("sample", &sample_motion, "time_s"_a,
           "Arrays with a row per time: q_rad, dq_rad_per_s, ddq_rad_per_s2, shoulder_m, elbow_m, wrist_m, girdle, "
           "swivel_rad, progress, energy_kg_m2, misalignment_m, exo_q_rad, exo_dq_rad_per_s, exo_ddq_rad_per_s2, "
           "exo_residual_m, status.",
           nb::sig("def sample(self, time_s: NDArray[numpy.float64]) -> dict[str, NDArray[numpy.float64]]"))
      .def("set_duration", &set_duration, "duration_s"_a, "Duration of the movements accepted from now on, 0.05..60 s.")
      .def_prop_ro("message", &MotionGenerator::message)
      .def_prop_ro("path", &MotionGenerator::path)
      .def_prop_ro("certificate", &MotionGenerator::certificate)
      .def_prop_ro("arm", &MotionGenerator::arm)
      .def_prop_ro("scaled_arm", &MotionGenerator::scaled_arm);
}

}  // namespace glenoid::python
