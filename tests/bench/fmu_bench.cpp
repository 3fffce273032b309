// Cost of the FMU through dlopen, as an importer meets it: a step without a new target, a step with one, instantiation to
// the first output. The library is GLENOID_FMU_LIBRARY (default: the host compiler's), FMI 3.0.
#include <benchmark/benchmark.h>
#include <dlfcn.h>

#include <array>
#include <cstdio>
#include <cstdlib>

#include "fmi3/fmi3FunctionTypes.h"
#include "fmi3/fmi3PlatformTypes.h"
#include "variables.hpp"

namespace {

constexpr double kStep = 0.002;
constexpr std::array<fmi3ValueReference, 3> kTarget = {300, 301, 302};
constexpr std::array<fmi3ValueReference, 4> kQ = {400, 401, 402, 403};

/// The functions of the library that are used here.
struct Library {
  void* handle;
  fmi3InstantiateCoSimulationTYPE* instantiate;
  fmi3EnterInitializationModeTYPE* enter;
  fmi3ExitInitializationModeTYPE* exit;
  fmi3SetFloat64TYPE* set;
  fmi3GetFloat64TYPE* get;
  fmi3DoStepTYPE* step;
  fmi3FreeInstanceTYPE* free;

  template <class Function>
  void find(Function*& function, const char* name) const {
    function = reinterpret_cast<Function*>(dlsym(handle, name));
    if (function == nullptr) fail();
  }

  [[noreturn]] static void fail() {
    std::fprintf(stderr, "%s\n", dlerror());
    std::exit(2);
  }

  Library() : handle(nullptr) {
    const char* path = std::getenv("GLENOID_FMU_LIBRARY");
    handle = dlopen(path != nullptr ? path : GLENOID_FMU_DEFAULT_LIBRARY, RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) fail();
    find(instantiate, "fmi3InstantiateCoSimulation");
    find(enter, "fmi3EnterInitializationMode");
    find(exit, "fmi3ExitInitializationMode");
    find(set, "fmi3SetFloat64");
    find(get, "fmi3GetFloat64");
    find(step, "fmi3DoStep");
    find(free, "fmi3FreeInstance");
  }
};

const Library& library() {
  static const Library instance;
  return instance;
}

/// An initialized instance at time 0.
fmi3Instance start() {
  fmi3Instance instance = library().instantiate("bench", glenoid::fmu::kInstantiationToken, nullptr, false, false,
                                                false, false, nullptr, 0, nullptr, nullptr, nullptr);
  if (instance == nullptr || library().enter(instance, false, 0.0, 0.0, false, 0.0) != fmi3OK ||
      library().exit(instance) != fmi3OK) {
    std::fprintf(stderr, "the FMU does not initialize\n");
    std::exit(2);
  }
  return instance;
}

void do_step(fmi3Instance instance, double time) {
  fmi3Boolean event = false, terminate = false, early = false;
  fmi3Float64 last = 0.0;
  benchmark::DoNotOptimize(library().step(instance, time, kStep, true, &event, &terminate, &early, &last));
}

void set_target(fmi3Instance instance, const std::array<double, 3>& target) {
  benchmark::DoNotOptimize(library().set(instance, kTarget.data(), kTarget.size(), target.data(), target.size()));
}

/// In the middle of a movement that lasts as long as the benchmark.
void step_without_new_target(benchmark::State& state) {
  fmi3Instance instance = start();
  constexpr fmi3ValueReference kDuration = 140;
  constexpr double kLong = 60.0;
  (void)library().set(instance, &kDuration, 1, &kLong, 1);
  long k = 0;
  for (auto _ : state) {
    if (k == 25000) {  // 50 s: back to the start, not counted
      state.PauseTiming();
      library().free(instance);
      instance = start();
      (void)library().set(instance, &kDuration, 1, &kLong, 1);
      k = 0;
      state.ResumeTiming();
    }
    do_step(instance, static_cast<double>(k++) * kStep);
  }
  library().free(instance);
}
BENCHMARK(step_without_new_target);

/// Re-planning in motion: the target moves by centimetres at every step.
void step_with_new_target(benchmark::State& state) {
  fmi3Instance instance = start();
  long k = 0;
  for (auto _ : state) {
    const double shift = 0.01 * static_cast<double>(k % 7);
    set_target(instance, {0.20 - shift, 0.42, 0.25 - shift});
    do_step(instance, static_cast<double>(k++) * kStep);
  }
  library().free(instance);
}
BENCHMARK(step_with_new_target)->Unit(benchmark::kMicrosecond);

/// A new instance until its first step is done and read.
void instantiate_to_first_output(benchmark::State& state) {
  for (auto _ : state) {
    fmi3Instance instance = start();
    do_step(instance, 0.0);
    std::array<double, 4> q{};
    (void)library().get(instance, kQ.data(), kQ.size(), q.data(), q.size());
    benchmark::DoNotOptimize(q);
    library().free(instance);
  }
}
BENCHMARK(instantiate_to_first_output)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
