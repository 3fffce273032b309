// The 75 functions of FMI 3.0; this FMU offers co-simulation without event mode, clocks, arrays. Conversions of arguments,
// no logic.
#include <memory>

#include "fmi3/fmi3Functions.h"
#include "instance.hpp"
#include "lifetime.hpp"

namespace {

using glenoid::fmu::Call;
using glenoid::fmu::guard;
using glenoid::fmu::Instance;
using glenoid::fmu::Kind;
using glenoid::fmu::LogSink;
using glenoid::fmu::Outcome;

using References = const fmi3ValueReference*;

fmi3Status to_fmi3(Outcome outcome) noexcept { return static_cast<fmi3Status>(outcome); }

bool is_float64(Kind kind) noexcept { return kind == Kind::Real; }
bool is_enumeration(Kind kind) noexcept { return kind == Kind::Enumeration; }
bool is_boolean(Kind kind) noexcept { return kind == Kind::Boolean; }
bool is_absent(Kind) noexcept { return false; }

class Fmi3Log final : public LogSink {
 public:
  Fmi3Log(fmi3LogMessageCallback logger, fmi3InstanceEnvironment environment)
      : logger_(logger), environment_(environment) {}

  void write(Outcome outcome, const char* category, const char* message) const override {
    if (logger_ != nullptr) logger_(environment_, to_fmi3(outcome), category, message);
  }

 private:
  fmi3LogMessageCallback logger_;
  fmi3InstanceEnvironment environment_;
};

template <class Body>
fmi3Status call(fmi3Instance instance, const char* function, Call rule, Body&& body) noexcept {
  return to_fmi3(guard(instance, function, rule, std::forward<Body>(body)));
}

template <class Number>
fmi3Status get(fmi3Instance instance, const char* function, bool (*fits)(Kind), References references, size_t count,
               Number values[], size_t value_count) noexcept {
  return call(instance, function, Call::Get, [&](Instance& i) {
    if (value_count != count)
      return i.refuse(function, "nValues must equal nValueReferences: all variables are scalars");
    return i.get(function, fits, references, count, values);
  });
}

template <class Number>
fmi3Status set(fmi3Instance instance, const char* function, bool (*fits)(Kind), References references, size_t count,
               const Number values[], size_t value_count) noexcept {
  return call(instance, function, Call::Set, [&](Instance& i) {
    if (value_count != count)
      return i.refuse(function, "nValues must equal nValueReferences: all variables are scalars");
    return i.set(function, fits, references, count, values);
  });
}

fmi3Status unsupported(fmi3Instance instance, const char* function) noexcept {
  return call(instance, function, Call::Unsupported, [](Instance&) { return Outcome::Error; });
}

/// Model Exchange and Scheduled Execution.
fmi3Instance no_instance(const char* function, fmi3String token, bool logging, fmi3InstanceEnvironment environment,
                         fmi3LogMessageCallback logger) noexcept {
  return glenoid::fmu::instantiate(function, token, false, logging,
                                   [&] { return std::make_unique<Fmi3Log>(logger, environment); });
}

template <class Value>
void answer(Value* out, Value value) noexcept {
  if (out != nullptr) *out = value;
}

}  // namespace

