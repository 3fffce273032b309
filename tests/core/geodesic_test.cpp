// Laws of geodesics; docs/equations.md, G1-G6. The reference quantities come from the metric in body rates (M3), from finite
// differences and from CVODE, never from the solver's own embedding.
#include "glenoid/geodesic.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <thread>
#include <vector>

#include "glenoid/geodesic_ivp.hpp"
#include "path_probe.hpp"

namespace glenoid::test {
namespace {

/// A random pair of postures inside the limits whose geodesic converges spectrally at the tight tolerance.
struct Pair {
  ArmModel arm;
  Posture start, end;
};

Pair random_pair(std::uint64_t index) {
  TaskRandom random(test_seed(), index);
  Pair out{random_arm(random), {}, {}};
  out.start = random_posture(out.arm.limits, random);
  out.end = random_posture(out.arm.limits, random);
  if (index % 5 == 0) {
    const Vec4 angles = limited_angles(out.start);
    out.start = posture_from_angles(Vec4(0.0, 0.3, angles[kLimitTau] - 0.3, out.start.phi));
  }
  return out;
}

class RandomGeodesic : public testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    pair_ = random_pair(static_cast<std::uint64_t>(GetParam()));
    ASSERT_EQ(solve_tightly(solver_, pair_.arm, pair_.start, pair_.end, path_, certificate_), Status::Ok);
  }

  /// Interpolation error of first derivatives: the tail times the Markov factor N^2 of a derivative, plus rounding alike.
  [[nodiscard]] double rate_error() const {
    return path_.order * path_.order * (certificate_.spectral_tail + 1e-15 * path_.order);
  }

  testing::ScopedTrace trace_{__FILE__, __LINE__, replay(static_cast<std::uint64_t>(GetParam()))};
  Pair pair_;
  GeodesicSolver solver_;
  GeodesicPath path_;
  Certificate certificate_;
};

INSTANTIATE_TEST_SUITE_P(Pairs, RandomGeodesic, testing::Range(0, std::min(test_count(40), 400)));

TEST_P(RandomGeodesic, JoinsItsEnds) {
  EXPECT_LT(posture_distance(path_.nodes[0], pair_.start), 1e-14);
  EXPECT_LT(posture_distance(path_end(path_), pair_.end), 1e-14);
}

// What the last step leaves is its square after a full step, and less than a tenth of it after a step with an earlier factor,
// which is taken to 1e-7 rad. Stiffness of the grid times metric is below 1e3; rounding of the gradient is that stiffness
// times 1e-16 per node, summed over the nodes.
TEST_P(RandomGeodesic, LastStepLeavesNextToNothing) {
  if (!certificate_.hessian_positive) GTEST_SKIP() << "Gauss-Newton steps converge linearly";
  const double step = certificate_.newton_step_rad;
  EXPECT_LT(step, 1e-6);
  EXPECT_LT(certificate_.gradient, 1e3 * (step < 1e-7 ? 0.1 * step : step * step) + 1e-11);
}

TEST_P(RandomGeodesic, HasConstantKineticEnergy) {
  double least = 1e300, most = 0.0;
  for (int i = 0; i <= 200; ++i) {
    const double energy = energy_at(pair_.arm, path_, i / 200.0);
    least = std::min(least, energy);
    most = std::max(most, energy);
  }
  const double tolerance = std::max(1e-8, 10.0 * rate_error());
  EXPECT_LT(most - least, tolerance * path_.energy);
  EXPECT_NEAR(0.5 * (most + least), path_.energy, tolerance * path_.energy);
}

TEST_P(RandomGeodesic, ReversedIsTheGeodesicOfTheReversedEnds) {
  GeodesicPath back;
  Certificate certificate;
  ASSERT_EQ(solve_tightly(solver_, pair_.arm, pair_.end, pair_.start, back, certificate), Status::Ok);
  if (certificate.long_way != certificate_.long_way) GTEST_SKIP() << "other class converged";
  EXPECT_NEAR(back.energy, path_.energy, 1e-10 * path_.energy);
  const double tolerance = std::max(1e-9, 10.0 * (certificate.spectral_tail + certificate_.spectral_tail));
  for (int i = 0; i <= 20; ++i) {
    EXPECT_LT(posture_distance(path_posture(path_, i / 20.0), path_posture(back, 1.0 - i / 20.0)), tolerance) << i;
  }
}

