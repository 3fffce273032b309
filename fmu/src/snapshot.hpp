#pragma once

#include <cstddef>
#include <cstdint>

#include "call_rules.hpp"
#include "glenoid/motion.hpp"
#include "variables.hpp"

namespace glenoid::fmu {

/// Everything of an instance that a later call can depend on: the FMU state of both standards. Copying it is saving it.
struct Snapshot {
  Phase phase = Phase::Instantiated;
  bool stop_defined = false;
  bool has_motion = false;  ///< a generator exists; `motion` is its state
  bool inputs_changed = false;
  double start_time_s = 0.0;
  double stop_time_s = 0.0;
  double time_s = 0.0;  ///< end of the last step
  Values values = start_values();
  MotionState motion;
};

/// Portable bytes of a snapshot: magic, format, length, checksum, then the fields in little-endian order. The same
/// snapshot gives the same bytes.
std::size_t serialized_size(const Snapshot& snapshot) noexcept;
/// @pre size >= serialized_size(snapshot)
void serialize(const Snapshot& snapshot, unsigned char* bytes) noexcept;
/// @return nullptr, or why the bytes are not a state of this FMU; then `out` is unspecified.
const char* deserialize(const unsigned char* bytes, std::size_t size, Snapshot& out) noexcept;

}  // namespace glenoid::fmu
