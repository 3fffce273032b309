// Costs of the core: one geodesic, the choice of the swivel angle, re-planning, sampling. One iteration is one call on the next task
// of a fixed set; `median_us` and `p99_us` are over calls, not over repetitions.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <string_view>
#include <vector>

#include "glenoid/motion.hpp"
#include "glenoid/swivel.hpp"
#include "tasks.hpp"

namespace {

using namespace glenoid;
using namespace glenoid::bench;
using Clock = std::chrono::steady_clock;

/// Times every call by itself and reports the median, the 99th percentile and the largest of them.
class CallTimes {
 public:
  explicit CallTimes(benchmark::State& state) : state_(state) { times_us_.reserve(1 << 20); }
  ~CallTimes() {
    if (times_us_.empty()) return;
    std::sort(times_us_.begin(), times_us_.end());
    const auto at = [this](double share) {
      return times_us_[static_cast<std::size_t>(share * static_cast<double>(times_us_.size() - 1))];
    };
    state_.counters["median_us"] = at(0.5);
    state_.counters["p99_us"] = at(0.99);
    state_.counters["max_us"] = at(1.0);
  }
  CallTimes(const CallTimes&) = delete;
  CallTimes& operator=(const CallTimes&) = delete;

  template <class Call>
  void measure(Call&& call) {
    const auto before = Clock::now();
    call();
    const double seconds = std::chrono::duration<double>(Clock::now() - before).count();
    state_.SetIterationTime(seconds);
    times_us_.push_back(1e6 * seconds);
  }

 private:
  benchmark::State& state_;
  std::vector<double> times_us_;
};

/// One geodesic between two postures, cold, to the default tolerance. Argument: Kind.
void geodesic(benchmark::State& state) {
  const ArmModel arm = default_arm();
  const std::vector<Pair> tasks = pairs(static_cast<Kind>(state.range(0)), 50);
  GeodesicSolver solver;
  GeodesicPath path;
  Certificate certificate;
  CallTimes times(state);
  std::size_t k = 0;
  long failures = 0;
  for (auto _ : state) {
    const Pair& task = tasks[k++ % tasks.size()];
    times.measure([&] {
      if (solver.solve(arm, task.start, task.end, {}, nullptr, path, certificate) != Status::Ok) ++failures;
    });
    benchmark::DoNotOptimize(path.energy);
  }
  state.counters["failures"] = static_cast<double>(failures);
}
BENCHMARK(geodesic)->ArgName("kind")->Arg(0)->Arg(1)->Arg(2)->UseManualTime()->Unit(benchmark::kMicrosecond);

/// The globally safe minimum-energy choice over 1000 fixed tasks.
void minimum_energy(benchmark::State& state) {
  const ArmModel arm = default_arm();
  const std::vector<Reach> tasks = reaches(arm, 1000);
  ReachPlanner planner;
  ReachPlan plan;
  CallTimes times(state);
  std::size_t k = 0;
  long failures = 0;
  for (auto _ : state) {
    const Reach& task = tasks[k++ % tasks.size()];
    times.measure([&] {
      if (planner.plan_minimum_energy(arm, task.start, task.target, plan) != Status::Ok) ++failures;
    });
    benchmark::DoNotOptimize(plan.path.energy);
  }
  state.counters["failures"] = static_cast<double>(failures);
}
BENCHMARK(minimum_energy)->Iterations(5000)->UseManualTime()->Unit(benchmark::kMicrosecond);

/// New plan from 30 % of an earlier path after the target has moved. Argument: distance in mm.
void replan(benchmark::State& state) {
  const ArmModel arm = default_arm();
  const std::vector<Reach> tasks = reaches(arm, 200);
  const double step = 1e-3 * static_cast<double>(state.range(0));
  std::vector<ReachPlan> earlier(tasks.size());
  std::vector<Vec3> targets(tasks.size());
  ReachPlanner planner;
  ReachPlan plan;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    test::TaskRandom random(kSeed, 100000 + i);
    const bool planned = planner.plan_minimum_energy(arm, tasks[i].start, tasks[i].target, earlier[i]) == Status::Ok;
    if (!planned) state.SkipWithError("a task of the set has no plan");
    bool reachable = false;  // a refusal is cheaper than a plan and would flatter the figure
    for (int attempt = 0; attempt < 20 && !reachable; ++attempt) {
      targets[i] = tasks[i].target + step * random.in_ball(1.0).normalized();
      reachable = planner.plan_minimum_energy(arm, path_posture(earlier[i].path, 0.3), targets[i], plan) == Status::Ok;
    }
    if (!reachable) targets[i] = tasks[i].target;
  }
  CallTimes times(state);
  std::size_t k = 0;
  long refused = 0;
  for (auto _ : state) {
    const std::size_t i = k++ % tasks.size();
    const Posture now = path_posture(earlier[i].path, 0.3);
    times.measure([&] {
      if (planner.replan_minimum_energy(arm, now, targets[i], earlier[i].path, 0.3, plan) != Status::Ok) ++refused;
    });
    benchmark::DoNotOptimize(plan.path.energy);
  }
  state.counters["refused"] = static_cast<double>(refused);
}
BENCHMARK(replan)->ArgName("mm")->Arg(1)->Arg(20)->Arg(100)->UseManualTime()->Unit(benchmark::kMicrosecond);

