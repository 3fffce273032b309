#include "host/bridge/report.hpp"

#include <array>
#include <cstdio>
#include <filesystem>
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

struct Name {
  const char* words;
  const char* key;
};
// In the order of Figures.
constexpr std::array<Name, kFigures> kNames = {{{"wake-up behind the deadline", "wake_up"},
                                                {"SYNC interval error", "sync_error"},
                                                {"RPDO after SYNC", "rpdo_after_sync"},
                                                {"TPDO after SYNC", "tpdo_after_sync"},
                                                {"setpoint to wire", "setpoint_to_wire"},
                                                {"processor time of a cycle", "cycle_cpu"},
                                                {"  of it awake before the SYNC", "cycle_awake"},
                                                {"  of it in the core", "cycle_core"},
                                                {"  of it in the buses' ports", "cycle_port"},
                                                {"  of it for messages", "cycle_lcm"}}};

}  // namespace

std::string describe(const Config& config) {
  const Settings& s = config.settings;
  std::string text = line("exoskeleton %s (%s arm), %zu joints, SYNC every %g ms\n", s.name.c_str(),
                          config.side.c_str(), s.joints.size(), 1e-6 * static_cast<double>(s.period_ns));
  if (!config.device.empty())
    text += line("  device %s %.12s: sources made for another one are refused\n", config.device.c_str(),
                 config.device_sha256.c_str());
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

std::string describe(const Figures& figures) {
  std::string text = line("%-30s %9s %9s %9s %9s %9s\n", "us", "p50", "p99", "p99.9", "max", "count");
  for (std::size_t k = 0; k < kFigures; ++k) {
    const Figure& one = figures.figure[k];
    text += line("%-30s %9.1f %9.1f %9.1f %9.1f %9lld\n", kNames[k].words, one.p50_us, one.p99_us, one.p999_us,
                 one.largest_us, static_cast<long long>(one.values));
  }
  return text + line("cycles %lld, left out %lld; setpoints %lld accepted, %lld rejected\n",
                     static_cast<long long>(figures.cycles), static_cast<long long>(figures.cycles_left_out),
                     static_cast<long long>(figures.setpoints_accepted),
                     static_cast<long long>(figures.setpoints_rejected));
}

std::string to_json(const Figures& figures) {
  std::string text = line(
      "{\"time_mono_s\": %.3f, \"cycles\": %lld, \"late_cycles\": %lld, "
      "\"setpoints_accepted\": %lld, \"setpoints_rejected\": %lld",
      1e-9 * static_cast<double>(figures.time_ns), static_cast<long long>(figures.cycles),
      static_cast<long long>(figures.cycles_left_out), static_cast<long long>(figures.setpoints_accepted),
      static_cast<long long>(figures.setpoints_rejected));
  for (std::size_t k = 0; k < kFigures; ++k) {
    const Figure& one = figures.figure[k];
    text += line(", \"%s_us\": {\"p50\": %.3f, \"p99\": %.3f, \"p99.9\": %.3f, \"max\": %.3f, \"count\": %lld}",
                 kNames[k].key, one.p50_us, one.p99_us, one.p999_us, one.largest_us, static_cast<long long>(one.values));
  }
  return text + "}\n";
}

bool write_whole(const std::string& file, const std::string& content) {
  std::error_code error;
  const bool device = std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error);
  const std::string draft = device ? file : file + ".new";
  if (!(std::ofstream(draft) << content).flush()) return false;
  if (!device) std::filesystem::rename(draft, file, error);
  return !error;
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
