#include "reference.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "glenoid/kinematics.hpp"

namespace glenoid::test {
namespace {

struct Candidate {
  Posture end;
  double swivel_rad = 0.0;
  double energy = 0.0;
};

constexpr double kRivalTurn = 2.0;  // rad; beyond it the geodesic the long way round is tried, too
constexpr double kNever = std::numeric_limits<double>::infinity();

double energy_at(const ArmModel& arm, const Posture& start, const Posture& end, double tail, const GeodesicPath* near,
                 GeodesicSolver& solver) {
  GeodesicOptions options;
  options.tail_tolerance = tail;
  GeodesicPath path;
  Certificate certificate;
  double energy = kNever;
  if (solver.solve(arm, start, end, options, near, path, certificate) == Status::Ok) energy = path.energy;
  if (near != nullptr || certificate.rotation_angle_rad < kRivalTurn) return energy;
  options.long_way = true;
  if (solver.solve(arm, start, end, options, nullptr, path, certificate) == Status::Ok)
    energy = std::min(energy, path.energy);
  return energy;
}

int longest_cyclic_run(const std::vector<bool>& flags) {
  const int n = static_cast<int>(flags.size());
  int best = 0, run = 0;
  for (int i = 0; i < 2 * n && best < n; ++i) {
    run = flags[static_cast<std::size_t>(i % n)] ? run + 1 : 0;
    best = std::max(best, run);
  }
  return best;
}

/// Energies of the cheapest candidates again, converged; the first pass is good to about 1e-4.
void refine(const ArmModel& arm, const Posture& start, std::vector<Candidate>& candidates, GeodesicSolver& solver,
            Reference& out) {
  std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.energy < b.energy; });
  const double bound = candidates.front().energy * (1.0 + 1e-3);
  out.energy = kNever;
  int refined = 0;
  for (const Candidate& candidate : candidates) {
    if (candidate.energy > bound || ++refined > 12) break;
    const double energy = converged_energy(arm, start, candidate.end, solver);
    if (energy >= out.energy) continue;
    out.energy = energy;
    out.swivel_rad = candidate.swivel_rad;
  }
}

}  // namespace

double converged_energy(const ArmModel& arm, const Posture& start, const Posture& end, GeodesicSolver& solver,
                        const GeodesicPath* near) {
  for (const double tail : {1e-7, 1e-5, 1e-3}) {  // the looser ones only where the path has no tighter solution
    const double energy = energy_at(arm, start, end, tail, near, solver);
    if (energy < kNever) return energy;
  }
  return kNever;
}

Reference sweep_swivel(const ArmModel& arm, const Posture& start, const Vec3& target, int count,
                       GeodesicSolver& solver) {
  Reference out;
  std::vector<Candidate> candidates;
  std::vector<bool> feasible(static_cast<std::size_t>(count), false);
  IkSolutions solutions;
  for (int i = 0; i < count; ++i) {
    const double swivel = 2.0 * kPi * i / count - kPi;
    if (inverse_kinematics(arm, target, swivel, solutions) != Status::Ok) continue;
    for (int k = 0; k < solutions.count; ++k) {
      const Posture& end = solutions.postures[static_cast<std::size_t>(k)];
      out.reachable = true;
      if (limit_margin(arm.limits, end).margin_rad < 0.0) continue;
      feasible[static_cast<std::size_t>(i)] = true;
      const double energy = energy_at(arm, start, end, 1e-3, nullptr, solver);
      if (energy < kNever)
        candidates.push_back({end, swivel, energy});
      else
        ++out.unsolved;
    }
  }
  out.widest_arc = longest_cyclic_run(feasible);
  out.feasible = out.widest_arc > 0;
  out.energy = kNever;
  if (!candidates.empty()) refine(arm, start, candidates, solver, out);
  return out;
}

}  // namespace glenoid::test
