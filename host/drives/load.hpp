#pragma once

#include <cstddef>
#include <span>

namespace glenoid::drives {

/// A joint as its load sees it, in the drive's own direction.
struct JointState {
  double position_rad = 0.0;  ///< true, not the encoder's
  double velocity_rad_per_s = 0.0;
  double torque_Nm = 0.0;      ///< of the motor, less friction
  double inertia_kg_m2 = 0.0;  ///< of rotor, gear and link
  bool held = false;           ///< by its brake, or blocked: it does not move whatever pushes
};

/// What the load does to a joint, as `Drive::set_load` takes it.
struct JointLoad {
  double torque_Nm = 0.0;
  double inertia_kg_m2 = 0.0;
};

/// A mechanism that couples the joints of one group of drives. Port of the drives; what hangs on it is somebody else's.
class Load {
 public:
  virtual ~Load() = default;

  /// How many joints it couples.
  [[nodiscard]] virtual std::size_t joints() const noexcept = 0;

  /// From the state of every joint to its load during the next servo step. @alloc none
  virtual void act(std::span<const JointState> joints, std::span<JointLoad> loads) noexcept = 0;
};

}  // namespace glenoid::drives
