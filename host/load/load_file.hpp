#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "host/load/arm_load.hpp"

namespace glenoid::load {

/// Which drives carry which arm: what `glenoid-drives --load` reads.
struct LoadFile {
  ArmLoadSettings settings;
  std::array<std::uint8_t, 6> nodes{};  ///< of the joints, in the order of ExoJoint
};

/// Reads a file as `glenoid rehearse` leaves it (load.yaml; docs/drives.md has the keys).
/// @throws std::invalid_argument naming file, key, value and rule
LoadFile read_load_file(const std::filesystem::path& file);

/// The load for drives at these nodes. @throws std::invalid_argument  other nodes, or another order, than the file's
std::unique_ptr<ArmLoad> make_load(const LoadFile& file, const std::vector<std::uint8_t>& nodes);

}  // namespace glenoid::load
