#pragma once

// Strict reading of a YAML mapping: every key is known and there once, every value has its type, unit and range. What is wrong
// is told with line, key, value and rule.

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace glenoid::bridge {

/// "line 12: limits.velocity_rad_per_s = -3: must be above 0"
class ConfigError : public std::invalid_argument {
 public:
  ConfigError(int line, const std::string& key, const std::string& value, const std::string& rule);
};

/// One mapping, with an optional second one that holds the defaults for missing keys.
class YamlReader {
 public:
  struct Range {
    double low;
    double high;
    bool open_low = false;  ///< low itself is not allowed
  };

  /// @param path  of keys that lead here, for messages
  /// @throws ConfigError  `node` is no mapping, or has a key twice
  YamlReader(const YAML::Node& node, std::string path, const YAML::Node& defaults = YAML::Node());

  /// Values; without `otherwise` the key is needed. @throws ConfigError
  double number(const char* key, const Range& range, std::optional<double> otherwise = {});
  std::int64_t integer(const char* key, std::int64_t low, std::int64_t high, std::optional<std::int64_t> otherwise = {});
  std::string text(const char* key, std::optional<std::string> otherwise = {});
  /// Index of the value in `choices`.
  std::size_t choice(const char* key, const std::vector<std::string>& choices,
                     std::optional<std::size_t> otherwise = {});
  /// A duration under a key that ends in _ms, in ns.
  std::int64_t milliseconds(const char* key, const Range& range_ms, std::optional<double> otherwise_ms = {});

  /// A mapping below; missing ones are empty, so that needed keys inside are complained about.
  YamlReader mapping(const char* key);
  /// A list below; empty where missing.
  YAML::Node list(const char* key);
  YAML::Node raw(const char* key);

  /// Complains about keys nobody asked for; says which unit was meant where only that differs.
  void finish() const;

  [[noreturn]] void fail(const char* key, const std::string& rule) const;
  [[nodiscard]] int line() const;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  [[nodiscard]] YAML::Node find(const char* key) const;
  [[nodiscard]] std::string scalar(const char* key, bool& present);
  void check_duplicates(const YAML::Node& node) const;
  void finish(const YAML::Node& node) const;

  YAML::Node node_;
  YAML::Node defaults_;
  std::string path_;
  std::set<std::string> known_;
};

}  // namespace glenoid::bridge