TEST_P(RandomGeodesic, ShotWithItsOwnRatesArrives) {
  PostureJet jet;
  evaluate_path(path_, 0.0, jet);
  FollowResult shot;
  ASSERT_EQ(follow_geodesic(pair_.arm, pair_.start, as_rates(body_rates(jet)), {}, shot), Status::Ok);
  EXPECT_LT(shot.energy_drift, 1e-8);
  // Between conjugate points an error of the initial rates grows by at most the inverse of the least Jacobi field; 1e-7 is the
  // promise, wherever the path itself is resolved.
  const double tolerance = std::max(1e-7, 100.0 * rate_error());
  EXPECT_LT(posture_distance(shot.postures.back(), pair_.end), tolerance);
  for (int i = 0; i <= 100; i += 10) {
    EXPECT_LT(posture_distance(shot.postures[static_cast<std::size_t>(i)], path_posture(path_, i / 100.0)), tolerance)
        << i;
  }
}

// First variation: dE/dq1 = p(1) and dE/dq0 = -p(0). Central difference of converged energies with step h:
// truncation h^2 E'''/6, rounding eps E/h; with h = 1e-4 both are near 1e-8 E.
TEST_P(RandomGeodesic, EnergyGradientAtTheEndsIsTheMomentum) {
  if (!certificate_.hessian_positive) GTEST_SKIP() << "not a strict minimum: the energy need not be differentiable";
  constexpr double h = 1e-4;
  const Vec4 p0 = momentum_at(pair_.arm, path_, 0.0), p1 = momentum_at(pair_.arm, path_, 1.0);
  const double scale = std::max(p0.norm(), p1.norm()) + path_.energy;
  for (int k = 0; k < 4; ++k) {
    double at_end[2], at_start[2];
    for (const int side : {0, 1}) {
      const Vec4 step = (side ? h : -h) * Vec4::Unit(k);
      GeodesicPath path;
      Certificate certificate;
      ASSERT_EQ(solve_tightly(solver_, pair_.arm, pair_.start, displaced(pair_.end, step), path, certificate),
                Status::Ok);
      at_end[side] = path.energy;
      ASSERT_EQ(solve_tightly(solver_, pair_.arm, displaced(pair_.start, step), pair_.end, path, certificate),
                Status::Ok);
      at_start[side] = path.energy;
    }
    const double tolerance = std::max(1e-6, 10.0 * rate_error()) * scale;
    EXPECT_NEAR((at_end[1] - at_end[0]) / (2.0 * h), p1[k], tolerance) << k;
    EXPECT_NEAR((at_start[1] - at_start[0]) / (2.0 * h), -p0[k], tolerance) << k;
  }
}

/// E of the path bent by b(lambda) = a sin(m pi lambda) in the tangent direction xi, by the composite Gauss rule.
double bent_energy(const ArmModel& arm, const GeodesicPath& path, const Vec4& xi, int m, double a) {
  constexpr int kCells = 60;
  constexpr double kPoint = 0.7745966692414834, kSide = 5.0 / 18.0, kMiddle = 8.0 / 18.0;
  double energy = 0.0;
  for (int cell = 0; cell < kCells; ++cell) {
    for (const int point : {-1, 0, 1}) {
      const double lambda = (cell + 0.5 + 0.5 * kPoint * point) / kCells;
      PostureJet jet;
      evaluate_path(path, lambda, jet);
      const double b = a * std::sin(m * kPi * lambda), db = a * m * kPi * std::cos(m * kPi * lambda);
      Vec4 v = body_rates(jet);
      v.head<3>() = rotation(-b * xi.head<3>()) * v.head<3>();  // R exp(b xi): w -> exp(-b xi) w + b' xi
      v += db * xi;
      const Posture posture = displaced(path_posture(path, lambda), b * xi);
      energy += (point ? kSide : kMiddle) / kCells * 0.5 * v.dot(body_mass_matrix(arm, posture) * v);
    }
  }
  return energy;
}

