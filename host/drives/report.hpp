#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/drives/group.hpp"

namespace glenoid::drives {

/// What a group saw and did, as JSON. @param profiles  name of each drive's profile, in the group's order
std::string json_report(const DriveGroup& group, const std::vector<std::string>& profiles, std::string_view bus);

/// Words for states: "operational", "operation-enabled", ...
std::string_view name(Nmt state) noexcept;
std::string_view name(PowerState state) noexcept;

}  // namespace glenoid::drives
