#include "host/bridge/lcm/gate.hpp"

namespace glenoid::lcm_port {

std::string_view words_of(Decoded result) noexcept {
  switch (result) {
    case Decoded::Ok:
      return "ok";
    case Decoded::Size:
      return "not the length of the type";
    case Decoded::Type:
      return "another type, or another version of it";
    case Decoded::Value:
      return "a value that the type cannot have";
  }
  return "unknown";
}

}  // namespace glenoid::lcm_port
