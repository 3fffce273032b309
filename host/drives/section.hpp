#pragma once

// Reading a YAML file key by key, with messages that name file, key, value and rule. Private to files of the drives.

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace glenoid::drives {

/// One mapping of a file; remembers where it is for messages.
class Section {
 public:
  Section(YAML::Node node, std::string place) : node_(std::move(node)), place_(std::move(place)) {
    if (node_ && !node_.IsMap()) fail("must be a mapping");
  }

  void allow_only(std::initializer_list<std::string_view> keys) const {
    for (const auto& entry : node_) {
      const auto key = entry.first.as<std::string>();
      bool known = false;
      for (const std::string_view allowed : keys) known = known || allowed == key;
      if (!known) fail("unknown key " + key);
    }
  }
  [[nodiscard]] Section section(const std::string& key) const { return {get(key), place_ + "." + key}; }
  [[nodiscard]] YAML::Node get(const std::string& key) const { return node_ ? node_[key] : YAML::Node(); }
  [[nodiscard]] const YAML::Node& node() const { return node_; }

  template <class T>
  void read(const std::string& key, T& value) const {
    const YAML::Node found = get(key);
    if (!found || found.IsNull()) return;
    try {
      value = found.as<T>();
    } catch (const YAML::Exception&) {
      fail(key + " = " + found.as<std::string>("?") + ": wrong type");
    }
  }
  /// A list of exactly as many numbers as there is room for.
  void read_list(const std::string& key, std::span<double> values) const {
    const YAML::Node found = get(key);
    if (!found) return;
    if (!found.IsSequence() || found.size() != values.size()) {
      fail(key + ": must be a list of " + std::to_string(values.size()) + " numbers");
    }
    for (std::size_t k = 0; k < values.size(); ++k) {
      const auto text = found[k].as<std::string>("?");
      values[k] = found[k].as<double>(std::nan(""));
      if (!std::isfinite(values[k])) fail(key + "[" + std::to_string(k) + "] = " + text + ": must be a finite number");
    }
  }
  void read_positive(const std::string& key, double& value) const {
    read(key, value);
    if (!std::isfinite(value) || value <= 0.0) fail(key + " = " + std::to_string(value) + ": must be above 0");
  }
  void read_not_negative(const std::string& key, double& value) const {
    read(key, value);
    if (!std::isfinite(value) || value < 0.0) fail(key + " = " + std::to_string(value) + ": must not be negative");
  }
  [[noreturn]] void fail(const std::string& what) const { throw std::invalid_argument(place_ + ": " + what); }

 private:
  YAML::Node node_;
  std::string place_;
};

/// The whole file. @throws std::invalid_argument naming the file and what YAML finds wrong
inline Section read_yaml(const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file)) throw std::invalid_argument(file.string() + ": no such file");
  try {
    return {YAML::LoadFile(file.string()), file.filename().string()};
  } catch (const YAML::Exception& error) {
    throw std::invalid_argument(file.string() + ": " + error.what());
  }
}

}  // namespace glenoid::drives
