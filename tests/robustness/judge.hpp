#pragma once

#include <string>

#include "glenoid/swivel.hpp"
#include "reach_task.hpp"
#include "reference.hpp"

namespace glenoid::test {

enum class Verdict {
  Solved,
  InfeasibleNamed,  // right answers
  Miss,
  FalseInfeasible,
  NarrowRefused,
  FalseFeasible,
  NotFinite,
  NoConvergence,
};
inline constexpr int kVerdicts = 8;
const char* to_string(Verdict verdict) noexcept;

struct Judgement {
  Verdict verdict = Verdict::Solved;
  Status status = Status::Ok;
  double excess = 0.0;  ///< (planned - reference)/reference energy
  bool leaves_limits = false;
  Reference reference;
  std::string remark;
};

/// Least relative excess of energy that counts as a miss of the global minimum.
inline constexpr double kMissTolerance = 1e-6;
/// Energy below which differences are compared absolutely, kg.m2: about one millimetre of hand path.
inline constexpr double kSmallEnergy = 1e-6;

/// Plans one task and judges the answer against the sweep of `count` swivel angles.
Judgement judge(const ReachTask& task, int count, ReachPlanner& planner, GeodesicSolver& solver);

}  // namespace glenoid::test
