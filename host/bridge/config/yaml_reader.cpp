#include "host/bridge/config/yaml_reader.hpp"

#include <charconv>
#include <cmath>

namespace glenoid::bridge {
namespace {

std::string shown(const YAML::Node& node) {
  if (!node.IsDefined() || node.IsNull()) return "nothing";
  if (node.IsScalar()) return node.Scalar().substr(0, 60);
  return node.IsSequence() ? "a list" : "a mapping";
}

std::string shown(double value) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%g", value);
  return buffer;
}

int line_of(const YAML::Node& node) { return node.IsDefined() && node.Mark().line >= 0 ? node.Mark().line + 1 : 0; }

/// The name without its unit: velocity_rad_per_s -> velocity.
std::string stem(const std::string& key) {
  static const std::vector<std::string> kUnits = {"rad", "deg",    "s",   "ms", "us", "ns",  "hz",   "Hz",   "Nm",
                                                  "nm",  "counts", "rpm", "m",  "mm", "bit", "kbit", "turn", "turns"};
  const std::size_t at = key.rfind("_per_");
  std::string head = at == std::string::npos ? key : key.substr(0, at);
  const std::size_t last = head.rfind('_');
  if (last != std::string::npos)
    for (const std::string& unit : kUnits)
      if (head.substr(last + 1) == unit) return head.substr(0, last);
  return head;
}

}  // namespace

ConfigError::ConfigError(int line, const std::string& key, const std::string& value, const std::string& rule)
    : std::invalid_argument("line " + std::to_string(line) + ": " + key + " = " + value + ": " + rule) {}

YamlReader::YamlReader(const YAML::Node& node, std::string path, const YAML::Node& defaults)
    : node_(node), defaults_(defaults), path_(std::move(path)) {
  if (node_.IsDefined() && !node_.IsNull() && !node_.IsMap())
    throw ConfigError(line_of(node_), path_, shown(node_), "must be a mapping");
  check_duplicates(node_);
  check_duplicates(defaults_);
}

void YamlReader::check_duplicates(const YAML::Node& node) const {
  if (!node.IsDefined() || !node.IsMap()) return;
  std::set<std::string> seen;
  for (const auto& entry : node) {
    if (!entry.first.IsScalar())
      throw ConfigError(line_of(entry.first), path_, shown(entry.first), "keys must be words");
    if (!seen.insert(entry.first.Scalar()).second)
      throw ConfigError(line_of(entry.first), path_ + "." + entry.first.Scalar(), shown(entry.second),
                        "this key is there twice");
  }
}

int YamlReader::line() const { return line_of(node_); }

YAML::Node YamlReader::find(const char* key) const {
  if (node_.IsDefined() && node_.IsMap()) {
    const YAML::Node own = node_[key];
    if (own.IsDefined() && !own.IsNull()) return own;
  }
  if (defaults_.IsDefined() && defaults_.IsMap()) return defaults_[key];
  return YAML::Node(YAML::NodeType::Undefined);
}

void YamlReader::fail(const char* key, const std::string& rule) const {
  const YAML::Node value = find(key);
  throw ConfigError(value.IsDefined() ? line_of(value) : line_of(node_), path_.empty() ? key : path_ + "." + key,
                    shown(value), rule);
}

std::string YamlReader::scalar(const char* key, bool& present) {
  known_.insert(key);
  const YAML::Node value = find(key);
  present = value.IsDefined() && !value.IsNull();
  if (!present) return {};
  if (!value.IsScalar()) fail(key, "must be a single value");
  return value.Scalar();
}

double YamlReader::number(const char* key, const Range& range, std::optional<double> otherwise) {
  bool present = false;
  const std::string text = scalar(key, present);
  if (!present) {
    if (otherwise) return *otherwise;
    finish();  // a misspelt key or unit explains more than a missing one
    fail(key, "is needed");
  }
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || stop != end || !std::isfinite(value)) fail(key, "must be a finite number");
  if (value < range.low || value > range.high || (range.open_low && value == range.low))
    fail(key, range.high >= 1e300 ? (range.open_low ? "must be above " : "must be at least ") + shown(range.low)
                                  : "must be between " + shown(range.low) + " and " + shown(range.high));
  return value;
}

std::int64_t YamlReader::integer(const char* key, std::int64_t low, std::int64_t high,
                                 std::optional<std::int64_t> otherwise) {
  bool present = false;
  const std::string text = scalar(key, present);
  if (!present) {
    if (otherwise) return *otherwise;
    finish();
    fail(key, "is needed");
  }
  const bool hex = text.starts_with("0x") || text.starts_with("0X");
  const char* const begin = text.data() + (hex ? 2 : 0);
  const char* const end = text.data() + text.size();
  std::int64_t value = 0;
  const auto [stop, error] = std::from_chars(begin, end, value, hex ? 16 : 10);
  if (error != std::errc{} || stop != end || (hex && value < 0)) fail(key, "must be a whole number");
  if (value < low || value > high) fail(key, "must be between " + std::to_string(low) + " and " + std::to_string(high));
  return value;
}

std::string YamlReader::text(const char* key, std::optional<std::string> otherwise) {
  bool present = false;
  const std::string value = scalar(key, present);
  if (present && !value.empty()) return value;
  if (otherwise) return *otherwise;
  finish();
  fail(key, "is needed");
}

std::size_t YamlReader::choice(const char* key, const std::vector<std::string>& choices,
                               std::optional<std::size_t> otherwise) {
  bool present = false;
  const std::string value = scalar(key, present);
  if (!present && otherwise) return *otherwise;
  std::string all;
  for (std::size_t k = 0; k < choices.size(); ++k) {
    if (present && value == choices[k]) return k;
    all += (k == 0 ? "" : ", ") + choices[k];
  }
  fail(key, "must be one of " + all);
}

std::int64_t YamlReader::milliseconds(const char* key, const Range& range_ms, std::optional<double> otherwise_ms) {
  return std::llround(1e6 * number(key, range_ms, otherwise_ms));
}

YamlReader YamlReader::mapping(const char* key) {
  known_.insert(key);
  const YAML::Node own = node_.IsDefined() && node_.IsMap() ? node_[key] : YAML::Node(YAML::NodeType::Undefined);
  const YAML::Node other = defaults_.IsDefined() && defaults_.IsMap() ? defaults_[key]
                                                                      : YAML::Node(YAML::NodeType::Undefined);
  return YamlReader(own, path_.empty() ? key : path_ + "." + key, other);
}

YAML::Node YamlReader::raw(const char* key) {
  known_.insert(key);
  return find(key);
}

YAML::Node YamlReader::list(const char* key) {
  const YAML::Node value = raw(key);
  if (value.IsDefined() && !value.IsNull() && !value.IsSequence()) fail(key, "must be a list");
  return value;
}

void YamlReader::finish() const {
  finish(node_);
  finish(defaults_);
}

void YamlReader::finish(const YAML::Node& node) const {
  if (!node.IsDefined() || !node.IsMap()) return;
  for (const auto& entry : node) {
    const std::string key = entry.first.Scalar();
    if (known_.contains(key)) continue;
    std::string rule = "this key is not known here";
    for (const std::string& known : known_)
      if (stem(known) == stem(key)) rule = "wrong unit: write " + known;
    throw ConfigError(line_of(entry.first), path_.empty() ? key : path_ + "." + key, shown(entry.second), rule);
  }
}

}  // namespace glenoid::bridge
