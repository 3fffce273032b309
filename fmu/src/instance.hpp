#pragma once

#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "call_rules.hpp"
#include "glenoid/motion.hpp"
#include "log.hpp"
#include "outcome.hpp"
#include "snapshot.hpp"
#include "text.hpp"
#include "variables.hpp"

namespace glenoid::fmu {

/// One co-simulation instance of either standard: values, time and a MotionGenerator, which holds all the mathematics.
///
/// Parameters are settings under construction until initialization ends; then the generator is built from them. Not
/// thread-safe in itself; instances share nothing. Functions are called through guard(), which checks the call rules.
class Instance {
 public:
  /// Read of variables that the importer names; `values` counts only if Ok.
  template <class Number>
  Outcome get(const char* function, bool (*fits)(Kind), const std::uint32_t* references, std::size_t count,
              Number* values);
  /// All or nothing: with one bad value no value is taken.
  template <class Number>
  Outcome set(const char* function, bool (*fits)(Kind), const std::uint32_t* references, std::size_t count,
              const Number* values);

  Instance(std::unique_ptr<LogSink> sink, bool logging) : log_(std::move(sink), logging) {}

  /// Start and stop time of the run, s. @return Discard if they are not finite or not in order.
  Outcome set_up(const char* function, double start_time_s, bool stop_defined, double stop_time_s);
  Outcome enter_initialization();
  /// Builds the generator. @return Error with one message for each problem of the parameters.
  Outcome exit_initialization(const char* function);
  Outcome terminate() noexcept;
  Outcome reset() noexcept;

  /// Takes the inputs at time_s and moves to time_s + step_s. No heap. @return Discard for a step that cannot be done,
  /// Error beyond the stop time.
  Outcome do_step(const char* function, double time_s, double step_s);
  Outcome output_derivatives(const char* function, const std::uint32_t* references, std::size_t count,
                             const int* orders, double* values);

  void save(Snapshot& out) const noexcept;
  Outcome restore(const char* function, const Snapshot& snapshot);

  /// Logs and returns Discard: the instance is as it was.
  Outcome refuse(const char* function, const char* message) const;
  /// Logs, ends the instance until reset, returns Error.
  Outcome fail(const char* function, const char* message);

  [[nodiscard]] Phase phase() const noexcept { return state_.phase; }
  [[nodiscard]] double time_s() const noexcept { return state_.time_s; }
  Log& log() noexcept { return log_; }

 private:
  Outcome read(const char* function, bool (*fits)(Kind), std::uint32_t reference, double& value);
  Outcome check(const char* function, bool (*fits)(Kind), std::uint32_t reference, double value);
  void assign(std::uint32_t reference, double value);
  /// Builds the generator from the values if they changed. @return the problems, one a line; "" if there are none.
  std::string build();
  void sample_at(double time_s) noexcept;
  void report_command(const char* function, double time_s) const;
  void log_lines(Outcome outcome, const char* function, const std::string& lines) const;

  Log log_;
  Snapshot state_{};  ///< without `motion`, which lives in the generator
  std::optional<MotionGenerator> generator_;
  Values built_from_{};  ///< values of which generator_ was built
  double built_start_s_ = 0.0;
  bool outputs_fresh_ = false;  ///< the outputs in state_.values belong to the parameters and the time
  MotionSample sample_;
};

template <class Number>
Outcome Instance::get(const char* function, bool (*fits)(Kind), const std::uint32_t* references, std::size_t count,
                      Number* values) {
  if (count > 0 && (references == nullptr || values == nullptr)) return refuse(function, "null pointer");
  for (std::size_t i = 0; i < count; ++i) {
    double value = 0.0;
    if (const Outcome outcome = read(function, fits, references[i], value); outcome != Outcome::Ok) return outcome;
    values[i] = static_cast<Number>(value);
  }
  return Outcome::Ok;
}

template <class Number>
Outcome Instance::set(const char* function, bool (*fits)(Kind), const std::uint32_t* references, std::size_t count,
                      const Number* values) {
  if (count > 0 && (references == nullptr || values == nullptr)) return refuse(function, "null pointer");
  for (std::size_t i = 0; i < count; ++i) {
    const Outcome outcome = check(function, fits, references[i], static_cast<double>(values[i]));
    if (outcome != Outcome::Ok) return outcome;
  }
  for (std::size_t i = 0; i < count; ++i) assign(references[i], static_cast<double>(values[i]));
  return Outcome::Ok;
}

/// Runs the body of an API function: call rules before it, no exception out of it.
template <class Body>
Outcome guard(void* handle, const char* function, Call call, Body&& body) noexcept {
  if (handle == nullptr) return Outcome::Error;
  Instance& instance = *static_cast<Instance*>(handle);
  try {
    if (!allowed(call, instance.phase())) {
      Text text;
      if (call == Call::Unsupported)
        text << "this FMU does not offer it (see its modelDescription.xml)";
      else
        text << "not allowed in state " << to_string(instance.phase());
      return instance.fail(function, text.c_str());
    }
    return std::forward<Body>(body)(instance);
  } catch (const std::exception& problem) {
    return instance.fail(function, problem.what());
  } catch (...) {
    return instance.fail(function, "unknown exception");
  }
}

}  // namespace glenoid::fmu
