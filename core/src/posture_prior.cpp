#include "glenoid/posture_prior.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "glenoid/kinematics.hpp"

namespace glenoid {
namespace {

constexpr double kFar = 0.2;      // spans at which half of the regression has happened
constexpr double kLevers = 0.03;  // product of the two levers below at which half of the anchor's swivel angle is believed

/// Radius of the elbow's circle about the line shoulder-wrist in upper-arm lengths, and the sine of that line's angle to the
/// vertical: the levers that define a swivel angle. It is undefined where one of them is 0.
struct Levers {
  double circle = 0.0, slant = 0.0;
};

Levers levers(const ArmPoints& p) {
  const Vec3 line = p.wrist - p.shoulder, upper = p.elbow - p.shoulder;
  const double length = line.norm();
  if (length == 0.0) return {};
  const Vec3 n = line / length;
  return {n.cross(upper).norm() / upper.norm(), n.cross(Vec3::UnitZ()).norm()};
}

/// Swivel angle of the arm's plane, which the elbow's axis x_U gives also where the arm is straight.
double hinge_swivel(const ArmPoints& p, const Mat3& R_TU) {
  ArmPoints bent = p;
  bent.elbow = p.shoulder + (p.wrist - p.shoulder).cross(R_TU.col(0));
  return swivel_angle(bent);
}

/// x^2 / (x^2 + scale^2)
double saturating(double x, double scale) { return x * x / (x * x + scale * scale); }

}  // namespace

PosturePrior::PosturePrior(const PosturePriorCoefficients& c, const ArmModel& arm, const Posture& anchor)
    : coefficients_(c) {
  const std::array<std::pair<const char*, double>, 6> all{{{"height", c.height_rad},
                                                           {"lateral", c.lateral_rad},
                                                           {"regression", c.regression},
                                                           {"common", c.common_rad},
                                                           {"effort", c.effort},
                                                           {"lift", c.lift_per_m}}};
  for (const auto& [name, value] : all) {
    if (!(std::abs(value) <= 10.0)) {
      throw std::invalid_argument("posture_prior." + std::string(name) + " = " + std::to_string(value) +
                                  ": must be in -10..10");
    }
  }
  if (c.regression < 0.0 || c.regression > 1.0) {
    throw std::invalid_argument("posture_prior.regression = " + std::to_string(c.regression) + " 1: must be in 0..1");
  }
  if (c.effort < 0.0) {
    throw std::invalid_argument("posture_prior.effort = " + std::to_string(c.effort) + " 1: must not be negative");
  }
  if (c.lift_per_m < 0.0) {
    throw std::invalid_argument("posture_prior.lift = " + std::to_string(c.lift_per_m) + " 1/m: must not be negative");
  }
  const ArmPoints points = forward_kinematics(arm, anchor);
  wrist_ = points.wrist;
  const Levers own = levers(points);
  const double belief = saturating(own.circle * own.slant, kLevers);
  rotation_ = anchor.R_TU;
  own_rad_ = belief == 0.0 ? c.common_rad : c.common_rad + belief * (swivel_angle(points) - c.common_rad);
}

double PosturePrior::swivel(const Vec3& target) const noexcept {
  const Vec3 d = (target - wrist_) / kPriorSpan;
  const PosturePriorCoefficients& c = coefficients_;
  return own_rad_ + c.height_rad * d.z() + c.lateral_rad * d.x() +
         c.regression * saturating(d.norm(), kFar) * (c.common_rad - own_rad_);
}

double PosturePrior::lift(const Vec3& from, const Vec3& to) const noexcept {
  const double level = std::min((to - from).head<2>().norm(), kMostLevel);
  return coefficients_.lift_per_m * level * level;
}

double PosturePrior::cost(const ArmModel& arm, const Posture& posture, double swivel_rad) const noexcept {
  const ArmPoints points = forward_kinematics(arm, posture);
  const double chord = 2.0 * std::sin(0.5 * (hinge_swivel(points, posture.R_TU) - swivel_rad));
  const double turn = 2.0 * std::asin(std::min(1.0, (posture.R_TU - rotation_).norm() / std::sqrt(8.0)));
  return chord * chord + coefficients_.effort * turn * turn;
}

}  // namespace glenoid
