#pragma once

#include "host/bridge/core/messages.hpp"

namespace glenoid::bridge {

/// Words for people; never null.
[[nodiscard]] const char* words(State state) noexcept;
[[nodiscard]] const char* words(Request request) noexcept;
[[nodiscard]] const char* words(Rejection rejection) noexcept;
[[nodiscard]] const char* words(Fault fault) noexcept;
[[nodiscard]] const char* words(BusState state) noexcept;

}  // namespace glenoid::bridge
