#pragma once

#include <cstdint>

#include "host/drives/load.hpp"
#include "host/drives/profile.hpp"

namespace glenoid::drives {

/// Step of the motor model and its controllers, s.
inline constexpr double kServoStep_s = 250e-6;
inline constexpr std::int64_t kServoStep_ns = 250'000;

/// Where the joint shall be: stands, goes evenly to a target, or slows down.
class Reference {
 public:
  [[nodiscard]] double position() const noexcept { return position_; }
  [[nodiscard]] double velocity() const noexcept { return velocity_; }
  [[nodiscard]] bool at_rest() const noexcept { return mode_ == Mode::Hold; }

  /// Stands at a position, rad.
  void hold(double position_rad) noexcept;
  /// Takes over a motion that runs, before `slow_down`.
  void begin_at(double position_rad, double velocity_rad_per_s) noexcept;
  /// Evenly to the target within the period, then stands there. A step beyond the greatest speed is cut short.
  /// @return false if it was cut
  bool go_to(double target_rad, double period_s, double most_rad_per_s) noexcept;
  /// Slows down from the present velocity, rad/s^2.
  void slow_down(double deceleration) noexcept;
  void advance(double step_s) noexcept;

 private:
  enum class Mode : std::uint8_t { Hold, Line, Ramp };

  Mode mode_ = Mode::Hold;
  double position_ = 0.0, velocity_ = 0.0;
  double target_ = 0.0, left_s_ = 0.0;
  double deceleration_ = 0.0;
};

/// Motor, gear, friction, encoder and the cascade of controllers that drives them; all at the joint, SI units.
/// One rigid inertia, without gravity; what hangs on it comes as a load.
class Servo {
 public:
  Servo(const Profile& profile, double position_rad) noexcept;

  /// Closes the loops at the place where the joint stands; velocity is kept.
  void enable() noexcept;
  /// Power off. A joint at rest is held by its brake from now on, one that moves is slowed down when the brake has closed.
  void disable() noexcept;
  /// One step with the reference's position and velocity, rad and rad/s, and a torque added to the controllers', Nm.
  void step(double position_ref, double velocity_ref, double torque_offset, double step_s) noexcept;
  /// Greatest torque, Nm.
  void limit_torque(double most_Nm) noexcept { most_torque_ = most_Nm; }
  void load(const JointLoad& load) noexcept { load_ = load; }
  void stick_encoder(bool stuck) noexcept { stuck_ = stuck; }
  void jam(bool jammed) noexcept { jammed_ = jammed; }

  [[nodiscard]] double position() const noexcept { return position_; }
  [[nodiscard]] double velocity() const noexcept { return velocity_; }
  [[nodiscard]] double torque() const noexcept { return torque_; }
  [[nodiscard]] bool saturated() const noexcept { return saturated_; }
  /// Position, velocity and net torque for a load that couples several joints.
  [[nodiscard]] JointState state() const noexcept;
  /// What the encoder says: counts, rounded down.
  [[nodiscard]] double counts() const noexcept { return counts_; }
  [[nodiscard]] double measured() const noexcept { return counts_ / counts_per_rad_; }
  /// Filtered difference quotient of the counts, rad/s.
  [[nodiscard]] double measured_velocity() const noexcept { return filtered_velocity_; }

 private:
  [[nodiscard]] bool held() const noexcept { return jammed_ || locked_; }
  [[nodiscard]] double brake_torque_Nm() const noexcept;
  [[nodiscard]] double greatest_torque_Nm(double wanted) const noexcept;
  [[nodiscard]] double friction_Nm_s_per_rad() const noexcept;
  double control(double position_ref, double velocity_ref, double torque_offset, double step_s) noexcept;
  void measure(double step_s) noexcept;

  Mechanics mechanics_;
  Control control_;
  double counts_per_rad_;
  double position_, velocity_ = 0.0;
  double counts_ = 0.0, filtered_velocity_ = 0.0;
  double torque_ = 0.0, integral_ = 0.0;
  double off_s_ = 0.0;  ///< since power was lost
  double most_torque_;
  JointLoad load_;
  bool powered_ = false, saturated_ = false, stuck_ = false, jammed_ = false;
  bool locked_;  ///< by the brake
};

}  // namespace glenoid::drives
