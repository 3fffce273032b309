#include "glenoid/posture_prior.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "glenoid/kinematics.hpp"

namespace glenoid {
namespace {

constexpr double kFar = 0.2;      // arm lengths at which half of the regression has happened
constexpr double kLevers = 0.03;  // product of the two levers below at which half of the anchor's swivel angle is believed

/// How well the points define their swivel angle: distance of the elbow from the line shoulder-wrist times the sine of that
/// line's angle to the vertical, the first in upper-arm lengths. 0 where the swivel angle is undefined.
double conditioning(const ArmPoints& p) {
  const Vec3 line = p.wrist - p.shoulder, upper = p.elbow - p.shoulder;
  const double length = line.norm();
  if (length == 0.0) return 0.0;
  const Vec3 n = line / length;
  return n.cross(upper).norm() / upper.norm() * n.cross(Vec3::UnitZ()).norm();
}

/// x^2 / (x^2 + scale^2)
double saturating(double x, double scale) { return x * x / (x * x + scale * scale); }

}  // namespace

PosturePrior::PosturePrior(const PosturePriorCoefficients& c, const ArmModel& arm, const Posture& anchor)
    : coefficients_(c), length_m_(arm.upper_arm.length_m + arm.forearm.length_m) {
  const std::array<std::pair<const char*, double>, 4> all{
      {{"height", c.height_rad}, {"lateral", c.lateral_rad}, {"regression", c.regression}, {"common", c.common_rad}}};
  for (const auto& [name, value] : all) {
    if (!(std::abs(value) <= 10.0)) {
      throw std::invalid_argument("posture_prior." + std::string(name) + " = " + std::to_string(value) +
                                  ": must be in -10..10");
    }
  }
  if (c.regression < 0.0 || c.regression > 1.0) {
    throw std::invalid_argument("posture_prior.regression = " + std::to_string(c.regression) + " 1: must be in 0..1");
  }
  const ArmPoints points = forward_kinematics(arm, anchor);
  wrist_ = points.wrist;
  const double belief = saturating(conditioning(points), kLevers);
  own_rad_ = belief == 0.0 ? c.common_rad : c.common_rad + belief * (swivel_angle(points) - c.common_rad);
}

double PosturePrior::swivel(const Vec3& target) const noexcept {
  const Vec3 d = (target - wrist_) / length_m_;
  const PosturePriorCoefficients& c = coefficients_;
  return own_rad_ + c.height_rad * d.z() + c.lateral_rad * d.x() +
         c.regression * saturating(d.norm(), kFar) * (c.common_rad - own_rad_);
}

}  // namespace glenoid
