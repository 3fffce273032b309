#pragma once

#include <algorithm>
#include <vector>

#include "glenoid/kinematics.hpp"
#include "reach_task.hpp"

namespace glenoid::bench {

inline constexpr double kDegree = kPi / 180.0;
inline constexpr std::uint64_t kSeed = 1;

/// Kinds of geodesics whose costs differ: they need different orders.
enum class Kind : int { General = 0, High = 1, Hanging = 2 };

struct Pair {
  Posture start, end;
};

/// The default subject with the default rhythm, limits and metric.
inline ArmModel default_arm() {
  const ScaledArm scaled = scale_subject(Subject{});
  return make_arm_model(scaled, Rhythm({}, scaled.shoulder_distance_m), {}, true);
}

/// Posture with a given range of elevation, the other angles as in daily activities.
inline Posture posture_between(test::TaskRandom& random, double theta_low, double theta_high) {
  const double theta = random.uniform(theta_low, theta_high) * kDegree;
  const double eta = random.uniform(-75.0, 30.0) * kDegree, tau = random.uniform(-40.0, 60.0) * kDegree;
  return posture_from_angles(Vec4(theta, eta, tau - eta, random.uniform(10.0, 120.0) * kDegree));
}

/// General: elevations 15..95 deg; high: ends at 100..148 deg; hanging: starts at 5..15 deg.
inline std::vector<Pair> pairs(Kind kind, int count) {
  std::vector<Pair> out;
  for (int i = 0; i < count; ++i) {
    test::TaskRandom random(kSeed, static_cast<std::uint64_t>(1000 * static_cast<int>(kind) + i));
    Pair pair;
    pair.start = kind == Kind::Hanging ? posture_between(random, 5.0, 15.0) : posture_between(random, 15.0, 60.0);
    pair.end = kind == Kind::High ? posture_between(random, 100.0, 148.0) : posture_between(random, 40.0, 95.0);
    out.push_back(pair);
  }
  return out;
}

struct Reach {
  Posture start;
  Vec3 target;
};

/// Reaches of the default subject, 60 % general, 20 % high, 20 % from the hanging arm; all feasible.
inline std::vector<Reach> reaches(const ArmModel& arm, int count) {
  std::vector<Reach> out;
  for (const Kind kind : {Kind::General, Kind::High, Kind::Hanging}) {
    for (const Pair& pair : pairs(kind, kind == Kind::General ? count - 2 * (count / 5) : count / 5)) {
      out.push_back({pair.start, forward_kinematics(arm, pair.end).wrist});
    }
  }
  return out;
}

}  // namespace glenoid::bench