// E(a) = E0 + a E1 + a^2 E2/2: E1 = 0 (a geodesic), E2 > 0 where the certificate says so.
TEST_P(RandomGeodesic, IsStationaryAndMinimalAgainstBentPaths) {
  TaskRandom random(test_seed() + 1, static_cast<std::uint64_t>(GetParam()));
  constexpr double a = 1e-3;
  const double straight = bent_energy(pair_.arm, path_, Vec4::Zero(), 1, 0.0);
  EXPECT_NEAR(straight, path_.energy, std::max(1e-9, 10.0 * rate_error()) * path_.energy);
  for (int m = 1; m <= 4; ++m) {
    Vec4 xi;
    for (int k = 0; k < 4; ++k) xi[k] = random.uniform(-1.0, 1.0);
    const double up = bent_energy(pair_.arm, path_, xi, m, a), down = bent_energy(pair_.arm, path_, xi, m, -a);
    const double second = (up - 2.0 * straight + down) / (a * a);
    // The central difference leaves a^2/6 of the third derivative, which is of the size of the second.
    EXPECT_NEAR((up - down) / (2.0 * a), 0.0, 10.0 * a * a * (std::abs(second) + path_.energy) + 10.0 * rate_error())
        << m;
    if (certificate_.hessian_positive) {
      EXPECT_GT(second, 0.0) << m;
    }
  }
}

/// Whether a path turns the long way round: lifts it to unit quaternions by small steps and looks at the sign at the end.
bool turns_long_way(const GeodesicPath& path) {
  Eigen::Vector4d q(1.0, 0.0, 0.0, 0.0);  // w, x, y, z
  Mat3 before = path_posture(path, 0.0).R_TU;
  for (int i = 1; i <= 400; ++i) {
    const Mat3 after = path_posture(path, i / 400.0).R_TU;
    const Mat3 step = before.transpose() * after;
    const Vec3 v = 0.25 * Vec3(step(2, 1) - step(1, 2), step(0, 2) - step(2, 0), step(1, 0) - step(0, 1));
    const double w = std::sqrt(1.0 - v.squaredNorm());
    const Vec3 u = q.tail<3>();
    const Vec3 next = q[0] * v + w * u + u.cross(v);
    q << q[0] * w - u.dot(v), next;
    before = after;
  }
  return q[0] < 0.0;
}

TEST_P(RandomGeodesic, NamesItsHomotopyClassTruthfully) {
  const double angle = rotation_distance(pair_.start.R_TU, pair_.end.R_TU);
  EXPECT_NEAR(certificate_.rotation_angle_rad, angle, 1e-7);
  if (angle > kPi - 1e-3) GTEST_SKIP() << "both ways are equally long";
  EXPECT_EQ(certificate_.long_way, turns_long_way(path_));
}

TEST_P(RandomGeodesic, IsTheCheaperOfBothClassesWhereTheRotationIsWide) {
  GeodesicOptions round;
  round.long_way = true;
  GeodesicPath other, cheapest;
  Certificate certificate;
  const Status status = solver_.solve(pair_.arm, pair_.start, pair_.end, round, nullptr, other, certificate);
  if (status == Status::Ok && certificate_.rotation_angle_rad < kPi - 1e-3) {
    EXPECT_EQ(certificate.long_way, turns_long_way(other));
  }
  ASSERT_EQ(solver_.solve_cheapest(pair_.arm, pair_.start, pair_.end, {}, cheapest, certificate), Status::Ok);
  const bool wide = certificate_.rotation_angle_rad > kWideRotation && status == Status::Ok;
  const double least = wide ? std::min(path_.energy, other.energy) : path_.energy;
  EXPECT_NEAR(cheapest.energy, least, 1e-8 * least);
}

TEST_P(RandomGeodesic, IsTheSameBitForBitWhateverWasSolvedBefore) {
  GeodesicSolver fresh;
  GeodesicPath other, again;
  Certificate certificate;
  const Pair distraction = random_pair(static_cast<std::uint64_t>(GetParam()) + 1000);
  (void)fresh.solve(distraction.arm, distraction.start, distraction.end, {}, nullptr, other, certificate);
  ASSERT_EQ(solve_tightly(fresh, pair_.arm, pair_.start, pair_.end, again, certificate), Status::Ok);
  ASSERT_EQ(again.order, path_.order);
  const auto bytes = sizeof(Posture) * static_cast<std::size_t>(path_.order + 1);
  EXPECT_EQ(std::memcmp(again.nodes.data(), path_.nodes.data(), bytes), 0);
  EXPECT_EQ(again.energy, path_.energy);
}

