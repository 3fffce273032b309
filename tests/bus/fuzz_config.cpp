// YAML that anybody wrote: refused in words or read, nothing else.

#include <cstdint>
#include <string>

#include "host/bridge/config/config.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  try {
    static_cast<void>(glenoid::bridge::parse_config(std::string(reinterpret_cast<const char*>(bytes), size)));
  } catch (const glenoid::bridge::ConfigError&) {
  }
  return 0;
}
