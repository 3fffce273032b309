// The 34 functions of FMI 2.0 for co-simulation: conversions of arguments, no logic. The ten of model exchange follow, since
// some importers look for all of them before they ask for the kind.
#include <cstring>
#include <memory>
#include <string>

#include "fmi2/fmi2Functions.h"
#include "instance.hpp"
#include "lifetime.hpp"

namespace {

using glenoid::fmu::Call;
using glenoid::fmu::guard;
using glenoid::fmu::Instance;
using glenoid::fmu::Kind;
using glenoid::fmu::Log;
using glenoid::fmu::LogSink;
using glenoid::fmu::Outcome;
using glenoid::fmu::Snapshot;

fmi2Status to_fmi2(Outcome outcome) noexcept { return static_cast<fmi2Status>(outcome); }

bool is_real(Kind kind) noexcept { return kind == Kind::Real; }
bool is_integer(Kind kind) noexcept { return kind == Kind::Enumeration; }
bool is_boolean(Kind kind) noexcept { return kind == Kind::Boolean; }
bool is_string(Kind) noexcept { return false; }

/// The logger takes a printf format, so the percent signs of the finished text are doubled.
class Fmi2Log final : public LogSink {
 public:
  Fmi2Log(const fmi2CallbackFunctions* functions, fmi2String name) : name_(name == nullptr ? "Glenoid" : name) {
    if (functions == nullptr) return;
    logger_ = functions->logger;
    environment_ = functions->componentEnvironment;
  }

  void write(Outcome outcome, const char* category, const char* message) const override {
    if (logger_ == nullptr) return;
    std::string format;
    for (; *message != '\0'; ++message) format.append(*message == '%' ? 2U : 1U, *message);
    logger_(environment_, name_.c_str(), to_fmi2(outcome), category, format.c_str());
  }

 private:
  std::string name_;
  fmi2CallbackLogger logger_ = nullptr;
  fmi2ComponentEnvironment environment_ = nullptr;
};

template <class Body>
fmi2Status call(fmi2Component c, const char* function, Call rule, Body&& body) noexcept {
  return to_fmi2(guard(c, function, rule, std::forward<Body>(body)));
}

template <class Number>
fmi2Status get(fmi2Component c, const char* function, bool (*fits)(Kind), const fmi2ValueReference vr[], size_t n,
               Number value[]) noexcept {
  return call(c, function, Call::Get, [&](Instance& i) { return i.get(function, fits, vr, n, value); });
}

template <class Number>
fmi2Status set(fmi2Component c, const char* function, bool (*fits)(Kind), const fmi2ValueReference vr[], size_t n,
               const Number value[]) noexcept {
  return call(c, function, Call::Set, [&](Instance& i) { return i.set(function, fits, vr, n, value); });
}

fmi2Status unsupported(fmi2Component c, const char* function) noexcept {
  return call(c, function, Call::Unsupported, [](Instance&) { return Outcome::Error; });
}

/// Status that only asynchronous steps have.
fmi2Status no_status(fmi2Component c, const char* function) noexcept {
  return call(c, function, Call::StepStatus,
              [&](Instance& i) { return i.refuse(function, "doStep is synchronous: there is no such status"); });
}

}  // namespace