TEST_P(RandomGeodesic, WithDefaultOptionsStaysWithinItsToleranceOfTheTightOne) {
  GeodesicPath path;
  Certificate certificate;
  ASSERT_EQ(solver_.solve(pair_.arm, pair_.start, pair_.end, {}, nullptr, path, certificate), Status::Ok);
  if (certificate.spectral_tail > GeodesicOptions{}.tail_tolerance) GTEST_SKIP() << "largest order does not suffice";
  double worst = 0.0;
  for (int i = 0; i <= 50; ++i) {
    worst = std::max(worst, posture_distance(path_posture(path, i / 50.0), path_posture(path_, i / 50.0)));
  }
  EXPECT_LT(worst, 10.0 * GeodesicOptions{}.tail_tolerance);
  EXPECT_NEAR(path.energy, path_.energy, 1e-8 * path_.energy);
}

TEST(Geodesic, ReproducesThePublishedCheckCase) {
  // Energies of an independent solver (collocation in the Euler chart), given to six digits: half a unit of the last. The one with the moving
  // shoulder was used to reconstruct the rhythm's coefficients, so only the other one is an independent check.
  RhythmSettings settings;
  settings.smoothing_rad = 0.0;
  const Posture start = posture_deg(25.0, -15.0, 15.0, 80.0), end = posture_deg(104.9, -8.6, 4.6, 27.1);
  GeodesicSolver solver;
  GeodesicPath path;
  Certificate certificate;
  ASSERT_EQ(solve_tightly(solver, default_arm(settings, true), start, end, path, certificate), Status::Ok);
  EXPECT_NEAR(path.energy, 0.295256, 0.6e-6);
  ASSERT_EQ(solve_tightly(solver, default_arm(settings, false), start, end, path, certificate), Status::Ok);
  EXPECT_NEAR(path.energy, 0.226606, 0.6e-6);
}

/// A metric in which closed forms exist: gyration only, U with second moment j on each axis, F with k on y and z (E2).
ArmModel gyrating_arm(double j, double k) {
  RhythmSettings settings;
  settings.model = RhythmModel::Fixed;
  ArmModel arm = default_arm(settings, false);
  arm.mass.setZero();
  arm.mass.diagonal() << 0.0, j + k, j, j, k, k;
  return arm;
}

TEST(Geodesic, OfAGyrostatAboutTheElbowAxisIsTheOneParameterGroup) {
  // About x everything commutes: E = j a^2 + k (a + dphi)^2 and the path is R0 exp(lambda a e_x), phi linear.
  constexpr double j = 0.3, k = 0.2, a = 0.7, dphi = 0.5;
  const Posture start = posture_deg(40.0, -20.0, 10.0, 30.0);
  const Posture end = displaced(start, Vec4(a, 0.0, 0.0, dphi));
  GeodesicSolver solver;
  GeodesicPath path;
  Certificate certificate;
  ASSERT_EQ(solve_tightly(solver, gyrating_arm(j, k), start, end, path, certificate), Status::Ok);
  EXPECT_NEAR(path.energy, j * a * a + k * (a + dphi) * (a + dphi), 1e-12);
  for (const double lambda : {0.1, 0.5, 0.8}) {
    EXPECT_LT(posture_distance(path_posture(path, lambda), displaced(start, lambda * Vec4(a, 0.0, 0.0, dphi))), 1e-10);
  }
}

TEST(Geodesic, OfAGyrostatAcrossTheElbowAxisIsTheOneParameterGroup) {
  // Axes normal to x are principal: E = (j + k) a^2 with the elbow at rest.
  constexpr double j = 0.3, k = 0.2, a = 0.9;
  const Vec3 axis = Vec3(0.0, 0.6, 0.8);
  const Posture start = posture_deg(0.0, 0.0, 20.0, 50.0);
  Vec4 tangent = Vec4::Zero();
  tangent.head<3>() = a * axis;
  GeodesicSolver solver;
  GeodesicPath path;
  Certificate certificate;
  ASSERT_EQ(solve_tightly(solver, gyrating_arm(j, k), start, displaced(start, tangent), path, certificate), Status::Ok);
  EXPECT_NEAR(path.energy, (j + k) * a * a, 1e-12);
  EXPECT_LT(posture_distance(path_posture(path, 0.3), displaced(start, 0.3 * tangent)), 1e-10);
}

