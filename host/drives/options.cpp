#include "host/drives/options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

namespace glenoid::drives {
namespace {

constexpr double kNsPerS = 1e9, kMost_s = 1e9;
constexpr double kMostStart_rad = 1000.0;  // well within 32-bit counts
constexpr std::uint32_t kMostNode = 127;

/// The number that a whole text is.
double number_in(const std::string& text, const std::string& what) {
  std::size_t used = 0;
  double value = std::nan("");
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != text.size() || !std::isfinite(value)) {
    throw std::invalid_argument(what + " = " + text + ": not a number");
  }
  return value;
}

/// A time, s.
double seconds_in(const std::string& text, const std::string& what) {
  const double value = number_in(text, what);
  if (value < 0.0 || value > kMost_s) throw std::invalid_argument(what + " = " + text + " s: must be 0 to 1e9");
  return value;
}

std::uint32_t count_in(const std::string& text, const std::string& what, std::uint32_t most, std::uint32_t least = 0) {
  const double value = number_in(text, what);
  if (value < least || value > most || value != std::floor(value)) {
    throw std::invalid_argument(what + " = " + text + ": must be a whole number from " + std::to_string(least) +
                                " to " + std::to_string(most));
  }
  return static_cast<std::uint32_t>(value);
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

/// "1-6" or "1,2,5".
std::vector<std::uint8_t> parse_nodes(const std::string& text) {
  std::vector<std::uint8_t> nodes;
  for (const std::string& part : split(text, ',')) {
    const std::vector<std::string> ends = split(part, '-');
    const std::uint32_t first = count_in(ends.front(), "--nodes", kMostNode, 1);
    const std::uint32_t last = count_in(ends.back(), "--nodes", kMostNode, 1);
    if (ends.size() > 2 || last < first) {
      throw std::invalid_argument("--nodes = " + part + ": must be one id, or FIRST-LAST with FIRST not above LAST");
    }
    for (std::uint32_t node = first; node <= last; ++node) nodes.push_back(static_cast<std::uint8_t>(node));
  }
  return nodes;
}

/// The profile files beside the program: ../share/glenoid/drives.
std::filesystem::path profile_file(const std::string& name) {
  if (std::filesystem::exists(name)) return name;
  const auto program = std::filesystem::read_symlink("/proc/self/exe");
  const auto shipped = program.parent_path().parent_path() / "share/glenoid/drives";
  const auto file = shipped / (name + ".yaml");
  if (std::filesystem::exists(file)) return file;
  std::vector<std::string> names;
  if (std::filesystem::is_directory(shipped))
    for (const auto& entry : std::filesystem::directory_iterator(shipped))
      names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  std::string known;
  for (const std::string& one : names) known.append(one).append(", ");
  const std::string place = known.empty() ? "; there are none in " : "in ";
  throw std::invalid_argument("--profile = " + name + ": must be a file" + (known.empty() ? "" : " or one of ") +
                              known + place + shipped.string());
}

/// "nominal" for all drives, "3=isel_imd20" for one.
void choose_profiles(const std::vector<std::string>& wanted, Options& options) {
  options.profiles.assign(options.nodes.size(), load_profile(profile_file("nominal")));
  for (const std::string& text : wanted) {
    const std::vector<std::string> parts = split(text, '=');
    if (parts.size() > 2) throw std::invalid_argument("--profile = " + text + ": must be NAME or NODE=NAME");
    const Profile profile = load_profile(profile_file(parts.back()));
    bool used = false;
    for (std::size_t k = 0; k < options.nodes.size(); ++k) {
      if (parts.size() == 2 && count_in(parts[0], "--profile", kMostNode, 1) != options.nodes[k]) continue;
      options.profiles[k] = profile;
      used = true;
    }
    if (!used) throw std::invalid_argument("--profile " + text + ": no such node");
  }
}

}  // namespace

ScheduledFault parse_fault(const std::string& text) {
  ScheduledFault planned;
  bool has_kind = false;
  for (const std::string& part : split(text, ',')) {
    const std::vector<std::string> pair = split(part, '=');
    if (pair.size() != 2) throw std::invalid_argument("fault " + text + ": " + part + " is not key=value");
    const std::string what = "fault " + text + ": " + pair[0];
    if (pair[0] == "node") {
      planned.node = static_cast<std::uint8_t>(count_in(pair[1], what, kMostNode));
    } else if (pair[0] == "at") {
      planned.at_ns = std::llround(seconds_in(pair[1], what) * kNsPerS);
    } else if (pair[0] == "amount") {
      planned.fault.amount = count_in(pair[1], what, 0xFFFFFFFF);
    } else if (pair[0] == "ms") {
      planned.fault.duration_ms = count_in(pair[1], what, 0xFFFFFFFF);
    } else if (pair[0] == "kind") {
      const auto kind = fault_kind(pair[1]);
      if (!kind) throw std::invalid_argument(what + " = " + pair[1] + ": no such fault");
      planned.fault.kind = *kind;
      has_kind = true;
    } else {
      throw std::invalid_argument(what + ": unknown key");
    }
  }
  if (!has_kind) throw std::invalid_argument("fault " + text + ": kind is missing");
  const std::uint32_t most = planned.fault.kind == FaultKind::Drop        ? 1000
                             : planned.fault.kind == FaultKind::Emergency ? 0xFFFF
                                                                          : 0xFFFFFFFF;
  if (planned.fault.amount > most)
    throw std::invalid_argument("fault " + text + ": amount = " + std::to_string(planned.fault.amount) +
                                ": must be at most " + std::to_string(most));
  return planned;
}

std::optional<int> parse(int argc, char** argv, Options& options) {
  CLI::App app("Simulated CANopen CiA 402 joint drives. Research software, not a medical device.", "glenoid-drives");
  std::string nodes = "1-6", duration = "0";
  std::vector<std::string> profiles, faults;
  app.add_option("--bus", options.bus, "socketcan:NAME or udp:GROUP[:PORT]")->capture_default_str();
  app.add_option("--nodes", nodes, "Node ids, as 1-6 or 1,2,5; at most 16")->capture_default_str();
  app.add_option("--profile", profiles, "Drive family: NAME or FILE for all, or NODE=NAME; repeatable (nominal)");
  app.add_option("--start-rad", options.start_rad, "Joint positions at power-up, rad, one a node (0)")->delimiter(',');
  app.add_option("--fault", faults,
                 "node=3,at=2.5,kind=emcy[,amount=N][,ms=N]; at in s after the start; repeatable. "
                 "Kinds: drop delay stall emcy reboot stuck-encoder bus-off jam none");
  app.add_option("--load", options.load, "File of the arm that the drives carry (load.yaml of a rehearsal)");
  std::string seed = std::to_string(options.seed);
  app.add_option("--seed", seed, "Of the frames that the fault drop loses")->capture_default_str();
  app.add_option("--duration-s", duration, "End after this long, s; 0: at SIGINT or SIGTERM")->capture_default_str();
  app.add_option("--report", options.report, "Write the JSON report there instead of to standard output");
  app.add_option("--eds", options.eds, "Write the electronic data sheet of the first node's profile and end");
  app.add_flag("--realtime", options.realtime, "SCHED_FIFO and locked memory (needs the right to)");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  options.seed = count_in(seed, "--seed", 0xFFFFFFFF);
  options.duration_s = seconds_in(duration, "--duration-s");
  options.nodes = parse_nodes(nodes);
  choose_profiles(profiles, options);
  for (const std::string& text : faults) {
    options.faults.push_back(parse_fault(text));
    const std::uint8_t node = options.faults.back().node;
    if (node != 0 && std::find(options.nodes.begin(), options.nodes.end(), node) == options.nodes.end())
      throw std::invalid_argument("fault " + text + ": node = " + std::to_string(node) + ": must be one of --nodes " +
                                  nodes);
  }
  for (const double start : options.start_rad)
    if (!(std::abs(start) <= kMostStart_rad)) throw std::invalid_argument("--start-rad: must be -1000 to 1000 rad");
  if (options.start_rad.empty()) options.start_rad.assign(options.nodes.size(), 0.0);
  if (options.start_rad.size() != options.nodes.size()) {
    throw std::invalid_argument("--start-rad: " + std::to_string(options.start_rad.size()) + " values for " +
                                std::to_string(options.nodes.size()) + " nodes");
  }
  return std::nullopt;
}

}  // namespace glenoid::drives
