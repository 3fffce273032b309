#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Geometry>

#include "glenoid/exoskeleton.hpp"
#include "problems.hpp"

namespace glenoid {
namespace {

constexpr double kUnitTolerance = 1e-6;        // |axis| - 1, dimensionless: six digits in a file
constexpr double kMinAxisAngle = kPi / 180.0;  // rad; below it T would divide by less than sin(1 deg)
constexpr std::array<const char*, 6> kJointNames = {"GirdleProtraction", "GirdleElevation", "Shoulder1",
                                                    "Shoulder2",         "Shoulder3",       "Elbow"};

/// Angle between two vectors, accurate everywhere in [0, pi].
double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

bool require_finite(const std::string& name, const Vec3& v, const char* unit, Problems& problems) {
  for (int i = 0; i < 3; ++i) {
    problems.require(std::isfinite(v[i]), name + "[" + std::to_string(i + 1) + "]", v[i], unit, "must be finite");
  }
  return v.allFinite();
}

void validate_axes(const std::array<Vec3, 3>& axes, Problems& problems) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string name = "exo.axis" + std::to_string(i + 1);
    if (!require_finite(name, axes[i], "1", problems)) return;
    const double length = axes[i].norm();
    problems.require(std::abs(length - 1.0) <= kUnitTolerance, "length of " + name, length, "1",
                     "must be 1 within 1e-6");
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const double angle = angle_between(axes[i], axes[i + 1]);
    const std::string name = "angle of exo.axis" + std::to_string(i + 1) + " and exo.axis" + std::to_string(i + 2);
    problems.require(std::min(angle, kPi - angle) >= kMinAxisAngle, name, angle, "rad",
                     "consecutive axes must be at least 1 deg from parallel");
  }
}

void validate_joints(const ExoSettings& settings, Problems& problems) {
  for (int i = 0; i < 6; ++i) {
    const std::string joint = std::string("[") + exo_joint_name(i) + "]";
    const double lower = settings.lower[i], upper = settings.upper[i];
    problems.require(!std::isnan(lower), "exo.lower" + joint, lower, "rad", "must be a number");
    problems.require(!std::isnan(upper), "exo.upper" + joint, upper, "rad", "must be a number");
    problems.require(!(lower >= upper), "exo.lower" + joint, lower, "rad", "must be below the upper limit");
  }
}

void validate_mount(const std::string& name, const Vec3& rotation, Problems& problems) {
  if (!require_finite(name, rotation, "rad", problems)) return;
  problems.require(rotation.norm() <= 2.0 * kPi, "length of " + name, rotation.norm(), "rad",
                   "rotation vector longer than one turn; degrees in the file?");
}

void validate_girdle(const ExoSettings& settings, const Vec3& p_TS_ref, Problems& problems) {
  const int order = static_cast<int>(settings.girdle_order), drives = static_cast<int>(settings.girdle_drives);
  problems.require(order == 1 || order == 2, "exo.girdleOrder", order, "1",
                   "must be 1 (ProtractionFirst) or 2 (ElevationFirst)");
  problems.require(drives >= 1 && drives <= 4, "exo.girdleDrives", drives, "1",
                   "must be 1 (Full), 2 (NoLength), 3 (VerticalOnly) or 4 (None)");
  problems.require(!settings.base_follows_girdle || drives <= 2, "exo.baseFollowsGirdle", 1.0, "1",
                   "needs a girdle that turns: drives Full or NoLength");
  problems.require_range("exo.girdleLink", settings.girdle_link_m, 0.0, 1.0, "m");
  if (!require_finite("shoulder centre at the start", p_TS_ref, "m", problems)) return;
  problems.require(p_TS_ref.norm() >= 1e-3, "distance of the shoulder centre at the start", p_TS_ref.norm(), "m",
                   "must be at least 1 mm from the sternoclavicular joint");
}

void validate(const ExoSettings& settings, const Vec3& p_TS_ref) {
  Problems problems;
  validate_axes(settings.axes, problems);
  validate_mount("exo.base", settings.base, problems);
  validate_mount("exo.cuff", settings.cuff, problems);
  validate_girdle(settings, p_TS_ref, problems);
  problems.require(settings.min_singularity_rad >= 0.0 && settings.min_singularity_rad < 0.5 * kPi,
                   "exo.minSingularity", settings.min_singularity_rad, "rad", "must be at least 0 and below pi/2");
  validate_joints(settings, problems);
  problems.throw_if_any();
}

Mat3 rotation(const Vec3& vector) {
  const double angle = vector.norm();
  if (angle == 0.0) return Mat3::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

/// Constants of X1 and X2 from unit axes.
ShoulderGeometry shoulder_geometry(const std::array<Vec3, 3>& a, const Mat3& R_LU) {
  ShoulderGeometry g;
  g.a = a;
  g.p3 = a[2].unitOrthogonal();
  g.s3 = a[2].cross(g.p3);
  g.u2 = (a[0] - a[0].dot(a[1]) * a[1]).normalized();
  g.v2 = a[1].cross(g.u2);
  g.a3_U = R_LU.transpose() * a[2];
  g.p3_U = R_LU.transpose() * g.p3;
  g.a12 = angle_between(a[0], a[1]);
  g.a23 = angle_between(a[1], a[2]);
  g.c23 = std::cos(g.a23);
  g.s23 = std::sin(g.a23);
  g.psi = -std::atan2(a[2].dot(g.v2), a[2].dot(g.u2));
  g.cos_psi = std::cos(g.psi);
  g.sin_psi = std::sin(g.psi);
  const double half_diff = 0.5 * (g.a12 - g.a23), half_sum = 0.5 * (g.a12 + g.a23);
  g.cos_diff = std::cos(half_diff);
  g.sin_diff = std::sin(half_diff);
  g.cos_sum = std::cos(half_sum);
  g.sin_sum = std::sin(half_sum);
  g.least = 2.0 * std::abs(half_diff);
  g.most = std::min(2.0 * half_sum, 2.0 * kPi - 2.0 * half_sum);
  return g;
}

}  // namespace

const char* exo_joint_name(int joint) noexcept {
  return joint >= 0 && joint < 6 ? kJointNames[static_cast<std::size_t>(joint)] : "unknown joint";
}

ExoModel::ExoModel(const ExoSettings& settings, const Vec3& p_TS_ref) : settings_(settings) {
  validate(settings, p_TS_ref);
  for (Vec3& axis : settings_.axes) axis.normalize();
  R_GB_ = rotation(settings.base);
  R_LU_ = rotation(settings.cuff);
  shoulder_ = shoulder_geometry(settings_.axes, R_LU_);
  const bool fixed_link = settings.girdle_drives != GirdleDrives::Full && settings.girdle_link_m > 0.0;
  rest_centre_ = fixed_link ? Vec3(settings.girdle_link_m * p_TS_ref.normalized()) : p_TS_ref;
}

}  // namespace glenoid
