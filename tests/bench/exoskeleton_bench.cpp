#include <benchmark/benchmark.h>

#include <array>

#include "core/exo_probe.hpp"
#include "glenoid/exoskeleton.hpp"

namespace {

using namespace glenoid;

constexpr std::size_t kInstants = 64;

struct Instant {
  PostureJet posture;
  PointJet centre;
  Vec3 near_q;
};

/// Postures along one motion, so that no two samples in a row are alike.
std::array<Instant, kInstants> instants_along(const test::SmoothMotion& motion) {
  std::array<Instant, kInstants> out;
  for (std::size_t k = 0; k < kInstants; ++k) {
    motion.evaluate(static_cast<double>(k) / kInstants, out[k].posture, out[k].centre);
    out[k].near_q.setZero();
  }
  return out;
}

ExoSettings tilted_device(bool carried) {
  ExoSettings device;
  device.axes[1] = Vec3(0.9659258262890683, 0.0, 0.2588190451025207);  // 75 deg from z
  device.axes[2] = Vec3(0.0, 0.2588190451025207, 0.9659258262890683);
  device.base = Vec3(0.1, 0.2, 0.3);
  device.cuff = Vec3(0.0, 0.1, 0.0);
  device.base_follows_girdle = carried;
  return device;
}

/// T with first and second derivatives for one sample; argument: whether the girdle carries the base.
void transformation_with_derivatives(benchmark::State& state) {
  test::Random random(1);
  const ExoModel model(tilted_device(state.range(0) != 0), Vec3(0.17, -0.02, 0.01));
  const auto instants = instants_along(test::SmoothMotion::random(random));
  ExoSample out;
  std::size_t k = 0;
  for (auto _ : state) {
    const Instant& now = instants[k++ % kInstants];
    benchmark::DoNotOptimize(map_to_exo(model, ExoBranch::First, now.posture, now.centre, now.near_q, out));
    benchmark::DoNotOptimize(out);
  }
}
BENCHMARK(transformation_with_derivatives)->Arg(0)->Arg(1);

/// Joints alone, as a workspace scan asks for them.
void transformation_of_a_posture(benchmark::State& state) {
  test::Random random(2);
  const ExoModel model(tilted_device(false), Vec3(0.17, -0.02, 0.01));
  std::array<Mat3, kInstants> postures;
  for (Mat3& R : postures) R = random.rotation();
  ShoulderSolution out;
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        shoulder_joints(model, model.R_GB(), postures[k++ % kInstants], ExoBranch::First, Vec3::Zero(), out));
    benchmark::DoNotOptimize(out);
  }
}
BENCHMARK(transformation_of_a_posture);

/// Whole motion with limits on every joint, at plan time.
void check_of_a_motion(benchmark::State& state) {
  test::Random random(3);
  ExoSettings device = tilted_device(false);
  device.lower.setConstant(-3.0);
  device.upper.setConstant(3.0);
  const ExoModel model(device, Vec3(0.17, -0.02, 0.01));
  std::array<test::SmoothMotion, 16> motions;
  for (auto& motion : motions) motion = test::SmoothMotion::random(random, 0.8);
  ExoPathCheck out;
  std::size_t k = 0;
  double samples = 0.0;
  for (auto _ : state) {
    const auto source = motions[k++ % motions.size()].source();
    benchmark::DoNotOptimize(check_motion(model, source, ExoStart(), false, out));
    samples += out.samples;
  }
  state.counters["samples"] = benchmark::Counter(samples, benchmark::Counter::kAvgIterations);
}
BENCHMARK(check_of_a_motion);

}  // namespace
