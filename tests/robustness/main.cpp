// Random reaches against a brute-force reference; every wrong answer is listed so that it can be replayed.
//
//   robustness [--count N] [--seed S] [--only INDEX] [--sweep ANGLES]
//
// GLENOID_TEST_COUNT and GLENOID_TEST_SEED give the defaults. Exit 1 on more than 0.1 % missed minima, on a refusal although
// the reference has an arc of feasible postures, on a wrong acceptance, or on any value that is not finite.
#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <vector>

#include "judge.hpp"

namespace {

using namespace glenoid;
using namespace glenoid::test;

struct Arguments {
  std::uint64_t count = 500;
  std::uint64_t seed = 20171206;
  std::uint64_t first = 0;
  int sweep = 720;
};

std::uint64_t number(const char* text) { return std::strtoull(text, nullptr, 10); }

Arguments parse(int argc, char** argv) {
  Arguments out;
  if (const char* text = std::getenv("GLENOID_TEST_COUNT")) out.count = number(text);
  if (const char* text = std::getenv("GLENOID_TEST_SEED")) out.seed = number(text);
  for (int i = 1; i + 1 < argc; i += 2) {
    if (!std::strcmp(argv[i], "--count")) out.count = number(argv[i + 1]);
    if (!std::strcmp(argv[i], "--seed")) out.seed = number(argv[i + 1]);
    if (!std::strcmp(argv[i], "--sweep")) out.sweep = static_cast<int>(number(argv[i + 1]));
    if (!std::strcmp(argv[i], "--only")) {
      out.first = number(argv[i + 1]);
      out.count = 1;
    }
  }
  return out;
}

void work(const Arguments& arguments, std::atomic<std::uint64_t>& next, std::vector<Judgement>& results) {
  ReachPlanner planner;
  GeodesicSolver solver;
  for (std::uint64_t i = next++; i < arguments.count; i = next++) {
    results[i] = judge(random_task(arguments.seed, arguments.first + i), arguments.sweep, planner, solver);
  }
}

void print_wrong(const Arguments& arguments, std::uint64_t index, const Judgement& result) {
  const ReachTask task = random_task(arguments.seed, index);
  std::printf(
      "%-18s --seed %llu --only %llu  status %s  excess %.2e  arc %d of %d  E %.9g at swivel %.2f deg  "
      "unsolved %d  kind %d  hanging %d  target (%.4f %.4f %.4f)  %s\n",
      to_string(result.verdict), static_cast<unsigned long long>(arguments.seed),
      static_cast<unsigned long long>(index), glenoid::to_string(result.status), result.excess,
      result.reference.widest_arc, arguments.sweep, result.reference.energy, result.reference.swivel_rad * 180.0 / kPi,
      result.reference.unsolved, static_cast<int>(task.kind), task.hanging ? 1 : 0, task.target.x(), task.target.y(),
      task.target.z(), result.remark.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  const Arguments arguments = parse(argc, argv);
  std::vector<Judgement> results(arguments.count);
  std::atomic<std::uint64_t> next{0};
  std::vector<std::thread> threads;
  for (int k = 0; k < 2; ++k) threads.emplace_back([&] { work(arguments, next, results); });
  for (std::thread& thread : threads) thread.join();

  std::array<std::uint64_t, kVerdicts> counts{};
  std::uint64_t leaving = 0;
  for (std::uint64_t i = 0; i < arguments.count; ++i) {
    const Judgement& result = results[i];
    ++counts[static_cast<std::size_t>(result.verdict)];
    if (result.leaves_limits) ++leaving;
    if (result.verdict != Verdict::Solved && result.verdict != Verdict::InfeasibleNamed) {
      print_wrong(arguments, arguments.first + i, result);
    }
  }
  const auto of = [&](Verdict verdict) { return counts[static_cast<std::size_t>(verdict)]; };
  const std::uint64_t feasible = arguments.count - of(Verdict::InfeasibleNamed);
  std::printf("seed %llu: %llu tasks, %llu feasible", static_cast<unsigned long long>(arguments.seed),
              static_cast<unsigned long long>(arguments.count), static_cast<unsigned long long>(feasible));
  for (int k = 0; k < kVerdicts; ++k) {
    std::printf(", %s %llu", to_string(static_cast<Verdict>(k)),
                static_cast<unsigned long long>(counts[static_cast<std::size_t>(k)]));
  }
  std::printf(", limits left on the way %llu\n", static_cast<unsigned long long>(leaving));
  const bool too_many_misses = 1000 * (of(Verdict::Miss) + of(Verdict::NoConvergence)) > feasible;
  return too_many_misses || of(Verdict::FalseInfeasible) || of(Verdict::FalseFeasible) || of(Verdict::NotFinite) ? 1 : 0;
}
