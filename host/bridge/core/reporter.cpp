#include "host/bridge/core/reporter.hpp"

#include <cstdarg>
#include <cstdio>

namespace glenoid::bridge {

void Reporter::report(Severity severity, std::int32_t code, const Subject& subject, double value, double limit,
                      const char* format, ...) noexcept {
  ++sequence_;
  if (outputs_ == nullptr || outputs_->events.full()) return;  // a gap in the sequence tells
  Event event;
  event.time_ns = time_ns_;
  event.sequence = sequence_;
  event.severity = severity;
  event.code = code;
  event.bus = subject.bus;
  event.node = subject.node;
  event.joint = subject.joint;
  event.value = value;
  event.limit = limit;
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(event.text.data(), event.text.size(), format, arguments);
  va_end(arguments);
  outputs_->events.push(event);
}

}  // namespace glenoid::bridge