extern "C" {

const char* fmi2GetTypesPlatform() { return fmi2TypesPlatform; }
const char* fmi2GetVersion() { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
  return call(c, __func__, Call::SetDebugLogging,
              [&](Instance& i) { return i.log().select(on != fmi2False, n, categories); });
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String,
                              const fmi2CallbackFunctions* functions, fmi2Boolean, fmi2Boolean logging) {
  return glenoid::fmu::instantiate(__func__, guid, type == fmi2CoSimulation, logging != fmi2False,
                                   [&] { return std::make_unique<Fmi2Log>(functions, name); });
}

void fmi2FreeInstance(fmi2Component c) { delete static_cast<Instance*>(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean, fmi2Real, fmi2Real start, fmi2Boolean stop_defined,
                               fmi2Real stop) {
  return call(c, __func__, Call::SetUp,
              [&, f = __func__](Instance& i) { return i.set_up(f, start, stop_defined != fmi2False, stop); });
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  return call(c, __func__, Call::EnterInitialization, [](Instance& i) { return i.enter_initialization(); });
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  return call(c, __func__, Call::ExitInitialization, [f = __func__](Instance& i) { return i.exit_initialization(f); });
}
fmi2Status fmi2Terminate(fmi2Component c) {
  return call(c, __func__, Call::Terminate, [](Instance& i) { return i.terminate(); });
}
fmi2Status fmi2Reset(fmi2Component c) {
  return call(c, __func__, Call::Reset, [](Instance& i) { return i.reset(); });
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
  return get(c, __func__, is_real, vr, n, value);
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
  return get(c, __func__, is_integer, vr, n, value);
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
  return get(c, __func__, is_boolean, vr, n, value);
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String[]) {
  return get(c, __func__, is_string, vr, n, &n);
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
  return set(c, __func__, is_real, vr, n, value);
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
  return set(c, __func__, is_integer, vr, n, value);
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
  return set(c, __func__, is_boolean, vr, n, value);
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String[]) {
  return set(c, __func__, is_string, vr, n, &n);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
  return call(c, __func__, Call::State, [&, f = __func__](Instance& i) { return glenoid::fmu::get_state(i, f, state); });
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
  return call(c, __func__, Call::State, [&, f = __func__](Instance& i) { return glenoid::fmu::set_state(i, f, state); });
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
  return call(c, __func__, Call::State, [&](Instance&) { return glenoid::fmu::free_state(state); });
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
  return call(c, __func__, Call::State,
              [&, f = __func__](Instance& i) { return glenoid::fmu::state_size(i, f, state, size); });
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
  return call(c, __func__, Call::State, [&, f = __func__](Instance& i) {
    return glenoid::fmu::write_state(i, f, state, reinterpret_cast<unsigned char*>(bytes), size);
  });
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate* state) {
  return call(c, __func__, Call::State, [&, f = __func__](Instance& i) {
    return glenoid::fmu::read_state(i, f, reinterpret_cast<const unsigned char*>(bytes), size, state);
  });
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference[], size_t, const fmi2ValueReference[],
                                        size_t, const fmi2Real[], fmi2Real[]) {
  return unsupported(c, __func__);
}
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference[], size_t, const fmi2Integer[],
                                       const fmi2Real[]) {
  return unsupported(c, __func__);
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[]) {
  return call(c, __func__, Call::OutputDerivatives,
              [&, f = __func__](Instance& i) { return i.output_derivatives(f, vr, n, order, value); });
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean) {
  return call(c, __func__, Call::DoStep, [&, f = __func__](Instance& i) { return i.do_step(f, time, step); });
}
fmi2Status fmi2CancelStep(fmi2Component c) { return unsupported(c, __func__); }

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind, fmi2Status*) { return no_status(c, __func__); }
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real* value) {
  if (kind != fmi2LastSuccessfulTime || value == nullptr) return no_status(c, __func__);
  return call(c, __func__, Call::StepStatus, [&](Instance& i) {
    *value = i.time_s();
    return Outcome::Ok;
  });
}
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind, fmi2Integer*) { return no_status(c, __func__); }
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean* value) {
  if (kind != fmi2Terminated || value == nullptr) return no_status(c, __func__);
  return call(c, __func__, Call::StepStatus, [&](Instance&) {
    *value = fmi2False;  // this FMU never asks to end the simulation
    return Outcome::Ok;
  });
}
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind, fmi2String*) { return no_status(c, __func__); }

// Model exchange

fmi2Status fmi2EnterEventMode(fmi2Component c) { return unsupported(c, __func__); }
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo*) { return unsupported(c, __func__); }
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { return unsupported(c, __func__); }
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean, fmi2Boolean*, fmi2Boolean*) {
  return unsupported(c, __func__);
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real) { return unsupported(c, __func__); }
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real[], size_t) { return unsupported(c, __func__); }
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real[], size_t) { return unsupported(c, __func__); }
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real[], size_t) { return unsupported(c, __func__); }
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real[], size_t) { return unsupported(c, __func__); }
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real[], size_t) { return unsupported(c, __func__); }

}  // extern "C"
