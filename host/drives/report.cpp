#include "host/drives/report.hpp"

#include <array>
#include <cstdio>

namespace glenoid::drives {
namespace {

/// Writes one JSON object, key by key.
class JsonObject {
 public:
  void text(std::string_view key, std::string_view value) {
    begin(key);
    text_ += '"';
    for (const char c : value) {
      if (c == '"' || c == '\\') text_ += '\\';
      text_ += c;
    }
    text_ += '"';
  }
  void number(std::string_view key, std::uint64_t value) { raw(key, std::to_string(value)); }
  void number(std::string_view key, double value) {
    std::array<char, 40> digits{};
    std::snprintf(digits.data(), digits.size(), "%.9g", value);
    raw(key, digits.data());
  }
  void raw(std::string_view key, std::string_view value) {
    begin(key);
    text_ += value;
  }
  [[nodiscard]] std::string end() const { return text_ + "}"; }

 private:
  void begin(std::string_view key) {
    text_ += text_.size() > 1 ? ", \"" : "\"";
    text_.append(key).append("\": ");
  }
  std::string text_ = "{";
};

std::string describe(const Drive& drive, const std::string& profile) {
  const DriveView view = drive.view();
  const DriveCounters& counters = drive.counters();
  JsonObject json;
  json.number("node", std::uint64_t{drive.node()});
  json.text("profile", profile);
  json.text("nmt", name(view.nmt));
  json.text("state", name(view.state));
  json.number("position_rad", view.position_rad);
  json.number("syncs", counters.syncs);
  json.number("missed_cycles", counters.missed_cycles);
  json.number("answers", counters.answers_due);
  json.number("setpoints", counters.setpoints);
  json.number("missing_setpoints", counters.missing_setpoints);
  json.number("bad_pdos", counters.bad_pdos);
  json.number("emergencies", counters.emergencies);
  json.number("last_emergency", std::uint64_t{counters.last_emergency});
  json.number("reboots", counters.reboots);
  json.number("worst_following_error_rad", counters.worst_following_error_rad);
  json.text("fault", name(view.fault.kind));
  return json.end();
}

}  // namespace

std::string_view name(Nmt state) noexcept {
  switch (state) {
    case Nmt::Initialising:
      return "initialising";
    case Nmt::Stopped:
      return "stopped";
    case Nmt::Operational:
      return "operational";
    case Nmt::PreOperational:
      return "pre-operational";
  }
  return "";
}

std::string_view name(PowerState state) noexcept {
  switch (state) {
    case PowerState::NotReady:
      return "not-ready";
    case PowerState::SwitchOnDisabled:
      return "switch-on-disabled";
    case PowerState::ReadyToSwitchOn:
      return "ready-to-switch-on";
    case PowerState::SwitchedOn:
      return "switched-on";
    case PowerState::OperationEnabled:
      return "operation-enabled";
    case PowerState::QuickStopActive:
      return "quick-stop-active";
    case PowerState::FaultReaction:
      return "fault-reaction";
    case PowerState::Fault:
      return "fault";
  }
  return "";
}

std::string json_report(const DriveGroup& group, const std::vector<std::string>& profiles, std::string_view bus) {
  const GroupCounters& counters = group.counters();
  std::string list;
  for (std::size_t k = 0; k < group.drives().size(); ++k) {
    list += (k == 0 ? "\n  " : ",\n  ") + describe(group.drives()[k], profiles[k]);
  }
  JsonObject json;
  json.text("bus", bus);
  json.number("syncs", counters.syncs);
  json.number("unanswered_syncs", counters.unanswered_syncs);
  json.number("late_syncs", counters.late_syncs);
  json.number("refused_frames", counters.refused_frames);
  json.raw("drives", "[" + list + "]");
  return json.end() + "\n";
}

}  // namespace glenoid::drives
