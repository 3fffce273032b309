#pragma once

#include <cstdint>

#include "host/bridge/core/bridge.hpp"
#include "host/bridge/core/messages.hpp"

namespace glenoid::bridge {

/// What an event is about.
struct Subject {
  std::int32_t bus = -1;
  std::int32_t node = 0;
  std::int32_t joint = -1;
};

/// Writes events into the outputs of the call under way. Lost ones leave a gap in the sequence.
class Reporter {
 public:
  void begin(std::int64_t time_ns, Outputs& outputs) noexcept {
    time_ns_ = time_ns;
    outputs_ = &outputs;
  }

  /// `value` is what was met, `limit` the rule it broke; the rest as printf.
  [[gnu::format(printf, 7, 8)]] void report(Severity severity, std::int32_t code, const Subject& subject, double value,
                                            double limit, const char* format, ...) noexcept;

 private:
  std::int64_t time_ns_ = 0;
  std::int64_t sequence_ = 0;
  Outputs* outputs_ = nullptr;
};

}  // namespace glenoid::bridge
