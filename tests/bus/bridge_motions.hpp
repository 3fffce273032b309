#pragma once

#include <cmath>

#include "bridge_rig.hpp"

namespace glenoid::bridge::test {

/// Every joint swings by 0.15 rad about where the rig's drives stand, 2 rad/s: at most 0.3 rad/s and 0.6 rad/s^2.
inline Sample swing(double t) {
  Sample sample;
  constexpr double kAmplitude = 0.15, kRate = 2.0;
  for (std::size_t j = 0; j < kMaxJoints; ++j) {
    sample.position_rad[j] = 0.3 + kAmplitude * std::sin(kRate * t);
    sample.velocity_rad_per_s[j] = kAmplitude * kRate * std::cos(kRate * t);
  }
  return sample;
}

/// What the fault tests show: how long the drives waited for the quick stop and where the command was.
inline void show_reaction(const char* fault, const Rig& rig, std::int64_t since_ns) {
  for (const Wire& entry : rig.wire) {
    if (entry.time_ns < since_ns || !entry.from_bridge || entry.frame.id != 0x201) continue;
    if ((entry.frame.data[0] & 0x0F) == 0x0F) continue;
    std::printf("[ reaction ] %-22s %6.1f ms, last command %.4f rad\n", fault,
                1e-6 * static_cast<double>(entry.time_ns - since_ns), rig.bridge.command_rad()[0]);
    return;
  }
  std::printf("[ reaction ] %-22s no further command, last %.4f rad\n", fault, rig.bridge.command_rad()[0]);
}

}  // namespace glenoid::bridge::test
