#pragma once

#include <cstddef>
#include <memory>

#include "outcome.hpp"

namespace glenoid::fmu {

/// Where finished messages go: the importer's logger behind one of the two APIs.
class LogSink {
 public:
  virtual ~LogSink() = default;
  virtual void write(Outcome outcome, const char* category, const char* message) const = 0;
};

/// Log of one instance. Writes nothing while it is off, and never to the console.
class Log {
 public:
  Log(std::unique_ptr<LogSink> sink, bool on) : sink_(std::move(sink)), on_(on) {}

  /// Switches the log; with categories given only these are written.
  /// @return Warning if a name is not one of the LogCategories (the others are taken).
  Outcome select(bool on, std::size_t count, const char* const categories[]) noexcept;

  /// Ok is an event; the other outcomes have a category each.
  void write(Outcome outcome, const char* message) const;
  [[nodiscard]] bool on() const noexcept { return on_; }

 private:
  std::unique_ptr<LogSink> sink_;
  bool on_ = false;
  unsigned selected_ = ~0U;  ///< one bit for each outcome
};

}  // namespace glenoid::fmu
