#pragma once

// The process data for other tools, written from the table that the codec reads.

#include <cstdint>
#include <span>
#include <string>

namespace glenoid::bridge {

/// Signals of every frame that travels each cycle, for cantools, SavvyCAN, Wireshark and the like (DBC).
/// @param nodes  CANopen node ids, 1..126
std::string dbc(std::span<const std::uint8_t> nodes, std::uint8_t master_id);

/// A drive as the bridge maps it: the process-data objects and their communication records (EDS, CiA 306).
std::string mapping_eds();

}  // namespace glenoid::bridge
