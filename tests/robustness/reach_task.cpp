#include "reach_task.hpp"

#include <algorithm>
#include <cmath>

#include "glenoid/kinematics.hpp"

namespace glenoid::test {
namespace {

constexpr double kDegree = kPi / 180.0;

/// Cuts a range of motion from one or both sides, as after a stroke or with a contracture.
void reduce_limits(TaskRandom& random, JointLimits& limits) {
  limits.upper[kLimitTheta] = random.uniform(60.0, 150.0) * kDegree;
  for (const int k : {kLimitEta, kLimitTau, kLimitPhi}) {
    const double range = limits.upper[k] - limits.lower[k];
    limits.lower[k] += random.uniform(0.0, 0.35) * range;
    limits.upper[k] -= random.uniform(0.0, 0.35) * range;
  }
}

RhythmSettings random_rhythm(TaskRandom& random) {
  RhythmSettings rhythm;
  const double pick = random.uniform(0.0, 1.0);
  if (pick < 0.1) {
    rhythm.model = RhythmModel::Fixed;
  } else if (pick < 0.2) {
    rhythm.model = RhythmModel::Measured;
  }
  rhythm.gain = random.chance(0.2) ? random.uniform(0.0, 1.5) : 1.0;
  return rhythm;
}

double elbow_in(const JointLimits& limits, double low, double high) {
  return std::clamp(low, limits.lower[kLimitPhi], limits.upper[kLimitPhi]) +
         std::max(0.0, std::min(high, limits.upper[kLimitPhi]) - std::max(low, limits.lower[kLimitPhi])) * 0.5;
}

Posture random_start(const JointLimits& limits, TaskRandom& random, bool hanging) {
  Posture start = random_posture(limits, random);
  if (hanging) {
    const double theta = random.chance(0.5) ? 0.0 : random.uniform(0.0, 2.0 * kDegree);
    const double eta = random.uniform(limits.lower[kLimitEta], limits.upper[kLimitEta]);
    const double tau = random.uniform(limits.lower[kLimitTau], limits.upper[kLimitTau]);
    start = posture_from_angles(Vec4(theta, eta, tau - eta, start.phi));
  }
  if (random.chance(0.05)) start.phi = elbow_in(limits, 0.0, random.uniform(0.0, 6.0) * kDegree);
  return start;
}

}  // namespace

TaskRandom::TaskRandom(std::uint64_t seed, std::uint64_t index) {
  std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                         static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(index >> 32)};
  engine_.seed(sequence);
}

double TaskRandom::uniform(double low, double high) {
  return low + (high - low) * std::ldexp(static_cast<double>(engine_() >> 11), -53);
}

Vec3 TaskRandom::in_ball(double radius) {
  for (;;) {
    const double x = uniform(-1.0, 1.0), y = uniform(-1.0, 1.0), z = uniform(-1.0, 1.0);
    const Vec3 point(x, y, z);
    if (point.squaredNorm() <= 1.0) return radius * point;
  }
}

ArmModel random_arm(TaskRandom& random) {
  Subject subject;
  subject.female = random.chance(0.5);
  subject.stature_m = random.uniform(1.5, 2.0);
  subject.mass_kg = random.uniform(45.0, 110.0);
  JointLimits limits;
  if (random.chance(0.3)) reduce_limits(random, limits);
  const ScaledArm scaled = scale_subject(subject);
  const Rhythm rhythm(random_rhythm(random), scaled.shoulder_distance_m);
  return make_arm_model(scaled, rhythm, limits, !random.chance(0.2));
}

Posture random_posture(const JointLimits& limits, TaskRandom& random, double margin_rad) {
  Vec4 angles;
  for (int k = 0; k < 4; ++k) {
    const double margin = std::min(margin_rad, 0.4 * (limits.upper[k] - limits.lower[k]));
    angles[k] = random.uniform(limits.lower[k] + margin, limits.upper[k] - margin);
  }
  return posture_from_angles(
      Vec4(angles[kLimitTheta], angles[kLimitEta], angles[kLimitTau] - angles[kLimitEta], angles[kLimitPhi]));
}

ReachTask random_task(std::uint64_t seed, std::uint64_t index) {
  TaskRandom random(seed, index);
  ReachTask task;
  task.arm = random_arm(random);
  const JointLimits& limits = task.arm.limits;
  task.hanging = random.chance(0.2);
  task.start = random_start(limits, random, task.hanging);
  const double pick = random.uniform(0.0, 1.0);
  task.kind = pick < 0.6   ? TargetKind::Posture
              : pick < 0.8 ? TargetKind::NearlyStraight
              : pick < 0.9 ? TargetKind::BeyondEdge
                           : TargetKind::Anywhere;
  task.known_end = random_posture(limits, random);
  if (task.kind == TargetKind::NearlyStraight || task.kind == TargetKind::BeyondEdge) {
    task.known_end.phi = elbow_in(limits, 0.0, random.uniform(0.0, 16.0) * kDegree);
  }
  const ArmPoints points = forward_kinematics(task.arm, task.known_end);
  task.target = points.wrist;
  if (task.kind == TargetKind::BeyondEdge) {
    task.target += random.uniform(-0.005, 0.020) * (points.wrist - points.shoulder).normalized();
  } else if (task.kind == TargetKind::Anywhere) {
    task.target = points.shoulder + random.in_ball(task.arm.upper_arm.length_m + task.arm.forearm.length_m + 0.1);
  }
  return task;
}

}  // namespace glenoid::test
