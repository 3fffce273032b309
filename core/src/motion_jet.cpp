#include "motion_jet.hpp"

#include <cmath>

#include <Eigen/Geometry>

namespace glenoid {
namespace {

/// sin(r)/r and (1 - cos(r))/r^2 as functions of s = r^2, with two derivatives: entire functions, summed as series.
struct Rodrigues {
  ScalarJet a, b;
};

Rodrigues rodrigues(double s) {
  constexpr int kTerms = 22;  // below 1e-17 for s up to 16, an angle of 4 rad
  Rodrigues f;
  double ca = 1.0, cb = 0.5;                       // (-1)^k / (2k+1)!, (-1)^k / (2k+2)!
  double power = 1.0, power1 = 0.0, power2 = 0.0;  // s^k and derivatives
  for (int k = 0; k < kTerms; ++k) {
    f.a.value += ca * power, f.a.d1 += ca * power1, f.a.d2 += ca * power2;
    f.b.value += cb * power, f.b.d1 += cb * power1, f.b.d2 += cb * power2;
    ca /= -(2.0 * k + 2.0) * (2.0 * k + 3.0);
    cb /= -(2.0 * k + 3.0) * (2.0 * k + 4.0);
    power2 = power2 * s + 2.0 * power1;
    power1 = power1 * s + power;
    power *= s;
  }
  return f;
}

ScalarJet chain(const ScalarJet& f, const ScalarJet& s) {
  return {f.value, f.d1 * s.d1, f.d2 * s.d1 * s.d1 + f.d1 * s.d2};
}

/// v(t) rotated by exp[d(t)]: e_k -> exp[d] e_k with derivatives, as the k-th column.
struct ColumnJet {
  Vec3 v, dv, ddv;
};

ColumnJet rotated_unit(const Vec3& e, const ColumnJet& d, const ScalarJet& a, const ScalarJet& b) {
  const Vec3 c = d.v.cross(e), dc = d.dv.cross(e), ddc = d.ddv.cross(e);
  const Vec3 q = d.v.cross(c), dq = d.dv.cross(c) + d.v.cross(dc);
  const Vec3 ddq = d.ddv.cross(c) + 2.0 * d.dv.cross(dc) + d.v.cross(ddc);
  return {e + a.value * c + b.value * q, a.d1 * c + a.value * dc + b.d1 * q + b.value * dq,
          a.d2 * c + 2.0 * a.d1 * dc + a.value * ddc + b.d2 * q + 2.0 * b.d1 * dq + b.value * ddq};
}

/// R(t) w(t) for R given by the columns of a jet.
ColumnJet apply(const PostureJet& j, const ColumnJet& w) {
  const Vec3 y = j.z.cross(j.x), dy = j.dz.cross(j.x) + j.z.cross(j.dx);
  const Vec3 ddy = j.ddz.cross(j.x) + 2.0 * j.dz.cross(j.dx) + j.z.cross(j.ddx);
  Mat3 R, dR, ddR;
  R << j.x, y, j.z;
  dR << j.dx, dy, j.dz;
  ddR << j.ddx, ddy, j.ddz;
  return {R * w.v, dR * w.v + R * w.dv, ddR * w.v + 2.0 * dR * w.dv + R * w.ddv};
}

/// Adds the earlier motion that fades out (T3): R <- R exp[d], phi <- phi + d.
void add_fading_motion(const MotionState& s, double time, PostureJet& j) {
  ColumnJet d;
  for (int i = 0; i < 3; ++i) {
    const ScalarJet f = fading_motion(time, s.move_time_s, s.fade_duration_s, s.fade_w[i], s.fade_dw[i]);
    d.v[i] = f.value;
    d.dv[i] = f.d1;
    d.ddv[i] = f.d2;
  }
  const ScalarJet f = fading_motion(time, s.move_time_s, s.fade_duration_s, s.fade_dphi, s.fade_ddphi);
  const ScalarJet square{d.v.squaredNorm(), 2.0 * d.v.dot(d.dv), 2.0 * (d.dv.squaredNorm() + d.v.dot(d.ddv))};
  const Rodrigues r = rodrigues(square.value);
  const ScalarJet a = chain(r.a, square), b = chain(r.b, square);
  const ColumnJet x = apply(j, rotated_unit(Vec3::UnitX(), d, a, b));
  const ColumnJet z = apply(j, rotated_unit(Vec3::UnitZ(), d, a, b));
  j.x = x.v, j.dx = x.dv, j.ddx = x.ddv;
  j.z = z.v, j.dz = z.dv, j.ddz = z.ddv;
  j.phi += f.value, j.dphi += f.d1, j.ddphi += f.d2;
}

/// Replaces derivatives with respect to s by derivatives with respect to the variable that s depends on.
void chain_rule(const ScalarJet& s, PostureJet& j) {
  const double square = s.d1 * s.d1;
  j.ddx = square * j.ddx + s.d2 * j.dx, j.dx *= s.d1;
  j.ddz = square * j.ddz + s.d2 * j.dz, j.dz *= s.d1;
  j.ddphi = square * j.ddphi + s.d2 * j.dphi, j.dphi *= s.d1;
}

}  // namespace

void movement_jet(const MotionState& s, double time, PostureJet& out, ScalarJet* progress) noexcept {
  ScalarJet lambda{};
  if (s.moving != 0) {
    const auto law = [&s](double t, double start, double duration) {
      return s.hand_timing == 2 ? homing_minimum_jerk(t, start, duration) : minimum_jerk(t, start, duration);
    };
    lambda = law(time, s.move_time_s, s.duration_s);
    if (s.fade_share > 0.0) {
      const ScalarJet early = law(time, s.move_time_s, s.fade_duration_s);
      const double w = s.fade_share;
      lambda = {(1.0 - w) * lambda.value + w * early.value, (1.0 - w) * lambda.d1 + w * early.d1,
                (1.0 - w) * lambda.d2 + w * early.d2};
    }
    if (s.hand_timing == 1) {
      const ScalarJet h = lambda;
      lambda = chain(hand_lambda(s.hand_clock, h.value), h);
    }
  }
  evaluate_path(s.path, lambda.value, out);
  chain_rule(lambda, out);
  const bool fading = s.fade_duration_s > 0.0 && time < s.move_time_s + s.fade_duration_s;
  if (fading) add_fading_motion(s, time, out);
  if (progress != nullptr) *progress = lambda;
}

void motion_jet(const MotionState& s, double time, PostureJet& out, ScalarJet& progress) noexcept {
  if (s.stopping == 0) {
    movement_jet(s, time, out, &progress);
    return;
  }
  const ScalarJet clock = stopping_clock(time, s.stop_time_s, s.stop_duration_s);
  movement_jet(s, clock.value, out, &progress);
  chain_rule(clock, out);
  progress = chain(progress, clock);
}

bool at_rest(const MotionState& s, double time) noexcept {
  if (s.moving == 0) return true;
  const double end = s.move_time_s + s.duration_s;
  if (s.stopping == 0) return time >= end;
  const ScalarJet clock = stopping_clock(time, s.stop_time_s, s.stop_duration_s);
  return time >= s.stop_time_s + s.stop_duration_s || clock.value >= end;
}

void body_rates(const PostureJet& j, PostureRates& rates, PostureRates& accelerations) noexcept {
  const Vec3 y = j.z.cross(j.x);
  const Vec3 w(-y.dot(j.dz), j.x.dot(j.dz), y.dot(j.dx));
  rates = {w, j.dphi};
  accelerations.w_TU_U = Vec3(w.y() * w.z() - y.dot(j.ddz), j.x.dot(j.ddz) - w.z() * w.x(),
                              y.dot(j.ddx) - w.x() * w.y());
  accelerations.phi = j.ddphi;
}

Posture jet_posture(const PostureJet& j) noexcept {
  Posture p;
  p.R_TU << j.x, j.z.cross(j.x), j.z;
  p.phi = j.phi;
  return p;
}

}  // namespace glenoid
