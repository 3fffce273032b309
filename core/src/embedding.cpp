#include "embedding.hpp"

#include <cmath>

#include <Eigen/Geometry>

#include "kernels.hpp"
#include "turning.hpp"

namespace glenoid {
namespace {

void set_row3(double (&J)[kEmbedding][4], int column, int variable, const Vec3& v) {
  for (int r = 0; r < 3; ++r) J[3 * column + r][variable] = v[r];
}

void set_columns(const EmbeddedNode& node, bool shoulder, double (&F)[kEmbedding]) {
  const Vec3 columns[6] = {shoulder ? node.shoulder.p_TS : Vec3(Vec3::Zero()),
                           node.R.col(0),
                           node.R.col(1),
                           node.R.col(2),
                           node.R_F.col(1),
                           node.R_F.col(2)};
  for (int c = 0; c < 6; ++c) {
    for (int r = 0; r < 3; ++r) F[3 * c + r] = columns[c][r];
  }
}

void set_turning(EmbeddedNode& node) {
  const TurningFeature feature = turning_feature(node.R);
  for (int r = 0; r < 2; ++r) {
    double* row = node.J[kColumns + r];
    for (int a = 0; a < 3; ++a) row[a] = feature.t_rate(r, a);
    row[3] = 0.0;
    node.F[kColumns + r] = feature.t[r];
  }
}

void embed_frames(const Posture& posture, double s, double c, EmbeddedNode& node) {
  node.R = posture.R_TU;
  node.R_F.col(0) = node.R.col(0);
  node.R_F.col(1) = c * node.R.col(1) + s * node.R.col(2);
  node.R_F.col(2) = -s * node.R.col(1) + c * node.R.col(2);
}

}  // namespace

void embed(const ArmModel& arm, const Posture& posture, bool with_shoulder, EmbeddedNode& node) noexcept {
  const double s = std::sin(posture.phi), c = std::cos(posture.phi);
  embed_frames(posture, s, c, node);
  const bool shoulder = with_shoulder || arm.moving_shoulder;
  const Vec3 x = node.R.col(0), y = node.R.col(1), z = node.R.col(2);
  const Vec3 yf = node.R_F.col(1), zf = node.R_F.col(2);
  for (int i = 0; i < kColumns; ++i) node.J[i][0] = node.J[i][1] = node.J[i][2] = node.J[i][3] = 0.0;
  set_row3(node.J, 1, 1, -z);
  set_row3(node.J, 1, 2, y);
  set_row3(node.J, 2, 0, z);
  set_row3(node.J, 2, 2, -x);
  set_row3(node.J, 3, 0, -y);
  set_row3(node.J, 3, 1, x);
  // Forearm: rotation vector Rx(phi)^T delta + dphi e_x in its own frame.
  set_row3(node.J, 4, 0, zf);
  set_row3(node.J, 4, 3, zf);
  set_row3(node.J, 4, 1, s * x);
  set_row3(node.J, 4, 2, -c * x);
  set_row3(node.J, 5, 0, -yf);
  set_row3(node.J, 5, 3, -yf);
  set_row3(node.J, 5, 1, c * x);
  set_row3(node.J, 5, 2, s * x);
  if (shoulder) {
    arm.rhythm.evaluate(z, node.shoulder);
    set_row3(node.J, 0, 0, -(node.shoulder.J_z * y));
    set_row3(node.J, 0, 1, node.shoulder.J_z * x);
  }
  set_columns(node, shoulder, node.F);
  if (arm.turning_kg_m2 != 0.0) set_turning(node);
  apply_mass(arm.mass.data(), arm.turning_kg_m2, node);
}

Mat4 embedding_curvature(const EmbeddedNode& node, const double force[kEmbedding], bool with_shoulder,
                         bool turning) noexcept {
  const auto column = [force](int c) { return Vec3(force[3 * c], force[3 * c + 1], force[3 * c + 2]); };
  const Mat3 Rt = node.R.transpose(), Rft = node.R_F.transpose();
  const Vec3 fX = column(0);
  Vec3 fz = column(3);
  if (with_shoulder) fz += node.shoulder.J_z.transpose() * fX;

  Mat3 B;
  B.col(0) = Rt * column(1);
  B.col(1) = Rt * column(2);
  B.col(2) = Rt * fz;
  Mat3 Hr = 0.5 * (B + B.transpose());
  Hr.diagonal().array() -= B.trace();

  Mat3 Bf = Mat3::Zero();
  Bf.col(1) = Rft * column(4);
  Bf.col(2) = Rft * column(5);
  Mat3 Hf = 0.5 * (Bf + Bf.transpose());
  Hf.diagonal().array() -= Bf.trace();
  const Vec3 torque = Vec3::UnitY().cross(Bf.col(1)) + Vec3::UnitZ().cross(Bf.col(2));
  const Mat3 Rx = Rt * node.R_F;

  Mat4 H = Mat4::Zero();
  H.topLeftCorner<3, 3>() = Hr + Rx * Hf * Rx.transpose();
  H.topRightCorner<3, 1>() = Rx * (Hf.col(0) - 0.5 * torque.cross(Vec3::UnitX()));
  H(3, 3) = Hf(0, 0);
  if (with_shoulder) {
    const Mat3 K = fX[0] * node.shoulder.H_z[0] + fX[1] * node.shoulder.H_z[1] + fX[2] * node.shoulder.H_z[2];
    Eigen::Matrix<double, 3, 2> dz;
    dz.col(0) = -node.R.col(1);
    dz.col(1) = node.R.col(0);
    H.topLeftCorner<2, 2>() += dz.transpose() * K * dz;
  }
  if (turning) {
    H.topLeftCorner<3, 3>() += turning_curvature(turning_feature(node.R), {force[kColumns], force[kColumns + 1]});
  }
  H.bottomLeftCorner<1, 3>() = H.topRightCorner<3, 1>().transpose();
  return H;
}

Eigen::Matrix<double, 3, 4> wrist_jacobian(const ArmModel& arm, const EmbeddedNode& node) noexcept {
  Eigen::Matrix<double, 3, 4> J;
  for (int r = 0; r < 3; ++r) {
    for (int a = 0; a < 4; ++a) {
      J(r, a) = node.J[r][a] - arm.upper_arm.length_m * node.J[9 + r][a] - arm.forearm.length_m * node.J[15 + r][a];
    }
  }
  return J;
}

Posture retract(const Posture& posture, const Tangent& step) noexcept {
  return {posture.R_TU * rotation(step.head<3>()), posture.phi + step[3]};
}

namespace {

/// sin(a)/a and (1 - cos(a))/a^2 as functions of a^2.
struct RotationFactors {
  double sine, versine;
};

RotationFactors rotation_factors(double square) {
  constexpr double kSeriesRange = 0.25;  // rad^2; the first term left out is 1e-17
  if (square < kSeriesRange) {
    RotationFactors f{1.0, 1.0};
    for (int k = 7; k >= 1; --k) {
      f.sine = 1.0 - square * f.sine * (1.0 / (2.0 * k * (2.0 * k + 1.0)));
      f.versine = 1.0 - square * f.versine * (1.0 / ((2.0 * k + 1.0) * (2.0 * k + 2.0)));
    }
    return {f.sine, 0.5 * f.versine};
  }
  const double half = 0.5 * std::sqrt(square);
  const double s = std::sin(half), c = std::cos(half);
  return {s * c / half, 2.0 * s * s / square};
}

}  // namespace

Mat3 rotation(const Vec3& v) noexcept {
  const auto [a, b] = rotation_factors(v.squaredNorm());
  const double xx = v.x() * v.x(), yy = v.y() * v.y(), zz = v.z() * v.z();
  const double xy = b * v.x() * v.y(), xz = b * v.x() * v.z(), yz = b * v.y() * v.z();
  Mat3 R;
  R << 1.0 - b * (yy + zz), xy - a * v.z(), xz + a * v.y(),  //
      xy + a * v.z(), 1.0 - b * (xx + zz), yz - a * v.x(),   //
      xz - a * v.y(), yz + a * v.x(), 1.0 - b * (xx + yy);
  return R;
}

Vec3 rotation_vector(const Mat3& R) noexcept {
  const Vec3 s = 0.5 * Vec3(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  const double sine = s.norm();
  const double cosine = 0.5 * (R.trace() - 1.0);
  const double angle = std::atan2(sine, cosine);
  if (cosine > -0.9) return sine > 1e-12 ? Vec3(s * (angle / sine)) : s;
  // Near pi the axis comes from the symmetric part.
  const Mat3 S = 0.5 * (R + R.transpose()) - cosine * Mat3::Identity();
  int k = 0;
  S.diagonal().maxCoeff(&k);
  Vec3 axis = S.col(k).normalized();
  if (axis.dot(s) < 0.0) axis = -axis;
  return angle * axis;
}

Mat3 rotation_x(double angle) noexcept {
  const double c = std::cos(angle), s = std::sin(angle);
  Mat3 R;
  R << 1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c;
  return R;
}

}  // namespace glenoid
