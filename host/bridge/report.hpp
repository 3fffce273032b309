#pragma once

#include <string>

#include "host/bridge/config/config.hpp"
#include "host/bridge/loop/loop.hpp"

namespace glenoid::bridge {

/// Joints, buses, loads and warnings of a configuration, for people.
[[nodiscard]] std::string describe(const Config& config);

/// Figures of a run as a table for people.
[[nodiscard]] std::string describe(const LoopFigures& figures, const Status& status);
/// The same as one JSON object.
[[nodiscard]] std::string to_json(const LoopFigures& figures, const Status& status);

/// One line: "12.345 s  error  DriveEmergency ...".
[[nodiscard]] std::string describe(const Event& event);

/// Whether a rehearsal of the same configuration passed: FOLDER/rehearsal.json has verdict PASS and this hash.
/// Empty: yes; otherwise why not.
[[nodiscard]] std::string rehearsal_obstacle(const std::string& folder, const std::string& hash);

}  // namespace glenoid::bridge
