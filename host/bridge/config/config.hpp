#pragma once

// The configuration of a bridge: one YAML file with named exoskeletons, read strictly and checked once.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "host/bridge/config/yaml_reader.hpp"
#include "host/bridge/core/messages.hpp"
#include "host/bridge/core/settings.hpp"

namespace glenoid::bridge {

struct BusConfig {
  std::string name;
  std::string url;  ///< as can::open_port takes it
  double bit_rate_bit_per_s = 1e6;
  double worst_case_load = 0.0;  ///< 0..1, computed
};

struct Config {
  Settings settings;
  std::vector<BusConfig> buses;
  std::string side;
  std::string device;  ///< device file of `glenoid --exo` that joints, ranges and side were taken from; empty: not said
  std::string device_sha256;  ///< its fingerprint, as `glenoid info --exo` prints it
  /// Part of the period between SYNC and RPDOs: behind the drives' answers, well before the next SYNC.
  double rpdo_phase = 0.5;
  std::vector<std::string> warnings;
};

/// Names of the exoskeletons in a file.
/// @throws ConfigError
[[nodiscard]] std::vector<std::string> exoskeleton_names(const std::string& yaml);

/// @param name  which exoskeleton; empty where the file has one only
/// @throws ConfigError  unknown key, wrong unit, impossible value, overloaded bus: with line, key, value and rule
[[nodiscard]] Config parse_config(const std::string& yaml, std::string_view name = {});

/// @throws std::runtime_error  the file cannot be read; ConfigError as parse_config
[[nodiscard]] Config load_config(const std::filesystem::path& file, std::string_view name = {});

/// Everything that decides how drives are moved, in one order, one line each: two configurations that read the same here
/// behave the same. URLs of the buses are left out: a rehearsal runs on another bus.
[[nodiscard]] std::string canonical(const Config& config);

/// SHA-256 of `canonical`, hexadecimal.
[[nodiscard]] std::string config_hash(const Config& config);

}  // namespace glenoid::bridge