extern "C" {

const char* fmi3GetVersion() { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t count, const fmi3String categories[]) {
  return call(instance, __func__, Call::SetDebugLogging,
              [&](Instance& i) { return i.log().select(on, count, categories); });
}

// Creation, life cycle

fmi3Instance fmi3InstantiateModelExchange(fmi3String, fmi3String token, fmi3String, fmi3Boolean, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger) {
  return no_instance(__func__, token, logging, environment, logger);
}
fmi3Instance fmi3InstantiateCoSimulation(fmi3String, fmi3String token, fmi3String, fmi3Boolean, fmi3Boolean logging,
                                         fmi3Boolean, fmi3Boolean, const fmi3ValueReference[], size_t,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback) {
  return glenoid::fmu::instantiate(__func__, token, true, logging,
                                   [&] { return std::make_unique<Fmi3Log>(logger, environment); });
}
fmi3Instance fmi3InstantiateScheduledExecution(fmi3String, fmi3String token, fmi3String, fmi3Boolean,
                                               fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback logger, fmi3ClockUpdateCallback,
                                               fmi3LockPreemptionCallback, fmi3UnlockPreemptionCallback) {
  return no_instance(__func__, token, logging, environment, logger);
}

void fmi3FreeInstance(fmi3Instance instance) { delete static_cast<Instance*>(instance); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean, fmi3Float64, fmi3Float64 start,
                                       fmi3Boolean stop_defined, fmi3Float64 stop) {
  return call(instance, __func__, Call::EnterInitialization, [&, f = __func__](Instance& i) {
    const Outcome outcome = i.set_up(f, start, stop_defined, stop);
    return outcome == Outcome::Ok ? i.enter_initialization() : outcome;
  });
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
  return call(instance, __func__, Call::ExitInitialization,
              [f = __func__](Instance& i) { return i.exit_initialization(f); });
}
fmi3Status fmi3Terminate(fmi3Instance instance) {
  return call(instance, __func__, Call::Terminate, [](Instance& i) { return i.terminate(); });
}
fmi3Status fmi3Reset(fmi3Instance instance) {
  return call(instance, __func__, Call::Reset, [](Instance& i) { return i.reset(); });
}

// Values. An enumeration is an Int64; Int32 is taken too, as some importers use it.

fmi3Status fmi3GetFloat32(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          fmi3Float32 values[], size_t value_count) {
  return get(instance, __func__, is_absent, references, count, values, value_count);
}
fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          fmi3Float64 values[], size_t value_count) {
  return get(instance, __func__, is_float64, references, count, values, value_count);
}
fmi3Status fmi3GetInt8(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Int8 values[],
                       size_t value_count) {
  return get(instance, __func__, is_absent, references, count, values, value_count);
}
fmi3Status fmi3GetUInt8(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3UInt8 values[],
                        size_t value_count) {
  return get(instance, __func__, is_absent, references, count, values, value_count);
}
fmi3Status fmi3GetInt16(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Int16 values[],
                        size_t value_count) {
  return get(instance, __func__, is_absent, references, count, values, value_count);
}
fmi3Status fmi3GetUInt16(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                         fmi3UInt16 values[], size_t value_count) {
  return get(instance, __func__, is_absent, references, count, values, value_count);
}
fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Int32 values[],
                        size_t value_count) {
  return get(instance, __func__, is_enumeration, references, count, values, value_count);
}
fmi3Status fmi3GetUInt32(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                         fmi3UInt32 values[], size_t value_count) {
  return get(instance, __func__, is_absent, references, count, values, value_count);
}
fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Int64 values[],
                        size_t value_count) {
  return get(instance, __func__, is_enumeration, references, count, values, value_count);
}
fmi3Status fmi3GetUInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                         fmi3UInt64 values[], size_t value_count) {
  return get(instance, __func__, is_absent, references, count, values, value_count);
}
fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          fmi3Boolean values[], size_t value_count) {
  return get(instance, __func__, is_boolean, references, count, values, value_count);
}
fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3String[],
                         size_t) {
  return get(instance, __func__, is_absent, references, count, &count, count);
}
fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference references[], size_t count, size_t[],
                         fmi3Binary[], size_t) {
  return get(instance, __func__, is_absent, references, count, &count, count);
}
fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Clock[]) {
  return get(instance, __func__, is_absent, references, count, &count, count);
}

fmi3Status fmi3SetFloat32(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          const fmi3Float32 values[], size_t value_count) {
  return set(instance, __func__, is_absent, references, count, values, value_count);
}
fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          const fmi3Float64 values[], size_t value_count) {
  return set(instance, __func__, is_float64, references, count, values, value_count);
}
fmi3Status fmi3SetInt8(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                       const fmi3Int8 values[], size_t value_count) {
  return set(instance, __func__, is_absent, references, count, values, value_count);
}
fmi3Status fmi3SetUInt8(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                        const fmi3UInt8 values[], size_t value_count) {
  return set(instance, __func__, is_absent, references, count, values, value_count);
}
fmi3Status fmi3SetInt16(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                        const fmi3Int16 values[], size_t value_count) {
  return set(instance, __func__, is_absent, references, count, values, value_count);
}
fmi3Status fmi3SetUInt16(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                         const fmi3UInt16 values[], size_t value_count) {
  return set(instance, __func__, is_absent, references, count, values, value_count);
}
fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                        const fmi3Int32 values[], size_t value_count) {
  return set(instance, __func__, is_enumeration, references, count, values, value_count);
}
fmi3Status fmi3SetUInt32(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                         const fmi3UInt32 values[], size_t value_count) {
  return set(instance, __func__, is_absent, references, count, values, value_count);
}
fmi3Status fmi3SetInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                        const fmi3Int64 values[], size_t value_count) {
  return set(instance, __func__, is_enumeration, references, count, values, value_count);
}
fmi3Status fmi3SetUInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                         const fmi3UInt64 values[], size_t value_count) {
  return set(instance, __func__, is_absent, references, count, values, value_count);
}
fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          const fmi3Boolean values[], size_t value_count) {
  return set(instance, __func__, is_boolean, references, count, values, value_count);
}
fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3String[],
                         size_t) {
  return set(instance, __func__, is_absent, references, count, &count, count);
}
fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const size_t[],
                         const fmi3Binary[], size_t) {
  return set(instance, __func__, is_absent, references, count, &count, count);
}
fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Clock[]) {
  return set(instance, __func__, is_absent, references, count, &count, count);
}

