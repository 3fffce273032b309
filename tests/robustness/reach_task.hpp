#pragma once

#include <cstdint>
#include <random>

#include "glenoid/arm_model.hpp"

namespace glenoid::test {

/// Random numbers of one task; every task has a stream of its own, so that it can be replayed alone.
class TaskRandom {
 public:
  TaskRandom(std::uint64_t seed, std::uint64_t index);

  double uniform(double low, double high);
  bool chance(double probability) { return uniform(0.0, 1.0) < probability; }
  Vec3 in_ball(double radius);

 private:
  std::mt19937_64 engine_;
};

/// How the target of a task was made; it decides what is known about the task beforehand.
enum class TargetKind {
  Posture,         ///< wrist of a random posture inside the limits: feasible by construction
  NearlyStraight,  ///< as Posture, with the elbow as straight as the limits allow: near the edge of reach
  BeyondEdge,      ///< a NearlyStraight wrist pushed out by -5..20 mm: may be unreachable
  Anywhere,        ///< a point of the box around the shoulder
};

/// One random reach.
struct ReachTask {
  ArmModel arm;
  Posture start;
  Vec3 target = Vec3::Zero();
  TargetKind kind = TargetKind::Posture;
  Posture known_end;     ///< posture that made the target; only for Posture and NearlyStraight
  bool hanging = false;  ///< start with theta < 2 deg, half of them exactly 0
};

/// Whether known_end is a feasible answer.
inline bool known_feasible(const ReachTask& task) {
  return task.kind == TargetKind::Posture || task.kind == TargetKind::NearlyStraight;
}

/// Random person: sex, stature, mass, rhythm, metric; 30 % with limits reduced as for patients.
ArmModel random_arm(TaskRandom& random);

/// Random posture inside the limits, at least `margin_rad` away from them where the range allows.
Posture random_posture(const JointLimits& limits, TaskRandom& random, double margin_rad = 0.0);

/// Task number `index` of the series `seed`: 20 % hanging starts, 5 % nearly straight elbows at the start.
ReachTask random_task(std::uint64_t seed, std::uint64_t index);

}  // namespace glenoid::test
