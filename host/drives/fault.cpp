#include "host/drives/fault.hpp"

#include <array>

namespace glenoid::drives {
namespace {

constexpr std::array<std::string_view, kFaultKinds> kNames = {"none",   "drop",          "delay",   "stall", "emcy",
                                                              "reboot", "stuck-encoder", "bus-off", "jam"};

}  // namespace

std::string_view name(FaultKind kind) noexcept { return kNames[static_cast<std::size_t>(kind)]; }

std::optional<FaultKind> fault_kind(std::string_view word) noexcept {
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    if (kNames[k] == word) return static_cast<FaultKind>(k);
  }
  return std::nullopt;
}

}  // namespace glenoid::drives
