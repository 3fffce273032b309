#include "glenoid/rhythm.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "curve_table.hpp"

namespace glenoid {
namespace {

constexpr double kDegree = kPi / 180.0;

// Eq. (1) of Soltani-Zarrin et al. 2017 (docs/equations.md, R2), reconstructed: the printed coefficients were not available.
// They are the centre of all polynomials that reproduce the known values of the curve (0.005 deg), its slope and minimum near
// rest and the energy of one geodesic over it (2e-6 relative). Units are those of the paper, mixed on purpose.
constexpr double kElevation[6] = {7.0813092984e-01, -1.3574472688e-01, 5.2039390474e-03,  // theta deg -> phi_ed deg
                                  1.4376139415e-05, -4.2826783435e-07, 1.4917429164e-09};
constexpr double kProtraction[4] = {0.0, -3.9824419247, -8.0760402164, 1.8198932304};  // theta rad -> phi_pr deg
constexpr double kLength[3] = {1.0, 3e-4, -1.6e-5};                                    // theta deg -> d_SG / d_0

// Measured reaches (R5): the rest vector is that of the lowest measured elevation.
constexpr double kMeasuredRestElevation = -4.5 * kDegree;
constexpr double kMeasuredRestProtraction = -25.0 * kDegree;

struct Scalar2 {
  double value, d1, d2;
};

template <std::size_t N>
Scalar2 polynomial(const double (&c)[N], double x) {
  Scalar2 p{c[N - 1], 0.0, 0.0};
  for (std::size_t k = N - 1; k-- > 0;) {
    p.d2 = p.d2 * x + 2.0 * p.d1;
    p.d1 = p.d1 * x + p.value;
    p.value = p.value * x + c[k];
  }
  return p;
}

/// theta^2 as a function of c = cos(theta), with derivatives; analytic at c = 1, so it is a series there.
Scalar2 squared_angle(double c) {
  constexpr double kSeriesRange = 0.02;  // 1 - c; the series' ratio is (1 - c)/2
  const double v = 1.0 - c;
  if (v < kSeriesRange) {
    // theta^2 = 2 sum_n (2v)^n / (n^2 binom(2n, n))
    double binomial = 1.0;
    Scalar2 w{0.0, 0.0, 0.0};
    double power2 = 0.0, power1 = 1.0;  // (2v)^(n-2), (2v)^(n-1)
    for (int n = 1; n <= 9; ++n) {
      binomial *= 2.0 * (2.0 * n - 1.0) / n;
      const double term = 2.0 / (n * n * binomial);
      w.value += term * power1 * 2.0 * v;
      w.d1 -= term * 2.0 * n * power1;
      w.d2 += term * 4.0 * n * (n - 1) * power2;
      power2 = power1;
      power1 *= 2.0 * v;
    }
    return w;
  }
  constexpr double kLeastSine = 1e-8;  // arm straight up: a kink of the model, kept finite
  const double theta = std::acos(std::max(c, -1.0));
  const double s = std::max(std::sqrt(std::max(0.0, (1.0 - c) * (1.0 + c))), kLeastSine);
  return {theta * theta, -2.0 * theta / s, 2.0 * (s - theta * c) / (s * s * s)};
}

/// theta erf(theta/eps) as a function of w = theta^2; entire in w, so it is a series for small w.
Scalar2 smoothed_angle(double w, double eps) {
  constexpr double kLeastSquare = 1e-20;  // the bare angle has a cone at w = 0; its slope is kept finite
  constexpr double kTwoOverSqrtPi = 1.12837916709551257390;
  const double x = eps > 0.0 ? w / (eps * eps) : 1e9;
  if (x > 36.0) {
    const double safe = std::max(w, kLeastSquare);
    const double r = std::sqrt(safe);
    return {std::sqrt(w), 0.5 / r, -0.25 / (safe * r)};
  }
  if (x < 0.25) {
    Scalar2 h{0.0, 0.0, 0.0};
    double power = 1.0, previous = 0.0;  // (-x)^k / k!, (-1)^k x^(k-1) / k!
    for (int k = 0; k < 13; ++k) {
      const double a = 1.0 / (2 * k + 1);
      h.value += power * a;
      h.d1 += (k + 1) * power * a;
      h.d2 += (k + 1) * k * previous * a;
      previous = -power / (k + 1);
      power *= -x / (k + 1);
    }
    const double scale = kTwoOverSqrtPi / eps;
    return {h.value * scale * w, h.d1 * scale, h.d2 * scale / (eps * eps)};
  }
  const double r = std::sqrt(w);
  const double e = std::erf(r / eps);
  const double g = 0.5 * kTwoOverSqrtPi * std::exp(-x) / eps;
  return {r * e, 0.5 * e / r + g, 0.5 * g / w - 0.25 * e / (w * r) - g / (eps * eps)};
}

struct SineCosine {
  double sine, cosine;
};

/// Taylor series, exact to the last bits for |x| <= 1.3 rad: the girdle's angles stay below 1.1 rad for every elevation.
SineCosine small_angle(double x) {
  const double s = x * x;
  double sine = 1.0, cosine = 1.0;
  for (int k = 11; k >= 1; --k) {
    sine = 1.0 - s * sine * (1.0 / (2.0 * k * (2.0 * k + 1.0)));
    cosine = 1.0 - s * cosine * (1.0 / (2.0 * k * (2.0 * k - 1.0)));
  }
  return {x * sine, cosine};
}

/// Centre of eq. (1) per unit d_0 as a function of the (smoothed) elevation t in rad.
CurveJet polynomial_centre(double t) {
  const double degrees = t / kDegree;
  const Scalar2 ed = polynomial(kElevation, degrees);  // deg, deg/deg
  const Scalar2 pr = polynomial(kProtraction, t);      // deg, deg/rad
  const Scalar2 len = polynomial(kLength, degrees);
  const double a = ed.value * kDegree, a1 = ed.d1, a2 = ed.d2 / kDegree;
  const double b = pr.value * kDegree, b1 = pr.d1 * kDegree, b2 = pr.d2 * kDegree;
  const double d = len.value, d1 = len.d1 / kDegree, d2 = len.d2 / (kDegree * kDegree);
  const auto [sa, ca] = small_angle(a);
  const auto [sb, cb] = small_angle(b);
  const Vec3 e(ca * cb, ca * sb, sa), e_a(-sa * cb, -sa * sb, ca), e_b(-ca * sb, ca * cb, 0.0);
  const Vec3 e_ab(sa * sb, -sa * cb, 0.0), e_bb(-ca * cb, -ca * sb, 0.0);
  const Vec3 e1 = a1 * e_a + b1 * e_b;
  const Vec3 e2 = a2 * e_a + b2 * e_b - a1 * a1 * e + 2.0 * a1 * b1 * e_ab + b1 * b1 * e_bb;
  return {d * e, d1 * e + d * e1, d2 * e + 2.0 * d1 * e1 + d * e2};
}

/// The same as a function of c = cos(theta), smoothed.
CurveJet centre_of_cosine(double c, double smoothing) {
  const Scalar2 w = squared_angle(c);
  const Scalar2 t = smoothed_angle(w.value, smoothing);
  const double t_c = t.d1 * w.d1;
  const double t_cc = t.d2 * w.d1 * w.d1 + t.d1 * w.d2;
  const CurveJet centre = polynomial_centre(t.value);
  return {centre.x, t_c * centre.d1, t_c * t_c * centre.d2 + t_cc * centre.d1};
}

constexpr double kLeastTabulated = 0.01;  // rad; less smoothing would need ever more panels near the hanging arm

/// Table of the smoothed curve, which is a series in (theta/smoothing)^2 = 2 (1 - c)/smoothing^2 near the hanging arm.
std::shared_ptr<const CurveTable> tabulate(double smoothing) {
  if (smoothing < kLeastTabulated) return nullptr;
  return std::make_shared<const CurveTable>(smoothing * smoothing / 8.0,
                                            [smoothing](double c) { return centre_of_cosine(c, smoothing); });
}

double elevation_cosine(const Vec3& z_TU) { return std::clamp(z_TU.z(), -1.0, 1.0); }

void require(bool ok, const char* name, double value, const char* unit, const char* rule) {
  if (!ok) {
    throw std::invalid_argument(std::string(name) + " = " + std::to_string(value) + " " + unit + ": " + rule);
  }
}

}  // namespace

Rhythm::Rhythm(const RhythmSettings& settings, double shoulder_distance_m)
    : settings_(settings), shoulder_distance_m_(shoulder_distance_m) {
  require(settings.gain >= 0.0 && settings.gain <= 1.5, "rhythm.gain", settings.gain, "1", "must be in 0..1.5");
  require(settings.smoothing_rad >= 0.0 && settings.smoothing_rad <= 0.3, "rhythm.smoothing", settings.smoothing_rad,
          "rad", "must be in 0..0.3");
  require(std::isfinite(shoulder_distance_m) && shoulder_distance_m > 0.0, "shoulder distance", shoulder_distance_m,
          "m", "must be finite and greater than 0");
  const int model = static_cast<int>(settings.model);
  require(model >= 1 && model <= 3, "rhythm.model", model, "",
          "must be 1 (Fixed), 2 (SoltaniZarrin2017) or 3 (Measured)");
  for (const double slope : settings.measured.slope_m) {
    require(std::isfinite(slope) && std::abs(slope) <= 1.0, "rhythm.measured.slope", slope, "m", "must be in -1..1");
  }
  const double fitted = settings.measured.shoulder_distance_m;
  require(std::isfinite(fitted) && fitted > 0.0, "rhythm.measured.shoulder_distance", fitted, "m",
          "must be finite and greater than 0");
  rest_ = settings.model == RhythmModel::Measured
              ? girdle_centre({kMeasuredRestElevation, kMeasuredRestProtraction, shoulder_distance_m})
              : Vec3(shoulder_distance_m * polynomial_centre(0.0).x);
  if (settings.model == RhythmModel::SoltaniZarrin2017) table_ = tabulate(settings.smoothing_rad);
}

void Rhythm::anchor(const Vec3& z_TU, const Vec3& p_TS) noexcept { offset_ += p_TS - position(z_TU); }

Vec3 Rhythm::position(const Vec3& z_TU) const noexcept {
  RhythmJet jet;
  evaluate(z_TU, jet);
  return jet.p_TS;
}

void Rhythm::evaluate(const Vec3& z_TU, RhythmJet& out) const noexcept {
  out.J_z.setZero();
  for (Mat3& h : out.H_z) h.setZero();
  if (settings_.model == RhythmModel::Measured) {
    using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    const double scale = settings_.gain * shoulder_distance_m_ / settings_.measured.shoulder_distance_m;
    out.J_z = -scale * Rows(Eigen::Map<const Rows>(settings_.measured.slope_m.data()));
    out.p_TS = offset_ + rest_ + out.J_z * (z_TU - Vec3::UnitZ());
    return;
  }
  if (settings_.model == RhythmModel::Fixed || settings_.gain == 0.0) {
    out.p_TS = offset_ + rest_;
    return;
  }
  const double c = elevation_cosine(z_TU);
  CurveJet centre;
  if (table_ == nullptr || !table_->evaluate(c, centre)) centre = centre_of_cosine(c, settings_.smoothing_rad);
  const double scale = settings_.gain * shoulder_distance_m_;
  out.p_TS = offset_ + rest_ + settings_.gain * (shoulder_distance_m_ * centre.x - rest_);
  out.J_z.col(2) = scale * centre.d1;
  const Vec3 second = scale * centre.d2;
  for (int i = 0; i < 3; ++i) out.H_z[static_cast<std::size_t>(i)](2, 2) = second[i];
}

Vec3 girdle_coordinates(const Vec3& p_TS) noexcept {
  return {std::atan2(p_TS.z(), std::hypot(p_TS.x(), p_TS.y())), std::atan2(p_TS.y(), p_TS.x()), p_TS.norm()};
}

Vec3 girdle_centre(const Vec3& g) noexcept {
  const double ca = std::cos(g[0]);
  return g[2] * Vec3(ca * std::cos(g[1]), ca * std::sin(g[1]), std::sin(g[0]));
}

}  // namespace glenoid
