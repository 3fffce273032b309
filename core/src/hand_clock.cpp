#include "glenoid/hand_clock.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "glenoid/kinematics.hpp"
#include "lobatto.hpp"

namespace glenoid {
namespace {

constexpr std::size_t kCount = HandClock::kOrder + 1;
constexpr double kLeastWay = 0.01;      // m
constexpr double kLeastSpeed = 0.05;    // of the mean hand speed: below it the hand almost pauses
constexpr double kFitTolerance = 1e-6;  // of lambda

using Coefficients = std::array<double, kCount>;

/// Value and derivatives of a Legendre series on [0, 1].
ScalarJet series(const Coefficients& c, double s) {
  const double x = 2.0 * s - 1.0;
  double p0 = 1.0, d0 = 0.0, e0 = 0.0, p1 = x, d1 = 1.0, e1 = 0.0;
  ScalarJet y{c[0], 0.0, 0.0};
  for (std::size_t n = 1; n < kCount; ++n) {
    const double k = static_cast<double>(n);
    y.value += c[n] * p1;
    y.d1 += c[n] * d1;
    y.d2 += c[n] * e1;
    const double p2 = ((2.0 * k + 1.0) * x * p1 - k * p0) / (k + 1.0);
    const double d2 = d0 + (2.0 * k + 1.0) * p1, e2 = e0 + (2.0 * k + 1.0) * d1;
    p0 = p1, d0 = d1, e0 = e1, p1 = p2, d1 = d2, e1 = e2;
  }
  return {y.value, 2.0 * y.d1, 4.0 * y.d2};
}

Coefficients fit(const Coefficients& values) {
  const Lobatto& grid = lobatto(HandClock::kOrder);
  Coefficients c{};
  for (std::size_t m = 0; m < kCount; ++m) {
    for (std::size_t k = 0; k < kCount; ++k) c[m] += grid.to_legendre[m * kCount + k] * values[k];
  }
  return c;
}

/// Coefficients of the integral from 0 to s; the last one of the integrand is dropped, it is at the rounding level.
Coefficients integral(const Coefficients& c) {
  Coefficients out{};
  for (std::size_t n = 0; n + 1 < kCount; ++n) {
    const double half = 0.5 * c[n] / (2.0 * static_cast<double>(n) + 1.0);  // ds = dx / 2
    out[n + 1] += half;
    if (n > 0) out[n - 1] -= half;
  }
  out[0] -= series(out, 0.0).value;
  return out;
}

double hand_speed(const ArmModel& arm, const GeodesicPath& path, double lambda) {
  PostureJet j;
  evaluate_path(path, lambda, j);
  RhythmJet shoulder;
  arm.rhythm.evaluate(j.z, shoulder);
  const double s = std::sin(j.phi), c = std::cos(j.phi);
  const Vec3 y = j.z.cross(j.x), dy = j.dz.cross(j.x) + j.z.cross(j.dx);
  const Vec3 dzf = -s * dy + c * j.dz - j.dphi * (c * y + s * j.z);
  return (shoulder.J_z * j.dz - arm.upper_arm.length_m * j.dz - arm.forearm.length_m * dzf).norm();
}

}  // namespace

bool fit_hand_clock(const ArmModel& arm, const GeodesicPath& path, HandClock& out) noexcept {
  const Lobatto& grid = lobatto(HandClock::kOrder);
  Coefficients speed{};
  for (std::size_t k = 0; k < kCount; ++k) speed[k] = hand_speed(arm, path, grid.node[k]);
  const Coefficients way = integral(fit(speed));
  const double total = series(way, 1.0).value;
  if (!(total > kLeastWay) || *std::min_element(speed.begin(), speed.end()) < kLeastSpeed * total) return false;
  Coefficients lambda{};
  for (std::size_t k = 0; k < kCount; ++k) {
    double low = 0.0, high = 1.0, guess = grid.node[k];
    for (int it = 0; it < 60; ++it) {
      const ScalarJet s = series(way, guess);
      const double error = s.value - grid.node[k] * total;
      (error < 0.0 ? low : high) = guess;
      double next = guess - error / s.d1;
      if (!(next >= low && next <= high)) next = 0.5 * (low + high);
      const bool done = std::abs(next - guess) < 1e-15;
      guess = next;
      if (done) break;
    }
    lambda[k] = guess;
  }
  lambda[0] = 0.0;
  lambda[kCount - 1] = 1.0;
  out.legendre = fit(lambda);
  return std::abs(out.legendre[kCount - 1]) + std::abs(out.legendre[kCount - 2]) < kFitTolerance;
}

ScalarJet hand_lambda(const HandClock& clock, double h) noexcept {
  return series(clock.legendre, std::clamp(h, 0.0, 1.0));
}

}  // namespace glenoid
