#include "host/load/arm_load.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>
#include <string>

#include "glenoid/arm_model.hpp"

namespace glenoid::load {
namespace {

/// Columns (p_TS, x_U, y_U, z_U, y_F, z_F) in T, or a derivative of them (docs/equations.md, E1).
using Embedding = Eigen::Matrix<double, 3, 6>;

ExoModel model_of(const ArmLoadSettings& settings) {
  if (settings.exo.girdle_drives == GirdleDrives::VerticalOnly)
    throw std::invalid_argument("load: girdle drives VerticalOnly are a slide, which the model of the load lacks");
  if (!(settings.girdle_length_m > 0.0 && settings.girdle_length_m < 1.0))
    throw std::invalid_argument("load: girdle_length_m = " + std::to_string(settings.girdle_length_m) +
                                " m: must be above 0 and below 1");
  if (!std::isfinite(settings.gravity_m_per_s2) || settings.gravity_m_per_s2 < 0.0)
    throw std::invalid_argument("load: gravity_m_per_s2 = " + std::to_string(settings.gravity_m_per_s2) +
                                " m/s^2: must not be negative");
  return {settings.exo, Vec3(settings.girdle_length_m, 0.0, 0.0)};
}

Mat6 mass_of(const ArmLoadSettings& settings) {
  ScaledArm arm;
  arm.upper_arm = settings.upper_arm;
  arm.forearm = settings.forearm;
  arm.shoulder_distance_m = settings.girdle_length_m;
  return make_arm_model(arm, Rhythm(), JointLimits(), true).mass;
}

Vec3 turned(const Vec3& about, double angle, const Vec3& v) noexcept { return Eigen::AngleAxisd(angle, about) * v; }

/// Where the mechanism stands and the axes in T about which its joints turn it, unit.
struct Chain {
  Embedding F;
  std::array<Vec3, 2> girdle;  ///< protraction and elevation: turn the shoulder's centre about the origin
  std::array<Vec3, 6> axis;    ///< turn upper arm and forearm; zero where a joint does not, the elbow the forearm alone
  bool protraction_first;
};

Chain chain_of(const ExoModel& model, const Vec6& x, double length_m) noexcept {
  const ExoSettings& exo = model.settings();
  const bool first = exo.girdle_order == GirdleOrder::ProtractionFirst;
  const Vec3 protraction = Vec3::UnitZ(), elevation = -Vec3::UnitY();
  Chain c;
  c.protraction_first = first;
  c.girdle = {first ? protraction : turned(elevation, x[kGirdleElevation], protraction),
              first ? turned(protraction, x[kGirdleProtraction], elevation) : elevation};
  for (std::size_t k = 0; k < 2; ++k) c.axis[k] = exo.base_follows_girdle ? c.girdle[k] : Vec3(Vec3::Zero());
  Mat3 R = exo_base(model, x[kGirdleProtraction], x[kGirdleElevation]);
  for (std::size_t k = 0; k < 3; ++k) {
    c.axis[kShoulder1 + k] = R * exo.axes[k];
    R = R * Eigen::AngleAxisd(x[static_cast<Eigen::Index>(kShoulder1 + k)], exo.axes[k]).toRotationMatrix();
  }
  R = R * model.R_LU();
  c.axis[kElbow] = R.col(0);
  const double cosine = std::cos(x[kElbow]), sine = std::sin(x[kElbow]);
  c.F << exo_centre(model, x, length_m), R, cosine * R.col(1) + sine * R.col(2), -sine * R.col(1) + cosine * R.col(2);
  return c;
}

/// dF/dx_k.
Embedding tangent(const Chain& c, std::size_t k) noexcept {
  Embedding d = Embedding::Zero();
  if (k < c.girdle.size()) d.col(0) = c.girdle[k].cross(c.F.col(0));
  for (Eigen::Index column = k == kElbow ? 4 : 1; column < 6; ++column)
    d.col(column) = c.axis[k].cross(c.F.col(column));
  return d;
}

/// Angular velocity of a body and its acceleration at constant rates of the joints.
struct Turning {
  Vec3 w = Vec3::Zero(), alpha = Vec3::Zero();
  /// A joint further out, whose axis the body so far carries along.
  void add(const Vec3& axis, double rate) noexcept {
    alpha += w.cross(axis) * rate;
    w += axis * rate;
  }
  /// Acceleration of a vector that is fixed in the body.
  [[nodiscard]] Vec3 bend(const Vec3& r) const noexcept { return alpha.cross(r) + w.cross(w.cross(r)); }
};

/// Second derivative of F in time at constant rates.
Embedding bending(const Chain& c, const Vec6& v) noexcept {
  const std::size_t outer = c.protraction_first ? 0 : 1, inner = 1 - outer;
  Turning girdle, arm;
  for (const std::size_t k : {outer, inner}) {
    girdle.add(c.girdle[k], v[static_cast<Eigen::Index>(k)]);
    arm.add(c.axis[k], v[static_cast<Eigen::Index>(k)]);
  }
  for (std::size_t k = kShoulder1; k < kElbow; ++k) arm.add(c.axis[k], v[static_cast<Eigen::Index>(k)]);
  Turning forearm = arm;
  forearm.add(c.axis[kElbow], v[kElbow]);
  Embedding d;
  d.col(0) = girdle.bend(c.F.col(0));
  for (Eigen::Index k = 1; k < 4; ++k) d.col(k) = arm.bend(c.F.col(k));
  for (Eigen::Index k = 4; k < 6; ++k) d.col(k) = forearm.bend(c.F.col(k));
  return d;
}

}  // namespace

ArmDynamics::ArmDynamics(const ArmLoadSettings& settings)
    : exo_(model_of(settings)),
      mass_(mass_of(settings)),
      girdle_length_m_(settings.girdle_length_m),
      gravity_(0.0, 0.0, -settings.gravity_m_per_s2) {}

void ArmDynamics::evaluate(const Vec6& x, const Vec6& v, Mat6& M, Vec6& bias) const noexcept {
  const Chain chain = chain_of(exo_, x, girdle_length_m_);
  Embedding bent = bending(chain, v);
  bent.col(0) -= gravity_;  // weight is what an upward acceleration of everything would be
  const Embedding force = bent * mass_;
  std::array<Embedding, 6> J;
  for (std::size_t k = 0; k < J.size(); ++k) {
    J[k] = tangent(chain, k);
    const auto row = static_cast<Eigen::Index>(k);
    const Embedding momentum = J[k] * mass_;
    for (std::size_t j = 0; j <= k; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      M(row, column) = M(column, row) = momentum.cwiseProduct(J[j]).sum();
    }
    bias[row] = force.cwiseProduct(J[k]).sum();
  }
}

double ArmDynamics::potential_J(const Vec6& x) const noexcept {
  return -gravity_.dot(chain_of(exo_, x, girdle_length_m_).F * mass_.col(0));  // column 0: total mass and first moments
}

void ArmLoad::act(std::span<const drives::JointState> joints, std::span<drives::JointLoad> loads) noexcept {
  Vec6 x, v, torque;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const auto& own = joints[static_cast<std::size_t>(k)];
    const JointDirection& direction = joints_[static_cast<std::size_t>(k)];
    x[k] = direction.sign * own.position_rad + direction.offset_rad;
    v[k] = direction.sign * own.velocity_rad_per_s;
    torque[k] = direction.sign * own.torque_Nm;
  }
  Mat6 M;
  Vec6 bias;
  dynamics_.evaluate(x, v, M, bias);
  Mat6 whole = M;
  Vec6 push = torque - bias;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const auto& own = joints[static_cast<std::size_t>(k)];
    if (own.held) {  // takes no part: the others move as if it were a wall
      whole.row(k).setZero();
      whole.col(k).setZero();
      push[k] = 0.0;
    }
    whole(k, k) = M(k, k) + own.inertia_kg_m2;
  }
  const Mat6 mobility = whole.llt().solve(Mat6::Identity());
  for (Eigen::Index k = 0; k < 6; ++k) {
    const auto own = static_cast<std::size_t>(k);
    const double inertia = 1.0 / mobility(k, k);
    const double others = mobility.row(k).dot(push) - mobility(k, k) * push[k];
    loads[own] = {joints_[own].sign * (inertia * others - bias[k]), inertia - joints[own].inertia_kg_m2};
  }
}

}  // namespace glenoid::load
