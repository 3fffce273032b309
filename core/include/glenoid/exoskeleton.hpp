#pragma once

#include <array>

#include "glenoid/path.hpp"
#include "glenoid/status.hpp"

namespace glenoid {

using Vec6 = Eigen::Matrix<double, 6, 1>;

/// Index of each joint in exo.q, also the order of the drives on the bus.
enum ExoJoint : int {
  kGirdleProtraction = 0, kGirdleElevation = 1, kShoulder1 = 2, kShoulder2 = 3, kShoulder3 = 4, kElbow = 5
};

enum class GirdleOrder : int { ProtractionFirst = 1, ElevationFirst = 2 };

/// Which drives the girdle has; a missing one leaves a residual that is reported, never hidden.
enum class GirdleDrives : int { Full = 1, NoLength = 2, VerticalOnly = 3, None = 4 };

/// Parameters of the device (docs/equations.md, X1-X6). Rotations are rotation vectors, rad.
struct ExoSettings {
  std::array<Vec3, 3> axes = {Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitZ()};   ///< unit, in the exo base frame at its zero
  Vec3 base = Vec3::Zero();      ///< B: exo base in the thorax frame
  Vec3 cuff = Vec3::Zero();      ///< C: upper arm in the last shoulder link
  GirdleOrder girdle_order = GirdleOrder::ProtractionFirst;
  GirdleDrives girdle_drives = GirdleDrives::Full;
  bool base_follows_girdle = false;   ///< the girdle carries (rotates) the shoulder axes; false: a parallelogram keeps them level
  double girdle_link_m = 0.0;         ///< fixed length used when there is no length drive; 0 = d_SG of the start posture
  double min_singularity_rad = 0.0;   ///< paths nearer to the singular set than this are refused; 0 = only infeasible ones
  Vec6 lower = Vec6::Constant(-1e9);  ///< device joint limits, rad; default none
  Vec6 upper = Vec6::Constant(1e9);
};

}  // namespace glenoid