// State

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState* state) {
  return call(instance, __func__, Call::State,
              [&, f = __func__](Instance& i) { return glenoid::fmu::get_state(i, f, state); });
}
fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
  return call(instance, __func__, Call::State,
              [&, f = __func__](Instance& i) { return glenoid::fmu::set_state(i, f, state); });
}
fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState* state) {
  return call(instance, __func__, Call::State, [&](Instance&) { return glenoid::fmu::free_state(state); });
}
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t* size) {
  return call(instance, __func__, Call::State,
              [&, f = __func__](Instance& i) { return glenoid::fmu::state_size(i, f, state, size); });
}
fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
  return call(instance, __func__, Call::State,
              [&, f = __func__](Instance& i) { return glenoid::fmu::write_state(i, f, state, bytes, size); });
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState* state) {
  return call(instance, __func__, Call::State,
              [&, f = __func__](Instance& i) { return glenoid::fmu::read_state(i, f, bytes, size, state); });
}

// Co-simulation

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                                    const fmi3Int32 orders[], fmi3Float64 values[], size_t value_count) {
  return call(instance, __func__, Call::OutputDerivatives, [&, f = __func__](Instance& i) {
    if (value_count != count) return i.refuse(f, "nValues must equal nValueReferences: all variables are scalars");
    return i.output_derivatives(f, references, count, orders, values);
  });
}
fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step, fmi3Boolean, fmi3Boolean* event_needed,
                      fmi3Boolean* terminate, fmi3Boolean* early_return, fmi3Float64* last_time) {
  answer(event_needed, false);
  answer(terminate, false);
  answer(early_return, false);
  return call(instance, __func__, Call::DoStep, [&, f = __func__](Instance& i) {
    const Outcome outcome = i.do_step(f, time, step);
    answer(last_time, i.time_s());
    return outcome;
  });
}

// Offered by other kinds of FMU only

fmi3Status fmi3EnterEventMode(fmi3Instance instance) { return unsupported(instance, __func__); }
fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference, size_t*) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference, size_t[], fmi3ValueReference[],
                                       size_t[], fmi3DependencyKind[], size_t) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference[], size_t,
                                        const fmi3ValueReference[], size_t, const fmi3Float64[], size_t, fmi3Float64[],
                                        size_t) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference[], size_t,
                                    const fmi3ValueReference[], size_t, const fmi3Float64[], size_t, fmi3Float64[],
                                    size_t) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance) { return unsupported(instance, __func__); }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance) { return unsupported(instance, __func__); }
fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference[], size_t, fmi3Float64[],
                                  fmi3IntervalQualifier[]) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference[], size_t, fmi3UInt64[],
                                   fmi3UInt64[], fmi3IntervalQualifier[]) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference[], size_t, fmi3Float64[]) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference[], size_t, fmi3UInt64[], fmi3UInt64[]) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference[], size_t, const fmi3Float64[]) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3SetIntervalFraction(fmi3Instance instance, const fmi3ValueReference[], size_t, const fmi3UInt64[],
                                   const fmi3UInt64[]) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference[], size_t, const fmi3Float64[]) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference[], size_t, const fmi3UInt64[],
                                const fmi3UInt64[]) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) { return unsupported(instance, __func__); }
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean*, fmi3Boolean*, fmi3Boolean*, fmi3Boolean*,
                                    fmi3Boolean*, fmi3Float64*) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) { return unsupported(instance, __func__); }
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean, fmi3Boolean*, fmi3Boolean*) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64) { return unsupported(instance, __func__); }
fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64[], size_t) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64[], size_t) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64[], size_t) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64[], size_t) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64[], size_t) {
  return unsupported(instance, __func__);
}
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t*) { return unsupported(instance, __func__); }
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t*) { return unsupported(instance, __func__); }
fmi3Status fmi3EnterStepMode(fmi3Instance instance) { return unsupported(instance, __func__); }
fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference, fmi3Float64) {
  return unsupported(instance, __func__);
}

}  // extern "C"