TEST(Geodesic, OfPureAxialRotationOfTheStraightArmTurnsUniformly) {
  constexpr double angle = 0.5;  // well before the first conjugate point
  const ArmModel arm = default_arm();
  const Posture start = posture_deg(70.0, -30.0, 10.0, 0.0);
  GeodesicSolver solver;
  GeodesicPath path;
  Certificate certificate;
  const Vec4 turn(0.0, 0.0, angle, 0.0);
  ASSERT_EQ(solve_tightly(solver, arm, start, displaced(start, turn), path, certificate), Status::Ok);
  const double inertia = arm.upper_arm.inertia_kg_m2.z() + arm.forearm.inertia_kg_m2.z();
  EXPECT_NEAR(path.energy, 0.5 * inertia * angle * angle, 1e-12);
  EXPECT_LT(posture_distance(path_posture(path, 0.4), displaced(start, 0.4 * turn)), 1e-9);
}

TEST(Geodesic, OfABalancedForearmIsPureElbowFlexion) {
  // With the forearm's centre of mass at the elbow and a fixed shoulder the sagittal metric is flat: E = 1/2 I dphi^2.
  RhythmSettings settings;
  settings.model = RhythmModel::Fixed;
  ScaledArm scaled = scale_subject(Subject{});
  scaled.forearm.com_m = 1e-12;
  const ArmModel arm = make_arm_model(scaled, Rhythm(settings, scaled.shoulder_distance_m), {}, false);
  const Posture start = posture_deg(0.0, 0.0, 0.0, 20.0), end = posture_deg(0.0, 0.0, 0.0, 110.0);
  GeodesicSolver solver;
  GeodesicPath path;
  Certificate certificate;
  ASSERT_EQ(solve_tightly(solver, arm, start, end, path, certificate), Status::Ok);
  const double dphi = 90.0 * kDegree;
  EXPECT_NEAR(path.energy, 0.5 * arm.forearm.inertia_kg_m2.x() * dphi * dphi, 1e-11);
  EXPECT_LT(posture_distance(path_posture(path, 0.25), posture_deg(0.0, 0.0, 0.0, 42.5)), 1e-9);
}

TEST(Geodesic, FromTheHangingArmDoesNotDependOnItsUndefinedPlane) {
  const ArmModel arm = default_arm();
  const Posture end = posture_deg(80.0, -20.0, 25.0, 60.0);
  GeodesicSolver solver;
  GeodesicPath first, other;
  Certificate certificate;
  ASSERT_EQ(solve_tightly(solver, arm, posture_deg(0.0, 0.0, 15.0, 40.0), end, first, certificate), Status::Ok);
  for (const double eta : {-130.0, -60.0, 33.0, 179.0}) {
    ASSERT_EQ(solve_tightly(solver, arm, posture_deg(0.0, eta, 15.0 - eta, 40.0), end, other, certificate), Status::Ok);
    EXPECT_NEAR(other.energy, first.energy, 1e-12);
    for (const double lambda : {0.1, 0.5, 0.9}) {
      EXPECT_LT(posture_distance(path_posture(other, lambda), path_posture(first, lambda)), 1e-10) << eta;
    }
  }
}

TEST(Geodesic, OfAFixedShoulderCommutesWithRotationsOfSpaceAndConservesAngularMomentum) {
  RhythmSettings settings;
  settings.model = RhythmModel::Fixed;
  const ArmModel arm = default_arm(settings);
  const Posture start = posture_deg(20.0, -40.0, 30.0, 70.0), end = posture_deg(95.0, 10.0, -20.0, 30.0);
  const Mat3 turn = rotation(Vec3(0.4, -0.9, 1.3));
  GeodesicSolver solver;
  GeodesicPath path, turned;
  Certificate certificate;
  ASSERT_EQ(solve_tightly(solver, arm, start, end, path, certificate), Status::Ok);
  ASSERT_EQ(solve_tightly(solver, arm, {turn * start.R_TU, start.phi}, {turn * end.R_TU, end.phi}, turned, certificate),
            Status::Ok);
  EXPECT_NEAR(turned.energy, path.energy, 1e-11);
  const Vec3 momentum = start.R_TU * momentum_at(arm, path, 0.0).head<3>();
  for (const double lambda : {0.2, 0.5, 0.75, 1.0}) {
    const Posture expected = path_posture(path, lambda);
    EXPECT_LT(posture_distance(path_posture(turned, lambda), {turn * expected.R_TU, expected.phi}), 1e-9);
    EXPECT_LT((expected.R_TU * momentum_at(arm, path, lambda).head<3>() - momentum).norm(), 1e-8);
  }
}

