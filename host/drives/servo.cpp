#include "host/drives/servo.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace glenoid::drives {
namespace {

constexpr double kCoulombSmoothing_rad_per_s = 0.02;  // Coulomb friction becomes viscous below
constexpr double kAtRest_rad_per_s = 0.02;            // slower, the brake closes before the power goes
constexpr double kInstant_s = 1e-9;                   // the resolution of time

}  // namespace

void Reference::hold(double position_rad) noexcept {
  mode_ = Mode::Hold;
  position_ = position_rad;
  velocity_ = 0.0;
}

void Reference::begin_at(double position_rad, double velocity_rad_per_s) noexcept {
  position_ = position_rad;
  velocity_ = velocity_rad_per_s;
}

bool Reference::go_to(double target_rad, double period_s, double most_rad_per_s) noexcept {
  const double most = most_rad_per_s * period_s;
  const double step = std::clamp(target_rad - position_, -most, most);
  const bool whole = std::abs(target_rad - position_) <= most;
  mode_ = Mode::Line;
  target_ = whole ? target_rad : position_ + step;
  left_s_ = period_s;
  velocity_ = step / period_s;
  return whole;
}

void Reference::slow_down(double deceleration) noexcept {
  mode_ = Mode::Ramp;
  deceleration_ = deceleration;
}

void Reference::advance(double step_s) noexcept {
  if (mode_ == Mode::Line) {
    left_s_ -= step_s;
    position_ = target_ - velocity_ * std::max(left_s_, 0.0);
    // It stands a servo step later than the target was reached: a stop that begins right then begins with the line's
    // velocity, and a SYNC that is late by less does not shake the motor.
    if (left_s_ <= -kServoStep_s + kInstant_s) hold(target_);
  } else if (mode_ == Mode::Ramp) {
    const double change = deceleration_ * step_s;
    if (std::abs(velocity_) <= change) {
      hold(position_ + 0.5 * velocity_ * std::abs(velocity_) / deceleration_);
    } else {
      const double next = velocity_ - std::copysign(change, velocity_);
      position_ += 0.5 * (velocity_ + next) * step_s;
      velocity_ = next;
    }
  }
}

Servo::Servo(const Profile& profile, double position_rad) noexcept
    : mechanics_(profile.mechanics),
      control_(profile.control),
      counts_per_rad_(profile.mechanics.counts_per_rev() / (2.0 * std::numbers::pi)),
      position_(position_rad),
      counts_(std::floor(position_rad * counts_per_rad_)),
      most_torque_(profile.mechanics.peak_torque_Nm),
      locked_(profile.mechanics.brake) {}

void Servo::enable() noexcept {
  powered_ = true;
  locked_ = false;
  integral_ = 0.0;
  off_s_ = 0.0;
}

void Servo::disable() noexcept {
  powered_ = false;
  locked_ = mechanics_.brake && std::abs(velocity_) < kAtRest_rad_per_s;
}

/// Of a brake that has closed and slips.
double Servo::brake_torque_Nm() const noexcept {
  const bool slips = mechanics_.brake && !powered_ && !locked_ && off_s_ > mechanics_.brake_delay_s;
  return slips ? mechanics_.brake_torque_Nm : 0.0;
}

/// What the supply's voltage leaves: all up to the greatest speed, nothing at the no-load speed.
double Servo::greatest_torque_Nm(double wanted) const noexcept {
  const double along = std::copysign(1.0, wanted) * velocity_ / mechanics_.max_speed_rad_per_s;
  const double share = (mechanics_.no_load_speed_ratio - along) / (mechanics_.no_load_speed_ratio - 1.0);
  return most_torque_ * std::clamp(share, 0.0, 1.0);
}

/// Friction torque over velocity at the present velocity.
double Servo::friction_Nm_s_per_rad() const noexcept {
  return mechanics_.viscous_friction_Nm_s_per_rad +
         mechanics_.coulomb_friction_Nm /
             std::sqrt(velocity_ * velocity_ + kCoulombSmoothing_rad_per_s * kCoulombSmoothing_rad_per_s);
}

JointState Servo::state() const noexcept {
  const double lost = friction_Nm_s_per_rad() * velocity_ + std::copysign(brake_torque_Nm(), velocity_);
  return {position_, velocity_, torque_ - lost, mechanics_.inertia_kg_m2, held()};
}

double Servo::control(double position_ref, double velocity_ref, double torque_offset, double step_s) noexcept {
  const double gain = mechanics_.inertia_kg_m2 * control_.velocity_bandwidth_rad_per_s;  // Nm s/rad
  const double wanted = velocity_ref + control_.position_bandwidth_rad_per_s * (position_ref - measured());
  const double error = wanted - filtered_velocity_;
  const double torque = gain * error + integral_ + torque_offset;
  const double most = greatest_torque_Nm(torque);
  const double limited = std::clamp(torque, -most, most);
  saturated_ = limited != torque;
  if (!saturated_) integral_ += gain * error * step_s / control_.integral_time_s;  // no wind-up
  return limited;
}

void Servo::measure(double step_s) noexcept {
  const double before = counts_;
  if (!stuck_) counts_ = std::floor(position_ * counts_per_rad_);
  const double velocity = (counts_ - before) / counts_per_rad_ / step_s;
  filtered_velocity_ += (velocity - filtered_velocity_) * step_s / (step_s + control_.velocity_filter_s);
}

void Servo::step(double position_ref, double velocity_ref, double torque_offset, double step_s) noexcept {
  torque_ = powered_ ? control(position_ref, velocity_ref, torque_offset, step_s) : 0.0;
  saturated_ = powered_ && saturated_;
  if (!powered_) off_s_ += step_s;
  if (held()) {
    velocity_ = 0.0;
  } else {
    // Friction is taken at the end of the step, so it can stop the joint but never push it.
    const double inertia = mechanics_.inertia_kg_m2 + load_.inertia_kg_m2;
    const double damping = 1.0 + step_s * friction_Nm_s_per_rad() / inertia;
    velocity_ = (velocity_ + step_s * (torque_ + load_.torque_Nm) / inertia) / damping;
    if (const double most = step_s * brake_torque_Nm() / inertia; most > 0.0) {
      locked_ = std::abs(velocity_) <= most;
      velocity_ = locked_ ? 0.0 : velocity_ - std::copysign(most, velocity_);
    }
  }
  position_ += velocity_ * step_s;
  measure(step_s);
}

}  // namespace glenoid::drives
