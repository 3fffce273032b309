#pragma once

#include <algorithm>
#include <span>

#include "host/bridge/can/frame.hpp"
#include "host/bridge/can/open_port.hpp"

namespace glenoid::can {

/// Whether a frame passes a list of filters as the kernel would judge it.
[[nodiscard]] inline bool passes(std::span<const Filter> filters, const Frame& frame) noexcept {
  if (frame.error || filters.empty()) return true;
  if (frame.extended || frame.remote) return false;
  return std::any_of(filters.begin(), filters.end(),
                     [&](const Filter& filter) { return ((frame.id ^ filter.id) & filter.mask) == 0; });
}

}  // namespace glenoid::can
