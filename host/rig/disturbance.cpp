#include "host/rig/disturbance.hpp"

#include <array>

namespace glenoid::rig {
namespace {

constexpr std::array<std::string_view, kDisturbanceKinds> kNames = {
    "drive", "drive-heartbeat", "master-heartbeat", "estop", "estop-input", "bus-silent", "bus-stalled", "link-down"};

}  // namespace

std::string_view name(DisturbanceKind kind) noexcept { return kNames[static_cast<std::size_t>(kind)]; }

std::optional<DisturbanceKind> disturbance_kind(std::string_view word) noexcept {
  for (std::size_t k = 0; k < kNames.size(); ++k)
    if (kNames[k] == word) return static_cast<DisturbanceKind>(k);
  return std::nullopt;
}

}  // namespace glenoid::rig
