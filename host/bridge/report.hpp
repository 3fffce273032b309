#pragma once

#include <string>

#include "host/bridge/config/config.hpp"
#include "host/bridge/loop/loop.hpp"

namespace glenoid::bridge {

/// Joints, buses, loads and warnings of a configuration, for people.
[[nodiscard]] std::string describe(const Config& config);

/// Figures of a run as a table for people.
[[nodiscard]] std::string describe(const Figures& figures);
/// The same as one JSON object.
[[nodiscard]] std::string to_json(const Figures& figures);
/// Replaces a file as a whole: a reader sees the old content or the new one. False where it cannot be written.
[[nodiscard]] bool write_whole(const std::string& file, const std::string& content);

/// One line: "12.345 s  error  DriveEmergency ...".
[[nodiscard]] std::string describe(const Event& event);

/// Whether a rehearsal of the same configuration passed: FOLDER/rehearsal.json has verdict PASS and this hash.
/// Empty: yes; otherwise why not.
[[nodiscard]] std::string rehearsal_obstacle(const std::string& folder, const std::string& hash);

}  // namespace glenoid::bridge