MotionGenerator moving_arm(TimingLaw law) {
  MotionSettings settings;
  settings.timing = law;
  MotionGenerator motion(settings);
  (void)motion.command(0.0, MotionCommand{});
  return motion;
}

/// q, dq, ddq from the path alone, without points and device.
void sample_angles(benchmark::State& state) {
  const MotionGenerator motion = moving_arm(TimingLaw::MinimumJerkRiemannian);
  PostureJet jet;
  Vec4 q, dq, ddq;
  double lambda = 0.0;
  for (auto _ : state) {
    lambda = lambda < 0.999 ? lambda + 0.001 : 0.001;
    evaluate_path(motion.path(), lambda, jet);
    angles_from_jet(jet, Vec4::Zero(), q, dq, ddq);
    benchmark::DoNotOptimize(ddq);
  }
}
BENCHMARK(sample_angles);

/// A whole sample: angles, points, girdle and device. Argument: TimingLaw.
void sample(benchmark::State& state) {
  const MotionGenerator motion = moving_arm(static_cast<TimingLaw>(state.range(0)));
  MotionSample out;
  double time = 0.0;
  for (auto _ : state) {
    time = time < 1.5 ? time + 0.001 : 0.0;
    benchmark::DoNotOptimize(motion.sample(time, out));
    benchmark::DoNotOptimize(out);
  }
}
BENCHMARK(sample)->ArgName("law")->Arg(1)->Arg(2);

/// A command whose target has not changed, as in every step of a controller.
void command_without_news(benchmark::State& state) {
  MotionGenerator motion = moving_arm(TimingLaw::MinimumJerkRiemannian);
  double time = 0.0;
  for (auto _ : state) {
    time += 1e-6;
    benchmark::DoNotOptimize(motion.command(time, MotionCommand{}));
  }
}
BENCHMARK(command_without_news);

/// A command that re-plans: plan, limits, unwrapping and device check. Argument: step of the target in mm.
void command_with_news(benchmark::State& state) {
  const double step = 1e-3 * static_cast<double>(state.range(0));
  MotionGenerator motion = moving_arm(TimingLaw::MinimumJerkRiemannian);
  CallTimes times(state);
  MotionCommand command;
  double time = 0.3;
  bool out_and_back = false;
  for (auto _ : state) {
    time += 0.01;
    out_and_back = !out_and_back;
    command.target.x() = MotionCommand{}.target.x() + (out_and_back ? step : 0.0);
    times.measure([&] { benchmark::DoNotOptimize(motion.command(time, command)); });
  }
}
BENCHMARK(command_with_news)->ArgName("mm")->Arg(2)->Arg(20)->Arg(100)->UseManualTime()->Unit(benchmark::kMicrosecond);

}  // namespace

int main(int argc, char** argv) {
  std::vector<char*> arguments(argv, argv + argc);
  char json[] = "--benchmark_format=json";
  const bool chosen = std::any_of(arguments.begin(), arguments.end(), [](const char* text) {
    return std::string_view(text).starts_with("--benchmark_format");
  });
  if (!chosen) arguments.push_back(json);
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
