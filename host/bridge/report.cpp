#include "host/bridge/report.hpp"

#include <cstdio>
#include <fstream>
#include <iterator>

#include "host/bridge/can/open_port.hpp"

namespace glenoid::bridge {
namespace {

template <class... Arguments>
std::string line(const char* format, Arguments... arguments) {
  char text[400];
  std::snprintf(text, sizeof text, format, arguments...);
  return text;
}

struct Row {
  const char* name;
  const char* key;
  const Histogram& values;
};

std::vector<Row> rows(const LoopFigures& figures) {
  return {{"wake-up behind the deadline", "wake_up", figures.wake_up},
          {"SYNC interval error", "sync_error", figures.sync_error},
          {"RPDO after SYNC", "rpdo_after_sync", figures.rpdo_after_sync},
          {"TPDO after SYNC", "tpdo_after_sync", figures.tpdo_after_sync},
          {"setpoint to wire", "setpoint_to_wire", figures.setpoint_to_wire},
          {"processor time of a cycle", "cycle_cpu", figures.cycle_cpu},
          {"  of it awake before the SYNC", "cycle_awake", figures.awake},
          {"  of it in the core", "cycle_core", figures.core},
          {"  of it in the buses' ports", "cycle_port", figures.port},
          {"  of it for messages", "cycle_lcm", figures.lcm}};
}

}  // namespace

std::string describe(const Config& config) {
  const Settings& s = config.settings;
  std::string text = line("exoskeleton %s (%s arm), %zu joints, SYNC every %g ms\n", s.name.c_str(),
                          config.side.c_str(), s.joints.size(), 1e-6 * static_cast<double>(s.period_ns));
  for (const BusConfig& bus : config.buses)
    text += line("  bus %-12s %-24s %4.0f kbit/s, worst-case load %2.0f %%%s\n", bus.name.c_str(), bus.url.c_str(),
                 1e-3 * bus.bit_rate_bit_per_s, 100.0 * bus.worst_case_load,
                 can::is_virtual(bus.url) ? ", virtual" : "");
  for (const JointSettings& joint : s.joints)
    text += line("  joint %-20s bus %-8s node %3d  %7.3f .. %6.3f rad  %5.2f rad/s  %6.1f rad/s2\n", joint.name.c_str(),
                 config.buses[joint.bus].name.c_str(), int{joint.node}, joint.lower_rad, joint.upper_rad,
                 joint.velocity_rad_per_s, joint.acceleration_rad_per_s2);
  for (const std::string& warning : config.warnings) text += "  warning: " + warning + "\n";
  return text + "config_hash " + config_hash(config) + "\n";
}

std::string describe(const LoopFigures& figures, const Status& status) {
  std::string text = line("%-30s %9s %9s %9s %9s %9s\n", "us", "p50", "p99", "p99.9", "max", "count");
  for (const Row& row : rows(figures))
    text += line("%-30s %9.1f %9.1f %9.1f %9.1f %9llu\n", row.name, row.values.quantile_us(0.5),
                 row.values.quantile_us(0.99), row.values.quantile_us(0.999), row.values.largest_us(),
                 static_cast<unsigned long long>(row.values.count()));
  return text +
         line("cycles %llu, left out %llu; setpoints %lld accepted, %lld rejected\n",
              static_cast<unsigned long long>(figures.cycles), static_cast<unsigned long long>(figures.late_cycles),
              static_cast<long long>(status.setpoints_accepted), static_cast<long long>(status.setpoints_rejected));
}

std::string to_json(const LoopFigures& figures, const Status& status) {
  std::string text = line(
      "{\"cycles\": %llu, \"late_cycles\": %llu, \"setpoints_accepted\": %lld, "
      "\"setpoints_rejected\": %lld",
      static_cast<unsigned long long>(figures.cycles), static_cast<unsigned long long>(figures.late_cycles),
      static_cast<long long>(status.setpoints_accepted), static_cast<long long>(status.setpoints_rejected));
  for (const Row& row : rows(figures))
    text += line(", \"%s_us\": {\"p50\": %.3f, \"p99\": %.3f, \"p99.9\": %.3f, \"max\": %.3f, \"count\": %llu}",
                 row.key, row.values.quantile_us(0.5), row.values.quantile_us(0.99), row.values.quantile_us(0.999),
                 row.values.largest_us(), static_cast<unsigned long long>(row.values.count()));
  return text + "}\n";
}

std::string describe(const Event& event) {
  static constexpr const char* kSeverity[] = {"info", "warning", "error"};
  return line("%12.3f s  %-7s  %s", 1e-9 * static_cast<double>(event.time_ns),
              kSeverity[static_cast<int>(event.severity)], event.text.data());
}

std::string rehearsal_obstacle(const std::string& folder, const std::string& hash) {
  if (folder.empty()) return "a real bus needs a passed rehearsal of this configuration (--rehearsal FOLDER)";
  std::ifstream stream(folder + "/rehearsal.json");
  if (!stream) return "no rehearsal.json in " + folder;
  try {
    const std::string json((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    const YAML::Node report = YAML::Load(json);  // JSON is YAML
    if (report["verdict"].as<std::string>("") != "PASS") return "the rehearsal in " + folder + " did not pass";
    if (report["faults"].as<int>(-1) != 0) return "the rehearsal in " + folder + " is one with faults injected";
    if (!report["not_decided_by"].IsSequence() || report["not_decided_by"].size() != 0)
      return "the rehearsal in " + folder + " has checks that did not decide its verdict";
    if (report["config_hash"].as<std::string>("") != hash)
      return "the rehearsal in " + folder + " is of another configuration";
    return {};
  } catch (const YAML::Exception&) {
    return folder + "/rehearsal.json cannot be read";
  }
}

}  // namespace glenoid::bridge
