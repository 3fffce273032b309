#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/drives/group.hpp"

namespace glenoid::drives {

/// Command line of glenoid-drives.
struct Options {
  std::string bus = "udp:239.74.163.2";
  std::vector<std::uint8_t> nodes = {1, 2, 3, 4, 5, 6};
  std::vector<Profile> profiles;  ///< one a node
  std::vector<double> start_rad;  ///< one a node
  std::vector<ScheduledFault> faults;
  std::uint64_t seed = 1;
  double duration_s = 0.0;  ///< 0: until SIGINT or SIGTERM
  std::string load;         ///< file of the arm that the drives carry; empty: none
  std::string report;       ///< file; empty: standard output
  std::string eds;          ///< write this file and end
  bool realtime = false;
};

/// Reads the command line. Prints help or a message itself; then the value is the exit status.
/// @throws std::invalid_argument for values that do not fit together, profiles included
std::optional<int> parse(int argc, char** argv, Options& options);

/// "node=3,at=2.5,kind=emcy[,amount=N][,ms=N]"; at in s; without node, all drives.
/// @throws std::invalid_argument naming the part that is wrong
ScheduledFault parse_fault(const std::string& text);

}  // namespace glenoid::drives
