#pragma once

#include <memory>
#include <vector>

#include "host/bridge/can/port.hpp"
#include "host/bridge/config/config.hpp"

namespace glenoid::bridge {

/// Listens and prints what happens on the buses, in words; process data once a second, everything else as it comes.
/// Sends nothing.
/// @param duration_s  0: until the process ends
/// @return exit status
int monitor(const Config& config, std::vector<std::unique_ptr<can::Port>> ports, double duration_s);

}  // namespace glenoid::bridge
