#pragma once

#include <string>
#include <string_view>

namespace glenoid::bridge {

/// SHA-256 (FIPS 180-4) in hexadecimal.
[[nodiscard]] std::string sha256(std::string_view text);

}  // namespace glenoid::bridge
