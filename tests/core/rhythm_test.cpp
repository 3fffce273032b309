#include "glenoid/rhythm.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/arms.hpp"
#include "support/environment.hpp"
#include "support/matchers.hpp"
#include "support/random.hpp"

namespace glenoid::test {
namespace {

constexpr double kDistance = 0.17;  // d_0, m
constexpr double kEps = std::numeric_limits<double>::epsilon();

/// z_TU of an arm elevated by theta in the plane eta.
Vec3 direction(double theta, double eta) {
  return {std::sin(eta) * std::sin(theta), -std::cos(eta) * std::sin(theta), std::cos(theta)};
}

Rhythm rhythm_with(double smoothing_rad, RhythmModel model = RhythmModel::SoltaniZarrin2017,
                   double distance = kDistance) {
  return Rhythm({model, 1.0, smoothing_rad}, distance);
}

// --- The published curve -------------------------------------------------------------------------------------------

struct TableRow {
  double theta_deg, phi_ed_deg, phi_pr_deg, length_ratio;
  Vec3 displacement_cm;  // lateral, forward, up; d_0 = 0.20 m
};

class PublishedCurve : public testing::TestWithParam<TableRow> {};

TEST_P(PublishedCurve, IsReproducedToItsPrintedDigits) {
  const TableRow& row = GetParam();
  const Rhythm rhythm = rhythm_with(0.0, RhythmModel::SoltaniZarrin2017, 0.20);
  const Vec3 centre = rhythm.position(direction(row.theta_deg * kDegree, 0.3));
  const Vec3 girdle = girdle_coordinates(centre);
  EXPECT_NEAR(girdle[0] / kDegree, row.phi_ed_deg, 1e-2);
  EXPECT_NEAR(girdle[1] / kDegree, row.phi_pr_deg, 1e-2);
  EXPECT_NEAR(girdle[2] / 0.20, row.length_ratio, 5e-4);
  const Vec3 displacement = centre - rhythm.position(Vec3::UnitZ());
  EXPECT_TRUE(near(displacement, 0.01 * row.displacement_cm, 1e-4));
}

INSTANTIATE_TEST_SUITE_P(Rows, PublishedCurve,
                         testing::Values(TableRow{0, 0.71, 0.00, 1.000, {0, 0, 0}},
                                         TableRow{30, 1.40, -4.04, 0.995, {-0.16, -1.40, 0.24}},
                                         TableRow{60, 10.01, -10.94, 0.960, {-1.43, -3.59, 3.09}},
                                         TableRow{90, 21.83, -19.13, 0.897, {-4.26, -5.46, 6.43}},
                                         TableRow{120, 32.51, -27.05, 0.806, {-7.90, -6.18, 8.41}},
                                         TableRow{150, 42.42, -33.12, 0.685, {-11.53, -5.53, 9.00}}));

TEST(Rhythm, PublishedCurveDipsAndStretchesWhereItsSourceSays) {
  // Quirks of the polynomials: least elevation -0.158 deg at 12.7 deg; longest d_SG 1.0014 d_0 at 9.4 deg.
  const Rhythm rhythm = rhythm_with(0.0);
  double least_ed = 1.0, at_ed = 0.0, longest = 0.0, at_length = 0.0;
  for (int k = 0; k <= 3000; ++k) {
    const double theta = 0.01 * k * kDegree;
    const Vec3 girdle = girdle_coordinates(rhythm.position(direction(theta, 0.0)));
    if (girdle[0] < least_ed) least_ed = girdle[0], at_ed = theta;
    if (girdle[2] > longest) longest = girdle[2], at_length = theta;
  }
  EXPECT_NEAR(least_ed / kDegree, -0.158, 1e-2);
  EXPECT_NEAR(at_ed / kDegree, 12.7, 0.1);
  EXPECT_NEAR(longest / kDistance, 1.0014, 5e-5);
  EXPECT_NEAR(at_length / kDegree, 9.4, 0.05);
}

// --- Derivatives ---------------------------------------------------------------------------------------------------

struct GreatCircle {
  Vec3 start, tangent;
  [[nodiscard]] Vec3 z(double s) const { return std::cos(s) * start + std::sin(s) * tangent; }
  [[nodiscard]] Vec3 dz(double s) const { return -std::sin(s) * start + std::cos(s) * tangent; }
};

/// d p_TS / ds along the circle from the model's first derivative.
Vec3 velocity(const Rhythm& rhythm, const GreatCircle& circle, double s) {
  RhythmJet jet;
  rhythm.evaluate(circle.z(s), jet);
  return jet.J_z * circle.dz(s);
}

/// d2 p_TS / ds2 at s = 0 from both derivatives of the model; z'' = -z.
Vec3 acceleration(const Rhythm& rhythm, const GreatCircle& circle) {
  RhythmJet jet;
  rhythm.evaluate(circle.start, jet);
  Vec3 out = jet.J_z * -circle.start;
  for (std::size_t i = 0; i < 3; ++i)
    out[static_cast<Eigen::Index>(i)] += circle.tangent.dot(jet.H_z[i] * circle.tangent);
  return out;
}

struct Difference {
  Vec3 value;
  double error;  ///< bound
};

/// Central difference of fourth order; the difference to twice the step is 15 times the truncation error that is left.
template <class Function>
Difference differentiate(const Function& f, double scale) {
  constexpr double h = 4e-4;
  const auto central = [&f](double step) -> Vec3 {
    return (8.0 * (f(step) - f(-step)) - (f(2.0 * step) - f(-2.0 * step))) / (12.0 * step);
  };
  const Vec3 fine = central(h);
  const double truncation = max_difference(fine, central(2.0 * h)) / 15.0;
  const double rounding = 16.0 * kEps * scale * 18.0 / (12.0 * h);  // f to 16 eps of its size; weights add up to 18
  return {fine, 4.0 * truncation + rounding};
}

struct DerivativeCase {
  double theta_rad;
  double smoothing_rad;
  RhythmModel model;
};

class RhythmDerivatives : public testing::TestWithParam<DerivativeCase> {};

TEST_P(RhythmDerivatives, AreThoseOfTheValue) {
  const DerivativeCase& c = GetParam();
  const Rhythm rhythm = rhythm_with(c.smoothing_rad, c.model);
  for (const double eta : {-2.0, 0.4}) {
    for (const double along : {0.0, 0.7, 0.5 * kPi}) {  // raising the arm, turning it sideways, and between
      const Vec3 up(std::sin(eta) * std::cos(c.theta_rad), -std::cos(eta) * std::cos(c.theta_rad),
                    -std::sin(c.theta_rad));
      const Vec3 sideways(std::cos(eta), std::sin(eta), 0.0);
      const GreatCircle circle{direction(c.theta_rad, eta), std::cos(along) * up + std::sin(along) * sideways};
      const Difference first = differentiate([&](double s) { return rhythm.position(circle.z(s)); }, kDistance);
      EXPECT_TRUE(near(velocity(rhythm, circle, 0.0), first.value, first.error));
      EXPECT_LT(first.error, 1e-7) << "the bound must be worth something: speeds are some 0.01 m/rad";
      const Difference second = differentiate([&](double s) { return velocity(rhythm, circle, s); }, 0.5 * kDistance);
      EXPECT_TRUE(near(acceleration(rhythm, circle), second.value, second.error));
      EXPECT_LT(second.error, 1e-5) << "the bound must be worth something: accelerations are some 0.1 m/rad^2";
    }
  }
}

std::vector<DerivativeCase> derivative_cases() {
  std::vector<DerivativeCase> cases;
  const double degrees_list[] = {5, 11.4, 11.5, 30, 34.3, 34.4, 60, 90, 120, 150};  // around the switches of the series
  for (const double smoothing : {0.05, 0.1, 0.3}) {
    for (const double theta : {0.0, 1e-8, 1e-5, 1e-3, 0.5 * smoothing, 6.0 * smoothing}) {
      cases.push_back({theta, smoothing, RhythmModel::SoltaniZarrin2017});
    }
    for (const double degrees : degrees_list) {
      cases.push_back({degrees * kDegree, smoothing, RhythmModel::SoltaniZarrin2017});
    }
  }
  for (const double degrees : degrees_list) {  // the bare polynomial has a cone at 0
    cases.push_back({degrees * kDegree, 0.0, RhythmModel::SoltaniZarrin2017});
    cases.push_back({degrees * kDegree, 0.1, RhythmModel::Measured});
    cases.push_back({degrees * kDegree, 0.1, RhythmModel::Fixed});
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Cases, RhythmDerivatives, testing::ValuesIn(derivative_cases()));

class RhythmSmoothness : public testing::TestWithParam<double> {};

TEST_P(RhythmSmoothness, NoStepAnywhereInTheValue) {
  // Second difference against h^2 p''. Left over: h^4 p''''/12, with p'''' of the size 50 d_0 slope/smoothing^3, slope 0.15,
  // and p to two roundings, with weights that add up to four.
  const double smoothing = GetParam();
  const Rhythm rhythm = rhythm_with(smoothing);
  constexpr double h = 2e-5;
  const double tolerance = std::pow(h, 4) * 50.0 * 0.15 * kDistance / std::pow(smoothing, 3) / 12.0 +
                           8.0 * kEps * kDistance;
  int worst_at = 0;
  double worst = 0.0;
  for (int k = 1; k < 100000; ++k) {  // to 2 rad: beyond the last switch of the series
    const GreatCircle circle{direction(k * h, 0.0), Vec3(0.0, -std::cos(k * h), -std::sin(k * h))};
    const Vec3 second = rhythm.position(circle.z(h)) - 2.0 * rhythm.position(circle.start) +
                        rhythm.position(circle.z(-h));
    const double excess = max_difference(second, h * h * acceleration(rhythm, circle));
    if (excess > worst) worst = excess, worst_at = k;
  }
  EXPECT_LE(worst, tolerance) << "at theta = " << worst_at * h;
}

TEST_P(RhythmSmoothness, NoStepInTheDerivativesWhereTheSeriesBeginAndEnd) {
  // Two angles 1e-12 apart on either side of a switch: the value moves with the speed; the derivatives change by 1e-12 times
  // the next one (at most some 1/smoothing^2 of them) and by rounding of closed forms that cancel to 1/300 there.
  const double smoothing = GetParam();
  const Rhythm rhythm = rhythm_with(smoothing);
  // the series' and, at quarters of powers of two of 1 - c and 1 + c, the table's
  for (const double theta : {0.5 * smoothing, 6.0 * smoothing, std::acos(0.98), std::acos(0.75), std::acos(0.6875),
                             std::acos(0.9375), 0.5 * kPi, std::acos(-0.25), std::acos(-0.8125)}) {
    const Vec3 z_below = direction(theta - 5e-13, 0.0), z_above = direction(theta + 5e-13, 0.0);
    RhythmJet below, above;
    rhythm.evaluate(z_below, below);
    rhythm.evaluate(z_above, above);
    EXPECT_TRUE(near(above.p_TS - below.p_TS, below.J_z * (z_above - z_below), 8.0 * kEps * kDistance)) << theta;
    const double first = below.J_z.cwiseAbs().maxCoeff();
    EXPECT_TRUE(near(below.J_z, above.J_z, 1e-10 * first)) << theta;
    for (std::size_t i = 0; i < 3; ++i) {
      const double second = below.H_z[i].cwiseAbs().maxCoeff();
      EXPECT_TRUE(near(below.H_z[i], above.H_z[i], 1e-9 * second + 1e-12)) << theta;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Smoothings, RhythmSmoothness, testing::Values(0.05, 0.1, 0.2, 0.3));

// --- Smoothing, gain, anchor ---------------------------------------------------------------------------------------

TEST(Rhythm, SmoothingMovesTheCentreByAtMostSixTenthsOfAMillimetre) {
  const Rhythm printed = rhythm_with(0.0), smooth = rhythm_with(0.1);
  double largest = 0.0;
  for (int k = 0; k <= 17500; ++k) {
    const Vec3 z = direction(0.01 * k * kDegree, 0.0);
    largest = std::max(largest, (printed.position(z) - smooth.position(z)).norm());
  }
  EXPECT_LE(largest, 0.6e-3);
  EXPECT_GE(largest, 0.5e-3) << "and this is what the documentation says it costs";
}

TEST(Rhythm, SmoothingEndsAtSixTimesItsWidth) {
  const Rhythm printed = rhythm_with(0.0), smooth = rhythm_with(0.1);
  for (const double theta : {0.601, 0.9, 1.5, 2.6}) {
    EXPECT_TRUE(near(smooth.position(direction(theta, 1.0)), printed.position(direction(theta, 1.0)), 1e-15));
  }
}

TEST(Rhythm, SmoothedCentreHasNoPreferredDirectionAtTheHangingArm) {
  RhythmJet jet;
  rhythm_with(0.1).evaluate(Vec3::UnitZ(), jet);
  EXPECT_LE((jet.J_z * Vec3::UnitX()).norm() + (jet.J_z * Vec3::UnitY()).norm(), 1e-18);
}

TEST(Rhythm, DependsOnElevationAlone) {
  Random random(1);
  for (const double smoothing : {0.0, 0.1}) {
    const Rhythm rhythm = rhythm_with(smoothing);
    for (int k = 0; k < test_count(10000); ++k) {
      const double theta = random.uniform(0.0, kPi);
      const Vec3 a = rhythm.position(direction(theta, random.uniform(-kPi, kPi)));
      ASSERT_TRUE(near(a, rhythm.position(direction(theta, 0.0)), 1e-15));
    }
  }
}

TEST(Rhythm, GainZeroIsTheFixedShoulder) {
  const Rhythm still({RhythmModel::SoltaniZarrin2017, 0.0, 0.1}, kDistance);
  const Rhythm fixed({RhythmModel::Fixed, 1.0, 0.1}, kDistance);
  Random random(2);
  for (int k = 0; k < 1000; ++k) {
    const Vec3 z = random.unit_vector();
    RhythmJet a, b;
    still.evaluate(z, a);
    fixed.evaluate(z, b);
    EXPECT_EQ(a.p_TS, b.p_TS);
    EXPECT_EQ(a.J_z, Mat3::Zero());
    EXPECT_EQ(b.J_z, Mat3::Zero());
    EXPECT_EQ(b.p_TS, fixed.position(Vec3::UnitZ()));
  }
}

class RhythmOfModel : public testing::TestWithParam<RhythmModel> {};

TEST_P(RhythmOfModel, GainScalesTheDisplacementAndItsDerivatives) {
  Random random(3);
  const Rhythm one({GetParam(), 1.0, 0.1}, kDistance), more({GetParam(), 1.3, 0.1}, kDistance);
  const Vec3 rest = one.position(Vec3::UnitZ());
  EXPECT_TRUE(near(more.position(Vec3::UnitZ()), rest, 1e-16)) << "gain leaves the rest where it is";
  for (int k = 0; k < 1000; ++k) {
    const Vec3 z = random.unit_vector();
    RhythmJet a, b;
    one.evaluate(z, a);
    more.evaluate(z, b);
    EXPECT_TRUE(near(b.p_TS - rest, 1.3 * (a.p_TS - rest), 1e-15));
    EXPECT_TRUE(near(b.J_z, 1.3 * a.J_z, 1e-14 * a.J_z.cwiseAbs().maxCoeff()));
  }
}

TEST_P(RhythmOfModel, ScalesWithTheShoulderDistance) {
  Random random(4);
  const Rhythm a({GetParam(), 1.0, 0.1}, 0.15), b({GetParam(), 1.0, 0.1}, 0.30);
  for (int k = 0; k < 1000; ++k) {
    const Vec3 z = random.unit_vector();
    EXPECT_TRUE(near(b.position(z), 2.0 * a.position(z), 1e-15));
  }
  EXPECT_NEAR(a.position(Vec3::UnitZ()).norm(), 0.15, 1e-15) << "d_0 is the distance at rest";
}

TEST_P(RhythmOfModel, AnchorMovesTheCentreAndKeepsTheMotion) {
  Random random(5);
  for (int k = 0; k < 1000; ++k) {
    const Rhythm free({GetParam(), 0.8, 0.1}, kDistance);
    Rhythm anchored = free;
    const Vec3 z0 = random.unit_vector(), measured = random.vector(0.3), z = random.unit_vector();
    anchored.anchor(z0, measured);
    EXPECT_TRUE(near(anchored.position(z0), measured, 1e-15));
    EXPECT_TRUE(near(anchored.position(z) - measured, free.position(z) - free.position(z0), 1e-15));
    RhythmJet a, b;
    free.evaluate(z, a);
    anchored.evaluate(z, b);
    EXPECT_EQ(a.J_z, b.J_z);
    anchored.anchor(z0, measured + Vec3(0.01, 0.0, 0.0));
    EXPECT_TRUE(near(anchored.position(z0), measured + Vec3(0.01, 0.0, 0.0), 1e-15)) << "anchoring again replaces";
  }
}

TEST_P(RhythmOfModel, IsFiniteForEveryDirection) {
  for (const double smoothing : {0.0, 0.1}) {
    const Rhythm rhythm({GetParam(), 1.5, smoothing}, kDistance);
    for (const double theta : {0.0, 1e-300, 1e-12, 1e-8, 1.0, kPi - 1e-8, kPi}) {
      for (const double scale : {1.0 - 4.0 * kEps, 1.0, 1.0 + 4.0 * kEps}) {  // unit vectors as rounding leaves them
        RhythmJet jet;
        rhythm.evaluate(scale * direction(theta, 0.5), jet);
        EXPECT_TRUE(jet.p_TS.allFinite() && jet.J_z.allFinite()) << theta;
        for (const Mat3& H : jet.H_z) EXPECT_TRUE(H.allFinite()) << theta;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Models, RhythmOfModel,
                         testing::Values(RhythmModel::Fixed, RhythmModel::SoltaniZarrin2017, RhythmModel::Measured));

TEST(Rhythm, RaisingTheArmRaisesTheShoulder) {
  for (const RhythmModel model : {RhythmModel::SoltaniZarrin2017, RhythmModel::Measured}) {
    const Rhythm rhythm = rhythm_with(0.1, model);
    for (const double eta : {-0.5 * kPi, 0.0}) {  // abduction, flexion
      EXPECT_GT(rhythm.position(direction(0.5 * kPi, eta)).z(), rhythm.position(Vec3::UnitZ()).z() + 0.01);
    }
  }
}

// --- Girdle coordinates --------------------------------------------------------------------------------------------

TEST(GirdleCoordinates, AndCentreAreInverse) {
  Random random(6);
  for (int k = 0; k < test_count(100000); ++k) {
    const Vec3 girdle(random.uniform(-1.5, 1.5), random.uniform(-3.1, 3.1), random.uniform(0.05, 0.4));
    // phi_pr is ill-conditioned by 1/cos(phi_ed).
    ASSERT_TRUE(near(girdle_coordinates(girdle_centre(girdle)), girdle, 8.0 * kEps / std::cos(girdle[0])));
  }
}

TEST(GirdleCoordinates, ElevationIsUpAndProtractionIsForward) {
  EXPECT_TRUE(near(girdle_centre({0.0, 0.0, 0.2}), Vec3(0.2, 0.0, 0.0), 1e-16));
  EXPECT_GT(girdle_centre({0.1, 0.0, 0.2}).z(), 0.0);
  EXPECT_GT(girdle_centre({0.0, 0.1, 0.2}).y(), 0.0);
}

// --- Bad input -----------------------------------------------------------------------------------------------------

struct BadRhythm {
  const char* what;
  RhythmSettings settings;
  double distance_m;
};

class RhythmRefuses : public testing::TestWithParam<BadRhythm> {};

TEST_P(RhythmRefuses, WithItsName) {
  const std::string text = refusal([] { Rhythm(GetParam().settings, GetParam().distance_m); });
  EXPECT_TRUE(contains(text, GetParam().what)) << "said: " << text;
  EXPECT_TRUE(contains(text, ": must")) << "said: " << text;
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr RhythmModel kModel = RhythmModel::SoltaniZarrin2017;

INSTANTIATE_TEST_SUITE_P(Each, RhythmRefuses,
                         testing::Values(BadRhythm{"rhythm.gain", {kModel, -0.1, 0.1}, 0.17},
                                         BadRhythm{"rhythm.gain", {kModel, 1.6, 0.1}, 0.17},
                                         BadRhythm{"rhythm.gain", {kModel, kNaN, 0.1}, 0.17},
                                         BadRhythm{"rhythm.smoothing", {kModel, 1.0, -0.1}, 0.17},
                                         BadRhythm{"rhythm.smoothing", {kModel, 1.0, 0.31}, 0.17},
                                         BadRhythm{"rhythm.smoothing", {kModel, 1.0, kNaN}, 0.17},
                                         BadRhythm{"rhythm.model", {static_cast<RhythmModel>(0), 1.0, 0.1}, 0.17},
                                         BadRhythm{"rhythm.model", {static_cast<RhythmModel>(4), 1.0, 0.1}, 0.17},
                                         BadRhythm{"shoulder distance", {kModel, 1.0, 0.1}, 0.0},
                                         BadRhythm{"shoulder distance", {kModel, 1.0, 0.1}, kNaN}));

}  // namespace
}  // namespace glenoid::test
