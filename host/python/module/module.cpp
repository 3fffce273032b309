#include "bindings.hpp"
#include "glenoid/status.hpp"

NB_MODULE(_core, module) {
  namespace nb = nanobind;
  using glenoid::Status;
  module.doc() = "Glenoid's mathematics. SI units and rad; frames and angles as in docs/conventions.md.";
  module.attr("version") = GLENOID_VERSION;
  nb::enum_<Status>(module, "Status", "Result of a planning function; numbers are fixed for life.")
      .value("Ok", Status::Ok)
      .value("NotFinite", Status::NotFinite)
      .value("OutOfRange", Status::OutOfRange)
      .value("TargetUnreachable", Status::TargetUnreachable)
      .value("LimitsInfeasible", Status::LimitsInfeasible)
      .value("ExoInfeasible", Status::ExoInfeasible)
      .value("NoConvergence", Status::NoConvergence)
      .value("NotAvailable", Status::NotAvailable);
  glenoid::python::bind_model(module);
  glenoid::python::bind_planner(module);
  glenoid::python::bind_exo(module);
  glenoid::python::bind_motion(module);
  glenoid::python::bind_rig(module);
}