class NearlyNoMotion : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Sizes, NearlyNoMotion, testing::Values(0.0, 1e-12, 1e-8, 1e-5, 1e-3));

TEST_P(NearlyNoMotion, HasTheEnergyOfItsChordAndNoNan) {
  const ArmModel arm = default_arm();
  for (const double theta : {0.0, 60.0}) {
    const Posture start = posture_deg(theta, -20.0, 20.0, 50.0);
    const Vec4 chord = GetParam() * Vec4(0.5, -0.3, 0.7, 0.4);
    GeodesicSolver solver;
    GeodesicPath path;
    Certificate certificate;
    ASSERT_EQ(solver.solve(arm, start, displaced(start, chord), {}, nullptr, path, certificate), Status::Ok);
    const double energy = 0.5 * chord.dot(body_mass_matrix(arm, displaced(start, 0.5 * chord)) * chord);
    // Rounding of the nodes is r = 1e-16, so the chord is known to that, and the stiffness of the grid (below 1e3) makes
    // at most 1e3 r^2 of it when nothing moves; curvature adds the fourth order.
    EXPECT_NEAR(path.energy, energy, 10.0 * chord.norm() * 1e-16 + 1e-29 + energy * chord.squaredNorm());
    EXPECT_GE(path.energy, 0.0);
    EXPECT_TRUE(std::isfinite(certificate.speed_variation));
    EXPECT_TRUE(std::isfinite(certificate.transversality));
  }
}

TEST(Geodesic, RefusesWhatIsNotFinite) {
  const ArmModel arm = default_arm();
  const Posture good = posture_deg(30.0, 0.0, 0.0, 40.0);
  GeodesicSolver solver;
  GeodesicPath path;
  Certificate certificate;
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    Posture broken = good;
    broken.phi = bad;
    EXPECT_EQ(solver.solve(arm, broken, good, {}, nullptr, path, certificate), Status::NotFinite);
    EXPECT_EQ(solver.solve(arm, good, broken, {}, nullptr, path, certificate), Status::NotFinite);
    broken = good;
    broken.R_TU(1, 2) = bad;
    EXPECT_EQ(solver.solve(arm, broken, good, {}, nullptr, path, certificate), Status::NotFinite);
    EXPECT_EQ(solver.solve_free_end(arm, good, broken, Vec3(0.2, 0.4, 0.1), {}, nullptr, path, certificate),
              Status::NotFinite);
    EXPECT_EQ(solver.solve_free_end(arm, good, good, Vec3(bad, 0.4, 0.1), {}, nullptr, path, certificate),
              Status::NotFinite);
  }
}

TEST(Geodesic, GivesTheSameInSeveralThreadsWithSeparateSolvers) {
  constexpr int kTasks = 30;
  const auto solve_all = [](std::vector<double>& energies) {
    GeodesicSolver solver;
    GeodesicPath path;
    Certificate certificate;
    for (int i = 0; i < kTasks; ++i) {
      const Pair pair = random_pair(static_cast<std::uint64_t>(i));
      const Status status = solver.solve(pair.arm, pair.start, pair.end, {}, nullptr, path, certificate);
      energies.push_back(status == Status::Ok ? path.energy : -1.0);
    }
  };
  std::vector<double> first, second;
  std::thread one([&] { solve_all(first); }), two([&] { solve_all(second); });
  one.join();
  two.join();
  EXPECT_EQ(first, second);
}

TEST(FollowGeodesic, WithoutRatesStays) {
  const Posture start = posture_deg(0.0, 0.0, 30.0, 40.0);
  FollowResult out;
  ASSERT_EQ(follow_geodesic(default_arm(), start, {}, {}, out), Status::Ok);
  EXPECT_LT(posture_distance(out.postures.back(), start), 1e-15);
}

TEST(FollowGeodesic, RefusesBadArguments) {
  const ArmModel arm = default_arm();
  const Posture start = posture_deg(30.0, 0.0, 30.0, 40.0);
  FollowResult out;
  FollowOptions options;
  options.samples = 1;
  EXPECT_EQ(follow_geodesic(arm, start, {}, options, out), Status::OutOfRange);
  EXPECT_EQ(follow_geodesic(arm, start, {Vec3(0.0, std::nan(""), 0.0), 0.0}, {}, out), Status::NotFinite);
}

}  // namespace
}  // namespace glenoid::test
