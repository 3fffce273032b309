#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "glenoid/exoskeleton.hpp"
#include "support/random.hpp"

namespace glenoid::test {

/// Rodrigues by quaternion: independent of the code under test.
inline Mat3 turn(const Vec3& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

inline Mat3 turn(const Vec3& vector) {
  return vector.norm() > 0.0 ? turn(vector, vector.norm()) : Mat3(Mat3::Identity());
}

inline double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

/// Unit vector at least `gap` from parallel to another.
inline Vec3 axis_apart_from(Random& random, const Vec3& other, double gap) {
  for (;;) {
    const Vec3 axis = random.unit_vector();
    const double angle = angle_between(axis, other);
    if (std::min(angle, kPi - angle) >= gap) return axis;
  }
}

/// Any axes (at least `gap` apart), mounts, girdle order; the base is carried by the girdle in half of the devices.
inline ExoSettings random_device(Random& random, double gap = 0.02) {
  ExoSettings device;
  device.axes[0] = random.unit_vector();
  device.axes[1] = axis_apart_from(random, device.axes[0], gap);
  device.axes[2] = axis_apart_from(random, device.axes[1], gap);
  device.base = random.vector(1.8);
  device.cuff = random.vector(1.8);
  device.girdle_order = random.uniform(0.0, 1.0) < 0.5 ? GirdleOrder::ProtractionFirst : GirdleOrder::ElevationFirst;
  device.base_follows_girdle = random.uniform(0.0, 1.0) < 0.5;
  return device;
}

/// A device whose second axis is normal to both neighbours.
inline ExoSettings random_davenport_device(Random& random) {
  ExoSettings device = random_device(random);
  const Vec3 u = device.axes[1].unitOrthogonal(), v = device.axes[1].cross(u);
  for (const std::size_t i : {0u, 2u}) {
    const double angle = random.uniform(-kPi, kPi);
    device.axes[i] = std::cos(angle) * u + std::sin(angle) * v;
  }
  return device;
}

/// A glenohumeral centre where people have theirs, m.
inline Vec3 random_centre(Random& random) { return Vec3(0.16, -0.02, 0.02) + random.vector(0.04); }

/// Girdle's last link for its joint angles, written from the drawing: a joint about z and one about -y in either order.
inline Mat3 girdle_turn(GirdleOrder order, double protraction, double elevation) {
  const Mat3 P = turn(Vec3::UnitZ(), protraction), E = turn(Vec3::UnitY(), -elevation);
  return order == GirdleOrder::ProtractionFirst ? Mat3(P * E) : Mat3(E * P);
}

/// Upper arm in T from the joints: product of the joints one after the other.
inline Mat3 device_pose(const ExoSettings& device, const Vec6& q) {
  Mat3 R = device.base_follows_girdle ? girdle_turn(device.girdle_order, q[0], q[1]) : Mat3(Mat3::Identity());
  R = R * turn(device.base);
  for (int i = 0; i < 3; ++i) R = R * turn(device.axes[static_cast<std::size_t>(i)], q[kShoulder1 + i]);
  return R * turn(device.cuff);
}

/// Smooth motion with exact derivatives over s in [0, 1]: R = Rot(u1, f1) Rot(u2, f2) R0, f(s) = a s + b sin(c s).
struct SmoothMotion {
  struct Wave {
    double a, b, c;
    [[nodiscard]] double value(double s) const { return a * s + b * std::sin(c * s); }
    [[nodiscard]] double d1(double s) const { return a + b * c * std::cos(c * s); }
    [[nodiscard]] double d2(double s) const { return -b * c * c * std::sin(c * s); }
  };

  Vec3 u1, u2, p0, p1;
  Mat3 R0;
  Wave f1, f2, elbow, travel;
  bool reversed = false;

  static Wave wave(Random& random, double size) {
    return {random.uniform(-size, size), random.uniform(-0.3, 0.3) * size, random.uniform(1.0, 6.0)};
  }

  static SmoothMotion random(Random& random, double size = 1.5) {
    return {random.unit_vector(), random.unit_vector(), random_centre(random), random.vector(0.03), random.rotation(),
            wave(random, size),   wave(random, size),   wave(random, size),    wave(random, 1.0)};
  }

  void evaluate(double s, PostureJet& out, PointJet& centre) const {
    const double at = reversed ? 1.0 - s : s, sign = reversed ? -1.0 : 1.0;
    const Mat3 U1 = skew(u1), U2 = skew(u2), E1 = turn(u1, f1.value(at)), E2 = turn(u2, f2.value(at)) * R0;
    const Mat3 R = E1 * E2, A = U1 * R, B = E1 * U2 * E2;
    const double d1 = f1.d1(at), d2 = f2.d1(at);
    const Mat3 dR = sign * (d1 * A + d2 * B);
    const Mat3 ddR = f1.d2(at) * A + f2.d2(at) * B + d1 * d1 * U1 * A + d2 * d2 * E1 * U2 * U2 * E2 +
                     2.0 * d1 * d2 * U1 * B;
    out.x = R.col(0), out.dx = dR.col(0), out.ddx = ddR.col(0);
    out.z = R.col(2), out.dz = dR.col(2), out.ddz = ddR.col(2);
    out.phi = elbow.value(at), out.dphi = sign * elbow.d1(at), out.ddphi = elbow.d2(at);
    centre = {p0 + travel.value(at) * p1, sign * travel.d1(at) * p1, travel.d2(at) * p1};
  }

  [[nodiscard]] JetSource source() const {
    return {[](const void* self, double s, PostureJet& posture, PointJet& centre) noexcept {
              static_cast<const SmoothMotion*>(self)->evaluate(s, posture, centre);
            },
            this};
  }

  static Mat3 skew(const Vec3& w) {
    Mat3 out;
    out << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
    return out;
  }
};

inline Mat3 rotation_of(const PostureJet& jet) {
  Mat3 R;
  R << jet.x, jet.z.cross(jet.x), jet.z;
  return R;
}

inline Posture posture_of(const PostureJet& jet) { return {rotation_of(jet), jet.phi}; }

}  // namespace glenoid::test
