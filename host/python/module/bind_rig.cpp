#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>

#include "bindings.hpp"
#include "host/bridge/core/words.hpp"
#include "host/drives/profile.hpp"
#include "host/load/arm_load.hpp"
#include "host/rig/rig.hpp"

namespace glenoid::python {
namespace {

using namespace nb::literals;
using Table = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
template <class T>
using List = Eigen::Matrix<T, Eigen::Dynamic, 1>;
using Integers = List<std::int64_t>;

/// One value of every row.
template <class Row, class Get>
auto column(const std::vector<Row>& rows, Get get) {
  List<std::decay_t<decltype(get(rows.front()))>> out(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t k = 0; k < rows.size(); ++k) out[static_cast<Eigen::Index>(k)] = get(rows[k]);
  return out;
}

/// One array of every row, a column a joint.
template <class Row, class Get>
auto table(const std::vector<Row>& rows, std::size_t joints, Get get) {
  using Value = std::decay_t<decltype(get(rows.front())[0])>;
  Eigen::Matrix<Value, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> out(rows.size(), joints);
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (std::size_t j = 0; j < joints; ++j)
      out(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(j)) = get(rows[k])[j];
  return out;
}

template <class Enumerator>
int number(Enumerator value) {
  return static_cast<int>(value);
}

nb::list joints_of(const bridge::Config& config) {
  nb::list out;
  for (const bridge::JointSettings& joint : config.settings.joints) {
    nb::dict one;
    one["name"] = joint.name;
    one["bus"] = joint.bus;
    one["node"] = joint.node;
    one["gear_ratio"] = joint.gear_ratio;
    one["encoder_counts_per_turn"] = joint.encoder_counts_per_turn;
    one["sign"] = joint.sign;
    one["offset_rad"] = joint.offset_rad;
    one["rated_torque_Nm"] = joint.rated_torque_Nm;
    one["lower_rad"] = joint.lower_rad;
    one["upper_rad"] = joint.upper_rad;
    one["velocity_rad_per_s"] = joint.velocity_rad_per_s;
    one["acceleration_rad_per_s2"] = joint.acceleration_rad_per_s2;
    one["start_window_rad"] = joint.start_window_rad;
    one["following_window_rad"] = joint.following_window_rad;
    out.append(one);
  }
  return out;
}

nb::list buses_of(const bridge::Config& config) {
  nb::list out;
  for (const bridge::BusConfig& bus : config.buses) {
    nb::dict one;
    one["name"] = bus.name;
    one["url"] = bus.url;
    one["bit_rate_bit_per_s"] = bus.bit_rate_bit_per_s;
    one["worst_case_load"] = bus.worst_case_load;
    out.append(one);
  }
  return out;
}

void bind_config(nb::module_& module) {
  nb::class_<bridge::Config>(module, "BridgeConfig",
                             "Checked configuration of one exoskeleton's bridge; docs/bridge.md.")
      .def_static("parse", &bridge::parse_config, "yaml"_a, "name"_a = "",
                  "ValueError with line, key, value and rule. An empty name: the only one of the file.")
      .def_prop_ro("hash", &bridge::config_hash, "SHA-256 of all that decides how drives are moved.")
      .def_prop_ro("name", [](const bridge::Config& c) { return c.settings.name; })
      .def_ro("side", &bridge::Config::side)
      .def_ro("device", &bridge::Config::device)
      .def_ro("device_sha256", &bridge::Config::device_sha256)
      .def_ro("warnings", &bridge::Config::warnings)
      .def_ro("rpdo_phase", &bridge::Config::rpdo_phase)
      .def_prop_ro("period_ns", [](const bridge::Config& c) { return c.settings.period_ns; })
      .def_prop_ro("setpoint_period_ns", [](const bridge::Config& c) { return c.settings.setpoint_period_ns; })
      .def_prop_ro("delay_ns", [](const bridge::Config& c) { return c.settings.delay_ns; })
      .def_prop_ro("hold_after_ns", [](const bridge::Config& c) { return c.settings.hold_after_ns; })
      .def_prop_ro("quick_stop_after_ns", [](const bridge::Config& c) { return c.settings.quick_stop_after_ns; })
      .def_prop_ro("disarm_after_ns", [](const bridge::Config& c) { return c.settings.disarm_after_ns; })
      .def_prop_ro("joints", &joints_of, nb::sig("def joints(self) -> list[dict[str, typing.Any]]"))
      .def_prop_ro("buses", &buses_of, nb::sig("def buses(self) -> list[dict[str, typing.Any]]"));
}

void make_arm_load(load::ArmLoadSettings* place, const ScaledArm& arm, const ExoSettings& exo, double girdle_length_m) {
  load::ArmLoadSettings settings;
  settings.upper_arm = arm.upper_arm;
  settings.forearm = arm.forearm;
  settings.exo = exo;
  settings.girdle_length_m = girdle_length_m;
  load::ArmDynamics{settings};  // refuses here what it would refuse later
  new (place) load::ArmLoadSettings(settings);
}

void bind_load(nb::module_& module) {
  nb::class_<load::ArmLoadSettings>(module, "ArmLoad", "The arm that couples the drives; docs/drives.md.")
      .def("__init__", &make_arm_load, "arm"_a, "exo"_a, "girdle_length_m"_a,
           "ValueError naming variable, value, unit and rule.")
      .def_ro("gravity_m_per_s2", &load::ArmLoadSettings::gravity_m_per_s2);
}

/// The arm as the drives of a configuration carry it.
std::unique_ptr<drives::Load> carried(std::optional<load::ArmLoadSettings> settings, const bridge::Config& config) {
  if (!settings) return nullptr;
  const auto& joints = config.settings.joints;
  for (std::size_t j = 0; j < std::min(joints.size(), settings->joints.size()); ++j)
    settings->joints[j] = {static_cast<double>(joints[j].sign), joints[j].offset_rad};
  return std::make_unique<load::ArmLoad>(*settings);
}

/// The rig and what its record needs to know.
struct PythonRig {
  bridge::Config config;
  rig::Rig rig;
  std::size_t joints;
};

void make_rig(PythonRig* place, const bridge::Config& config, const std::vector<std::string>& profiles,
              const std::vector<double>& start_rad, std::uint64_t seed,
              const std::optional<load::ArmLoadSettings>& load) {
  if (profiles.size() != start_rad.size()) throw std::invalid_argument("profiles and start_rad: one of each a joint");
  std::vector<rig::DriveSetup> drives;
  for (std::size_t j = 0; j < profiles.size(); ++j) drives.push_back({drives::load_profile(profiles[j]), start_rad[j]});
  rig::RigOptions options;
  options.seed = seed;
  new (place) PythonRig{config, rig::Rig(config, drives, options, carried(load, config)), config.settings.joints.size()};
}

void play(PythonRig& own, const Integers& due_ns, const Integers& stamp_ns, const Integers& sequence,
          const Integers& session_xor, const Table& position_rad, const Table& velocity_rad_per_s) {
  const auto n = due_ns.size();
  const auto joints = static_cast<Eigen::Index>(own.joints);
  if (stamp_ns.size() != n || sequence.size() != n || session_xor.size() != n || position_rad.rows() != n ||
      velocity_rad_per_s.rows() != n || position_rad.cols() != joints || velocity_rad_per_s.cols() != joints)
    throw std::invalid_argument("setpoints: every array needs a row a setpoint and a column a joint");
  std::vector<rig::PlannedSetpoint> planned(static_cast<std::size_t>(n));
  for (Eigen::Index k = 0; k < n; ++k) {
    rig::PlannedSetpoint& one = planned[static_cast<std::size_t>(k)];
    one.due_ns = due_ns[k];
    one.setpoint.time_ns = stamp_ns[k];
    one.setpoint.sequence = sequence[k];
    one.setpoint.session = session_xor[k];
    one.setpoint.count = static_cast<std::int32_t>(own.joints);
    one.setpoint.valid_mask = static_cast<std::int32_t>((1U << own.joints) - 1U);
    for (std::size_t j = 0; j < own.joints; ++j) {
      one.setpoint.position_rad[j] = position_rad(k, static_cast<Eigen::Index>(j));
      one.setpoint.velocity_rad_per_s[j] = velocity_rad_per_s(k, static_cast<Eigen::Index>(j));
    }
  }
  own.rig.play(planned);
}

void schedule(PythonRig& own, const std::string& kind, std::int64_t at_ns, std::int64_t duration_ns, int joint, int bus,
              const std::string& drive_fault, std::uint32_t amount) {
  rig::Disturbance disturbance;
  const auto known = rig::disturbance_kind(kind);
  const auto fault = drives::fault_kind(drive_fault);
  if (!known) throw std::invalid_argument("kind = " + kind + ": no such disturbance");
  if (!fault) throw std::invalid_argument("drive_fault = " + drive_fault + ": no such fault of a drive");
  disturbance.kind = *known;
  disturbance.at_ns = at_ns;
  disturbance.duration_ns = duration_ns;
  disturbance.joint = joint;
  disturbance.bus = bus;
  disturbance.fault = {*fault, amount, 0};
  own.rig.schedule(disturbance);
}

nb::dict cycles_of(const PythonRig& own) {
  const auto& rows = own.rig.record().cycles;
  nb::dict out;
  out["time_ns"] = column(rows, [](const auto& r) { return r.time_ns; });
  out["state"] = column(rows, [](const auto& r) { return number(r.state); });
  out["fault"] = column(rows, [](const auto& r) { return number(r.fault); });
  out["powered_mask"] = column(rows, [](const auto& r) { return r.powered_mask; });
  out["position_rad"] = table(rows, own.joints, [](const auto& r) { return r.position_rad; });
  out["velocity_rad_per_s"] = table(rows, own.joints, [](const auto& r) { return r.velocity_rad_per_s; });
  out["torque_Nm"] = table(rows, own.joints, [](const auto& r) { return r.torque_Nm; });
  out["command_rad"] = table(rows, own.joints, [](const auto& r) { return r.command_rad; });
  return out;
}

nb::dict feedback_of(const PythonRig& own) {
  const auto& rows = own.rig.record().feedback;
  nb::dict out;
  out["time_ns"] = column(rows, [](const auto& r) { return r.feedback.time_ns; });
  out["sequence"] = column(rows, [](const auto& r) { return r.feedback.sequence; });
  out["session"] = column(rows, [](const auto& r) { return r.feedback.session; });
  out["sync_count"] = column(rows, [](const auto& r) { return r.feedback.sync_count; });
  out["setpoint_sequence"] = column(rows, [](const auto& r) { return r.feedback.setpoint_sequence; });
  out["state"] = column(rows, [](const auto& r) { return number(r.state); });
  out["valid_mask"] = column(rows, [](const auto& r) { return r.feedback.valid_mask; });
  out["position_rad"] = table(rows, own.joints, [](const auto& r) { return r.feedback.position_rad; });
  out["velocity_rad_per_s"] = table(rows, own.joints, [](const auto& r) { return r.feedback.velocity_rad_per_s; });
  out["effort_Nm"] = table(rows, own.joints, [](const auto& r) { return r.feedback.effort_Nm; });
  out["command_rad"] = table(rows, own.joints, [](const auto& r) { return r.feedback.command_rad; });
  out["statusword"] = table(rows, own.joints, [](const auto& r) { return r.feedback.statusword; });
  return out;
}

nb::dict setpoints_of(const PythonRig& own) {
  const auto& rows = own.rig.record().setpoints;
  nb::dict out;
  out["due_ns"] = column(rows, [](const auto& r) { return r.arrival_ns; });
  out["time_ns"] = column(rows, [](const auto& r) { return r.time_ns; });
  out["sequence"] = column(rows, [](const auto& r) { return r.sequence; });
  out["session"] = column(rows, [](const auto& r) { return r.session; });
  out["position_rad"] = table(rows, own.joints, [](const auto& r) { return r.position_rad; });
  out["velocity_rad_per_s"] = table(rows, own.joints, [](const auto& r) { return r.velocity_rad_per_s; });
  return out;
}

nb::dict commands_of(const PythonRig& own) {
  const auto& rows = own.rig.record().commands;
  nb::dict out;
  out["time_ns"] = column(rows, [](const auto& r) { return r.time_ns; });
  out["sequence"] = column(rows, [](const auto& r) { return r.sequence; });
  out["session"] = column(rows, [](const auto& r) { return r.session; });
  out["command"] = column(rows, [](const auto& r) { return number(r.request); });
  return out;
}

nb::dict frames_of(const PythonRig& own) {
  const auto& rows = own.rig.record().frames;
  nb::dict out;
  out["time_ns"] = column(rows, [](const auto& r) { return r.time_ns; });
  out["bus"] = column(rows, [](const auto& r) { return r.bus; });
  out["id"] = column(rows, [](const auto& r) { return r.frame.id | (r.frame.error ? 0x2000'0000U : 0U); });
  out["size"] = column(rows, [](const auto& r) { return r.frame.size; });
  out["data"] = table(rows, 8, [](const auto& r) { return r.frame.data; });
  return out;
}

nb::list events_of(const PythonRig& own) {
  nb::list out;
  for (const bridge::Event& event : own.rig.record().events) {
    nb::dict one;
    one["time_ns"] = event.time_ns;
    one["sequence"] = event.sequence;
    one["severity"] = number(event.severity);
    one["code"] = event.code;
    one["bus"] = event.bus;
    one["node"] = event.node;
    one["joint"] = event.joint;
    one["value"] = event.value;
    one["limit"] = event.limit;
    one["text"] = nb::str(event.text.data());
    out.append(one);
  }
  return out;
}

template <class T, class Get>
nb::list listed(const T& values, std::size_t count, Get get) {
  nb::list out;
  for (std::size_t k = 0; k < count; ++k) out.append(get(values[k]));
  return out;
}

nb::dict status_of(const bridge::Status& s) {
  nb::dict one;
  const auto joints = static_cast<std::size_t>(s.joint_count);
  const auto buses = static_cast<std::size_t>(s.bus_count);
  one["time_ns"] = s.time_ns;
  one["sequence"] = s.sequence;
  one["session"] = s.session;
  one["state"] = number(s.state);
  one["fault"] = number(s.fault);
  one["joint_count"] = s.joint_count;
  one["bus_count"] = s.bus_count;
  one["purge_needed"] = number(s.purge_needed);
  one["configured"] = number(s.configured);
  one["cycles"] = s.cycles;
  one["cycles_skipped"] = s.cycles_skipped;
  one["setpoints_accepted"] = s.setpoints_accepted;
  one["setpoints_rejected"] = s.setpoints_rejected;
  one["last_rejection"] = number(s.last_rejection);
  one["bus_state"] = listed(s.bus, buses, [](const auto& b) { return number(b.state); });
  one["bus_tx_errors"] = listed(s.bus, buses, [](const auto& b) { return b.tx_errors; });
  one["bus_rx_errors"] = listed(s.bus, buses, [](const auto& b) { return b.rx_errors; });
  one["bus_refused"] = listed(s.bus, buses, [](const auto& b) { return b.refused; });
  one["bus_outstanding"] = listed(s.bus, buses, [](const auto& b) { return b.outstanding; });
  one["bus_overruns"] = listed(s.bus, buses, [](const auto& b) { return b.overruns; });
  one["bus_load"] = listed(s.bus, buses, [](const auto& b) { return b.load; });
  one["node_id"] = listed(s.drive, joints, [](const auto& d) { return d.node_id; });
  one["nmt_state"] = listed(s.drive, joints, [](const auto& d) { return number(d.nmt); });
  one["drive_state"] = listed(s.drive, joints, [](const auto& d) { return number(d.state); });
  one["statusword"] = listed(s.drive, joints, [](const auto& d) { return d.statusword; });
  one["error_code"] = listed(s.drive, joints, [](const auto& d) { return d.error_code; });
  one["heartbeat_age_ns"] = listed(s.drive, joints, [](const auto& d) { return d.heartbeat_age_ns; });
  one["missed_feedback"] = listed(s.drive, joints, [](const auto& d) { return d.missed_feedback; });
  one["following_error_rad"] = listed(s.drive, joints, [](const auto& d) { return d.following_error_rad; });
  return one;
}

nb::list statuses_of(const PythonRig& own) {
  nb::list out;
  for (const bridge::Status& status : own.rig.record().statuses) out.append(status_of(status));
  return out;
}

nb::list drives_of(const PythonRig& own) {
  nb::list out;
  for (std::size_t j = 0; j < own.joints; ++j) {
    const drives::DriveCounters& counters = own.rig.drive(j).counters();
    nb::dict one;
    one["syncs"] = counters.syncs;
    one["missed_cycles"] = counters.missed_cycles;
    one["setpoints"] = counters.setpoints;
    one["missing_setpoints"] = counters.missing_setpoints;
    one["emergencies"] = counters.emergencies;
    one["last_emergency"] = counters.last_emergency;
    one["reboots"] = counters.reboots;
    one["worst_following_error_rad"] = counters.worst_following_error_rad;
    out.append(one);
  }
  return out;
}

void bind_class(nb::module_& module) {
  const char* const columns = "dict of arrays, a row each, oldest first";
  nb::class_<PythonRig>(module, "Rig", "Bridge core and simulated drives in virtual time; docs/rehearsal.md.")
      .def("__init__", &make_rig, "config"_a, "profiles"_a, "start_rad"_a, "seed"_a = 1, "load"_a = nb::none())
      .def(
          "run", [](PythonRig& own, std::int64_t n) { own.rig.run(n); }, "cycles"_a,
          nb::call_guard<nb::gil_scoped_release>())
      .def(
          "configure", [](PythonRig& own, std::int64_t n) { return own.rig.configure(n); }, "cycles"_a,
          nb::call_guard<nb::gil_scoped_release>())
      .def(
          "run_until",
          [](PythonRig& own, int state, std::int64_t n) {
            return own.rig.run_until(static_cast<bridge::State>(state), n);
          },
          "state"_a, "cycles"_a, nb::call_guard<nb::gil_scoped_release>())
      .def(
          "request", [](PythonRig& own, int what) { own.rig.request(static_cast<bridge::Request>(what)); }, "command"_a,
          "One of the constants of command_v1_t.")
      .def("play", &play, "due_ns"_a, "stamp_ns"_a, "sequence"_a, "session_xor"_a, "position_rad"_a,
           "velocity_rad_per_s"_a)
      .def("schedule", &schedule, "kind"_a, "at_ns"_a, "duration_ns"_a = 0, "joint"_a = -1, "bus"_a = 0,
           "drive_fault"_a = "none", "amount"_a = 0)
      .def("clear_record", [](PythonRig& own) { own.rig.clear_record(); })
      .def_prop_ro("now_ns", [](const PythonRig& own) { return own.rig.now_ns(); })
      .def_prop_ro("state", [](const PythonRig& own) { return number(own.rig.bridge().state()); })
      .def_prop_ro("fault", [](const PythonRig& own) { return number(own.rig.bridge().fault()); })
      .def_prop_ro("session", [](const PythonRig& own) { return own.rig.bridge().session(); })
      .def("cycles", &cycles_of, columns, nb::sig("def cycles(self) -> dict[str, NDArray[typing.Any]]"))
      .def("feedback", &feedback_of, columns, nb::sig("def feedback(self) -> dict[str, NDArray[typing.Any]]"))
      .def("setpoints", &setpoints_of, columns, nb::sig("def setpoints(self) -> dict[str, NDArray[typing.Any]]"))
      .def("commands", &commands_of, columns, nb::sig("def commands(self) -> dict[str, NDArray[typing.Any]]"))
      .def("frames", &frames_of, columns, nb::sig("def frames(self) -> dict[str, NDArray[typing.Any]]"))
      .def("events", &events_of, nb::sig("def events(self) -> list[dict[str, typing.Any]]"))
      .def("statuses", &statuses_of, nb::sig("def statuses(self) -> list[dict[str, typing.Any]]"))
      .def("drives", &drives_of, nb::sig("def drives(self) -> list[dict[str, typing.Any]]"));
}

}  // namespace

void bind_rig(nb::module_& module) {
  bind_config(module);
  bind_load(module);
  bind_class(module);
  module.def(
      "fault_words", [](int fault) { return bridge::words(static_cast<bridge::Fault>(fault)); }, "fault"_a);
}

}  // namespace glenoid::python
