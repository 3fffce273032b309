#include "glenoid/exoskeleton.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "exo_probe.hpp"
#include "glenoid/kinematics.hpp"
#include "support/arms.hpp"
#include "support/environment.hpp"
#include "support/matchers.hpp"

namespace glenoid::test {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();
const Vec3 kCentre(0.17, -0.02, 0.01);

ExoBranch random_branch(Random& random) {
  return random.uniform(0.0, 1.0) < 0.5 ? ExoBranch::First : ExoBranch::Second;
}

/// Reachability by the algebraic condition |K| <= rho instead of by angles; how far inside, in units of K.
double algebraic_slack(const ExoSettings& device, const Mat3& R_star) {
  const Vec3 &a1 = device.axes[0], &a2 = device.axes[1], &a3 = device.axes[2];
  const double A = a1.dot(a3) - a1.dot(a2) * a2.dot(a3), B = a1.dot(a2.cross(a3));
  return std::hypot(A, B) - std::abs(a1.dot(R_star * a3) - a1.dot(a2) * a2.dot(a3));
}

Mat3 base_of(const ExoSettings& device, const Vec3& girdle) {
  const Mat3 B = turn(device.base);
  return device.base_follows_girdle ? Mat3(girdle_turn(device.girdle_order, girdle[0], girdle[1]) * B) : B;
}

PointJet fixed_point(const Vec3& p) { return {p, Vec3::Zero(), Vec3::Zero()}; }

PostureJet at_rest(const Posture& posture) {
  const Vec3 o = Vec3::Zero();
  return {posture.R_TU.col(0), o, o, posture.R_TU.col(2), o, o, posture.phi, 0.0, 0.0};
}

bool finite(const ExoSample& s) {
  return s.q.allFinite() && s.dq.allFinite() && s.ddq.allFinite() && s.length_m.allFinite() &&
         std::isfinite(s.residual_m + s.margin_rad + s.singularity_rad + s.axis_angle_rad + s.axis_angle_rate);
}

TEST(Transformation, ReproducesTheUpperArmForAnyAxesMountsAndPosturesInBothBranchesOrReportsThatItCannot) {
  Random random(1);
  const int count = test_count(1'000'000);
  int feasible = 0, infeasible = 0;
  for (int k = 0; k < count; ++k) {
    const ExoSettings device = random_device(random);
    const Vec3 centre = random_centre(random), near_q = random.vector(4.0);
    const Mat3 R_TU = random.rotation();
    const ExoModel model(device, kCentre);
    ExoSample out;
    const Status status = map_to_exo(model, random_branch(random), at_rest({R_TU, 0.7}), fixed_point(centre), near_q,
                                     out);
    ASSERT_TRUE(finite(out)) << "case " << k;
    const Mat3 R_star = base_of(device, {out.q[0], out.q[1], 0.0}).transpose() * R_TU * turn(device.cuff).transpose();
    const double slack = algebraic_slack(device, R_star);
    if (std::abs(slack) > 1e-13) {  // K is known to a few eps; nearer to the edge the two conditions need not agree
      ASSERT_EQ(status, slack > 0.0 ? Status::Ok : Status::ExoInfeasible) << "case " << k << ", slack " << slack;
    }
    ASSERT_EQ(status == Status::ExoInfeasible, out.margin_rad < -1e-12) << "case " << k;
    (status == Status::Ok ? feasible : infeasible) += 1;
    if (status != Status::Ok) continue;
    ASSERT_LE(max_difference(device_pose(device, out.q), R_TU), 1e-12) << "case " << k;
    ASSERT_LE((out.q.segment<3>(kShoulder1) - near_q).cwiseAbs().maxCoeff(), kPi * (1.0 + 4.0 * kEps)) << "case " << k;
    ASSERT_EQ(out.q[kElbow], 0.7);
  }
  EXPECT_GT(feasible, count / 4);
  EXPECT_GT(infeasible, count / 10);
}

TEST(Transformation, ForwardKinematicsAgreesWithTheProductOfTheJoints) {
  Random random(2);
  for (int k = 0; k < test_count(1000); ++k) {
    const ExoSettings device = random_device(random);
    const ExoModel model(device, kCentre);
    Vec6 q;
    q << random.vector(3.0), random.vector(3.0);
    ASSERT_LE(max_difference(exo_upper_arm(model, q), device_pose(device, q)), 32.0 * kEps) << "case " << k;
  }
}

TEST(Transformation, MarginIsTheLeastRotationToTheEdgeOfTheFeasibleSet) {
  Random random(3);
  const Vec3 zero = Vec3::Zero();
  for (int k = 0; k < test_count(20'000); ++k) {
    const ExoModel model(random_device(random), kCentre);
    const Mat3 R_TU = random.rotation(), R_TB = model.R_GB();
    ShoulderSolution here, there;
    const Status status = shoulder_joints(model, R_TB, R_TU, ExoBranch::First, zero, here);
    ASSERT_NE(status, Status::NotFinite);
    // No rotation by an angle changes the margin by more than that angle ...
    const Vec3 w = random.vector(0.5);
    static_cast<void>(shoulder_joints(model, R_TB, turn(w) * R_TU, ExoBranch::First, zero, there));
    ASSERT_LE(std::abs(there.margin_rad - here.margin_rad), w.norm() + 16.0 * kEps) << "case " << k;
    // ... and one by the margin, in the plane of the first and the third axis, arrives at the edge.
    const Vec3 a1 = R_TB * model.shoulder().a[0], t = R_TU * model.R_LU().transpose() * model.shoulder().a[2];
    const ShoulderGeometry& g = model.shoulder();
    const bool to_most = g.most - here.axis_angle_rad < here.axis_angle_rad - g.least;
    const Mat3 moved = turn(a1.cross(t), to_most ? here.margin_rad : -here.margin_rad) * R_TU;
    static_cast<void>(shoulder_joints(model, R_TB, moved, ExoBranch::First, zero, there));
    ASSERT_NEAR(there.margin_rad, 0.0, 32.0 * kEps / std::sin(here.axis_angle_rad)) << "case " << k;
    ASSERT_NEAR(algebraic_slack(model.settings(), R_TB.transpose() * moved * model.R_LU().transpose()), 0.0,
                64.0 * kEps);
  }
}

TEST(Transformation, SecondAxisNormalToBothReachesEveryOrientation) {
  Random random(4);
  for (int k = 0; k < test_count(50'000); ++k) {
    const ExoSettings device = random_davenport_device(random);
    const ExoModel model(device, kCentre);
    const Mat3 R_TU = random.rotation();
    ExoSample out;
    ASSERT_EQ(map_to_exo(model, random_branch(random), at_rest({R_TU, 0.0}), fixed_point(kCentre), Vec3::Zero(), out),
              Status::Ok)
        << "case " << k;
    ASSERT_LE(max_difference(device_pose(device, out.q), R_TU), 1e-12) << "case " << k;
  }
}

TEST(Transformation, IdentityDeviceGivesTheArmsOwnAngles) {
  Random random(5);
  const ExoModel model(ExoSettings(), kCentre);
  for (int k = 0; k < test_count(20'000); ++k) {
    Vec4 q = random_angles(random);
    q[kTheta] = random.log_uniform(1e-6, 3.1);
    const Vec3 expected(q[kEta], q[kTheta], q[kZeta]);
    ExoStart start;
    ASSERT_EQ(choose_branch(model, posture_from_angles(q), kCentre, std::nullopt, start), Status::Ok);
    ASSERT_EQ(start.branch, ExoBranch::First);
    // R holds sin(theta) eta to eps, so eta is known to eps/sin(theta)
    ASSERT_LE((start.shoulder_q - expected).cwiseAbs().maxCoeff(), 16.0 * kEps / std::sin(q[kTheta])) << "case " << k;
  }
}

class NearTheSingularSet : public testing::TestWithParam<double> {};

TEST_P(NearTheSingularSet, JointsReproduceTheArmAndEverythingIsFinite) {
  Random random(6);
  for (const ExoBranch branch : {ExoBranch::First, ExoBranch::Second}) {
    for (const double pole : {0.0, kPi}) {
      const ExoModel model(ExoSettings(), kCentre);
      const Vec3 near_q = random.vector(3.0);
      const double eta = random.uniform(-3.0, 3.0);
      PostureJet jet = at_rest(posture_from_angles({std::abs(pole - GetParam()), eta, 0.4, 0.5}));
      const Vec3 w = random.vector(2.0), alpha = random.vector(2.0);
      jet.dx = w.cross(jet.x), jet.ddx = alpha.cross(jet.x) + w.cross(jet.dx);
      jet.dz = w.cross(jet.z), jet.ddz = alpha.cross(jet.z) + w.cross(jet.dz);
      ExoSample out;
      ASSERT_EQ(map_to_exo(model, branch, jet, fixed_point(kCentre), near_q, out), Status::Ok);
      EXPECT_TRUE(finite(out));
      EXPECT_LE(max_difference(device_pose(ExoSettings(), out.q), rotation_of(jet)), 1e-12);
      EXPECT_NEAR(out.singularity_rad, GetParam(), 1e-15);
      if (GetParam() < 1e-13) {
        EXPECT_EQ(out.q[kShoulder1], near_q[0]);
        // least squares: the defined rotation is followed, and nothing turns about the shared axis in opposite senses
        EXPECT_NEAR(out.dq[kShoulder1], (pole == 0.0 ? 1.0 : -1.0) * out.dq[kShoulder3], 1e-9);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Distances, NearTheSingularSet,
                         testing::Values(0.0, 1e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1.1e-6, 1e-5, 1e-3));

/// Error bound of a central difference from two steps: the difference of the two is 3 h^2 f'''/6, and rounding of f.
Vec6 difference_bound(const Vec6& coarse, const Vec6& fine, double rounding, double h) {
  return (coarse - fine).cwiseAbs() + Vec6::Constant(rounding / h);
}

class Derivatives : public testing::TestWithParam<bool> {};

TEST_P(Derivatives, AreThoseOfTheJoints) {
  const bool skewed = GetParam();  // columns that are orthonormal to 1e-3 only, as an interpolated path's
  Random random(7);
  int used = 0;
  for (int k = 0; used < test_count(2000); ++k) {
    const ExoModel model(random_device(random, 0.3), kCentre);
    const SmoothMotion motion = SmoothMotion::random(random);
    const ExoBranch branch = random_branch(random);
    const double s = random.uniform(0.1, 0.9), h = 2e-5;
    const auto sample = [&](double at, ExoSample& out) {
      PostureJet jet;
      PointJet centre;
      motion.evaluate(at, jet, centre);
      if (skewed) {
        const double f = 1.0 + 1e-3 * at, g = 1e-3 * at;
        jet.ddx = f * jet.ddx + 2e-3 * jet.dx + 2e-3 * jet.dz + g * jet.ddz;
        jet.dx = f * jet.dx + 1e-3 * jet.x + 1e-3 * jet.z + g * jet.dz;
        jet.x = f * jet.x + g * jet.z;
        jet.ddz = f * jet.ddz + 2e-3 * jet.dz;
        jet.dz = f * jet.dz + 1e-3 * jet.z;
        jet.z *= f;
      }
      return map_to_exo(model, branch, jet, centre, Vec3::Zero(), out);
    };
    ExoSample here;
    if (sample(s, here) != Status::Ok || here.singularity_rad < 0.3 || here.margin_rad < 0.1) continue;
    if ((here.q.segment<3>(kShoulder1).cwiseAbs().array() > 3.0).any())
      continue;  // a turn would be counted off in between
    ExoSample m2, m1, p1, p2;
    ASSERT_TRUE(sample(s - 2 * h, m2) == Status::Ok && sample(s - h, m1) == Status::Ok);
    ASSERT_TRUE(sample(s + h, p1) == Status::Ok && sample(s + 2 * h, p2) == Status::Ok);
    ++used;
    // q is known to a few eps over the sines of axis angle and joint 2 (>= 0.1 * 0.3); rates to that times the rates
    const double rounding = 100.0 * kEps / 0.03,
                 rates = 1.0 + here.dq.cwiseAbs().maxCoeff() + here.ddq.cwiseAbs().maxCoeff();
    const Vec6 dq = (p1.q - m1.q) / (2 * h), dq2 = (p2.q - m2.q) / (4 * h);
    const Vec6 ddq = (p1.dq - m1.dq) / (2 * h), ddq2 = (p2.dq - m2.dq) / (4 * h);
    ASSERT_TRUE(((here.dq - dq).cwiseAbs().array() <= difference_bound(dq2, dq, rounding, h).array()).all())
        << "case " << k;
    ASSERT_TRUE(((here.ddq - ddq).cwiseAbs().array() <= difference_bound(ddq2, ddq, rounding * rates, h).array()).all())
        << "case " << k << "\n"
        << here.ddq.transpose() << "\n"
        << ddq.transpose();
    const double angle_rate = (p1.axis_angle_rad - m1.axis_angle_rad) / (2 * h);
    const double angle_rate2 = (p2.axis_angle_rad - m2.axis_angle_rad) / (4 * h);
    ASSERT_NEAR(here.axis_angle_rate, angle_rate, std::abs(angle_rate2 - angle_rate) + rounding / h);
    ASSERT_NEAR(here.length_m[1], (p1.length_m[0] - m1.length_m[0]) / (2 * h), 1e-9);  // h^2/6 of 1 m/s^3, eps/h
    ASSERT_NEAR(here.length_m[2], (p1.length_m[1] - m1.length_m[1]) / (2 * h), 1e-8);
  }
}

INSTANTIATE_TEST_SUITE_P(Columns, Derivatives, testing::Bool());

TEST(Transformation, LeftDeviceIsTheMirroredOne) {
  // A left device with axes a, mounts b, c in the person's unmirrored frame: mirroring x turns the axial vector (x, y, z)
  // into (x, -y, -z), and the joint angles stay.
  Random random(8);
  const Mat3 mirror = Vec3(-1.0, 1.0, 1.0).asDiagonal(), axial = Vec3(1.0, -1.0, -1.0).asDiagonal();
  for (int k = 0; k < test_count(2000); ++k) {
    ExoSettings left = random_device(random), given = left;
    left.base_follows_girdle = given.base_follows_girdle = false;
    for (Vec3& axis : given.axes) axis = axial * axis;
    given.base = axial * left.base;
    given.cuff = axial * left.cuff;
    const ExoModel model(given, kCentre);
    const Mat3 R_left = random.rotation();
    ExoSample out;
    if (map_to_exo(model, random_branch(random), at_rest({mirror * R_left * mirror, 0.0}), fixed_point(kCentre),
                   Vec3::Zero(), out) != Status::Ok)
      continue;
    ASSERT_LE(max_difference(device_pose(left, out.q), R_left), 1e-12) << "case " << k;
  }
}

TEST(Transformation, RefusesWhatIsNotARotationAndLeavesTheOutputAlone) {
  const ExoModel model(ExoSettings(), kCentre);
  PostureJet jet = at_rest(Posture());
  ExoSample out, before;
  ASSERT_EQ(map_to_exo(model, ExoBranch::First, jet, fixed_point(kCentre), Vec3(0.1, 0.2, 0.3), before), Status::Ok);
  out = before;
  PostureJet bad = jet;
  bad.dz[1] = std::nan("");
  EXPECT_EQ(map_to_exo(model, ExoBranch::First, bad, fixed_point(kCentre), Vec3::Zero(), out), Status::NotFinite);
  bad = jet;
  bad.x *= 1.1;
  EXPECT_EQ(map_to_exo(model, ExoBranch::First, bad, fixed_point(kCentre), Vec3::Zero(), out), Status::OutOfRange);
  EXPECT_EQ(map_to_exo(model, ExoBranch::First, jet, fixed_point(Vec3(0.0, HUGE_VAL, 0.0)), Vec3::Zero(), out),
            Status::NotFinite);
  EXPECT_EQ(map_to_exo(model, ExoBranch::First, jet, fixed_point(kCentre), Vec3(std::nan(""), 0.0, 0.0), out),
            Status::NotFinite);
  EXPECT_EQ(out.q, before.q);
  EXPECT_EQ(out.residual_m, before.residual_m);
}

TEST(Girdle, WithALengthDriveReachesTheCentreInEitherOrder) {
  Random random(9);
  for (int k = 0; k < test_count(20'000); ++k) {
    ExoSettings device = random_device(random);
    const ExoModel model(device, kCentre);
    const Vec3 centre = random_centre(random);
    GirdleJet out;
    girdle_joints(model, fixed_point(centre), out);
    const Vec3 reached = girdle_turn(device.girdle_order, out.q[0], out.q[1]) * Vec3(out.q[2], 0.0, 0.0);
    ASSERT_LE((reached - centre).norm(), 8.0 * kEps * centre.norm()) << "case " << k;
    ASSERT_EQ(out.residual_m, 0.0);
    Vec6 q = Vec6::Zero();
    q.head<2>() = out.q.head<2>();
    ASSERT_LE((exo_centre(model, q, out.q[2]) - centre).norm(), 8.0 * kEps * centre.norm()) << "case " << k;
    const Vec3 girdle = girdle_coordinates(centre);  // (phi_ed, phi_pr, d)
    if (device.girdle_order == GirdleOrder::ProtractionFirst) {
      ASSERT_LE((out.q - Vec3(girdle[1], girdle[0], girdle[2])).cwiseAbs().maxCoeff(), 4.0 * kEps) << "case " << k;
    } else {
      ASSERT_NEAR(out.q[0], std::asin(std::sin(girdle[1]) * std::cos(girdle[0])), 8.0 * kEps) << "case " << k;
      ASSERT_NEAR(out.q[1], std::atan2(std::sin(girdle[0]), std::cos(girdle[0]) * std::cos(girdle[1])), 8.0 * kEps);
    }
  }
}

class MissingDrives : public testing::TestWithParam<std::tuple<GirdleDrives, double>> {};

TEST_P(MissingDrives, ResidualIsTheDistanceOfTheReachedPointFromTheCentre) {
  const auto [drives, link] = GetParam();
  Random random(10);
  for (int k = 0; k < test_count(5000); ++k) {
    ExoSettings device = random_device(random);
    device.base_follows_girdle = false;
    device.girdle_drives = drives;
    device.girdle_link_m = link;
    const Vec3 rest = random_centre(random), centre = random_centre(random);
    const ExoModel model(device, rest);
    GirdleJet out;
    girdle_joints(model, fixed_point(centre), out);
    const Vec3 reached = girdle_turn(device.girdle_order, out.q[0], out.q[1]) * Vec3(out.q[2], 0.0, 0.0);
    ASSERT_NEAR(out.residual_m, (reached - centre).norm(), 8.0 * kEps) << "case " << k;
    ASSERT_GT(out.residual_m, 0.0);
    const Vec3 fixed = link > 0.0 ? Vec3(link * rest / rest.norm()) : rest;
    if (drives == GirdleDrives::NoLength) {  // along the right direction: no other point of that link is nearer
      ASSERT_NEAR(out.q[2], fixed.norm(), 4.0 * kEps);
      ASSERT_NEAR(angle_between(reached, centre), 0.0, 8.0 * kEps);
    } else {
      ASSERT_LE((reached - fixed).head<2>().norm(), 8.0 * kEps);
      ASSERT_NEAR(reached.z(), drives == GirdleDrives::VerticalOnly ? centre.z() : fixed.z(), 8.0 * kEps);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, MissingDrives,
                         testing::Combine(testing::Values(GirdleDrives::NoLength, GirdleDrives::VerticalOnly,
                                                          GirdleDrives::None),
                                          testing::Values(0.0, 0.15)));

TEST(Girdle, RatesAreThoseOfTheCoordinatesForEveryDrive) {
  Random random(11);
  for (int k = 0; k < test_count(2000); ++k) {
    ExoSettings device = random_device(random);
    device.base_follows_girdle = false;
    device.girdle_drives = static_cast<GirdleDrives>(1 + k % 4);
    const ExoModel model(device, kCentre);
    const Vec3 p = random_centre(random), v = random.vector(0.1), a = random.vector(0.1);
    const auto at = [&](double t) {
      GirdleJet out;
      girdle_joints(model, {p + t * v + 0.5 * t * t * a, v + t * a, a}, out);
      return out;
    };
    const double h = 1e-5;
    const GirdleJet m = at(-h), o = at(0.0), n = at(h);
    // |q'''| <= 6 |v/d|^3 + 6 |v||a|/d^2 < 40 rad/s^3 for d > 0.1 m: h^2/6 of it, and eps/h
    ASSERT_LE((o.dq - (n.q - m.q) / (2 * h)).cwiseAbs().maxCoeff(), h * h * 40.0 + kEps / h) << "case " << k;
    // the fourth derivative is below 400 rad/s^4 likewise
    ASSERT_LE((o.ddq - (n.dq - m.dq) / (2 * h)).cwiseAbs().maxCoeff(), h * h * 400.0 + 10.0 * kEps / h) << "case " << k;
  }
}

TEST(Girdle, IsFiniteOnTheAxesOfItsJoints) {
  for (const GirdleOrder order : {GirdleOrder::ProtractionFirst, GirdleOrder::ElevationFirst}) {
    ExoSettings device;
    device.girdle_order = order;
    const ExoModel model(device, kCentre);
    for (const Vec3& p : {Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.2), Vec3(0.0, 0.2, 0.0)}) {
      GirdleJet out;
      girdle_joints(model, {p, Vec3::Ones(), Vec3::Ones()}, out);
      EXPECT_TRUE(out.q.allFinite() && out.dq.allFinite() && out.ddq.allFinite()) << p.transpose();
    }
  }
}

struct BadSettings {
  const char* name;
  const char* message;
  void (*spoil)(ExoSettings&);
};

class Validation : public testing::TestWithParam<BadSettings> {};

TEST_P(Validation, NamesVariableValueAndRule) {
  ExoSettings device;
  GetParam().spoil(device);
  const std::string text = refusal([&] { ExoModel(device, kCentre); });
  EXPECT_TRUE(contains(text, GetParam().message)) << text;
  EXPECT_TRUE(contains(text, ": ")) << text;
}

INSTANTIATE_TEST_SUITE_P(
    Rules, Validation,
    testing::Values(
        BadSettings{"length", "length of exo.axis2 = 2:", [](ExoSettings& s) { s.axes[1] *= 2.0; }},
        BadSettings{"zero", "length of exo.axis3 = 0:", [](ExoSettings& s) { s.axes[2].setZero(); }},
        BadSettings{"nan", "exo.axis1[2] = nan", [](ExoSettings& s) { s.axes[0][1] = std::nan(""); }},
        BadSettings{"parallel", "angle of exo.axis1 and exo.axis2 = 0 rad",
                    [](ExoSettings& s) { s.axes[1] = s.axes[0]; }},
        BadSettings{"opposite", "angle of exo.axis2 and exo.axis3", [](ExoSettings& s) { s.axes[2] = -s.axes[1]; }},
        BadSettings{"degrees", "length of exo.base = 90 rad", [](ExoSettings& s) { s.base = Vec3(0, 0, 90); }},
        BadSettings{"infinite", "exo.cuff[1] = inf", [](ExoSettings& s) { s.cuff[0] = HUGE_VAL; }},
        BadSettings{"order", "exo.girdleOrder = 3", [](ExoSettings& s) { s.girdle_order = static_cast<GirdleOrder>(3); }},
        BadSettings{"drives", "exo.girdleDrives = 0",
                    [](ExoSettings& s) { s.girdle_drives = static_cast<GirdleDrives>(0); }},
        BadSettings{"link", "exo.girdleLink = -0.1 m", [](ExoSettings& s) { s.girdle_link_m = -0.1; }},
        BadSettings{"carried", "exo.baseFollowsGirdle",
                    [](ExoSettings& s) { s.base_follows_girdle = true, s.girdle_drives = GirdleDrives::None; }},
        BadSettings{"singular", "exo.minSingularity = 2 rad", [](ExoSettings& s) { s.min_singularity_rad = 2.0; }},
        BadSettings{"limits", "exo.lower[Elbow] = 1 rad",
                    [](ExoSettings& s) { s.lower[kElbow] = 1.0, s.upper[kElbow] = 0.5; }},
        BadSettings{"nanlimit", "exo.upper[GirdleElevation] = nan", [](ExoSettings& s) { s.upper[1] = std::nan(""); }}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(Validation, ReportsEveryProblemAtOnceAndAcceptsRoundedAxes) {
  ExoSettings device;
  device.axes[0] *= 2.0;
  device.girdle_link_m = 7.0;
  const std::string text = refusal([&] { ExoModel(device, Vec3::Zero()); });
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2) << text;
  ExoSettings rounded;
  rounded.axes[1] = Vec3(0.7071068, 0.7071068, 0.0);
  EXPECT_NEAR(ExoModel(rounded, kCentre).shoulder().a[1].norm(), 1.0, 2.0 * kEps);
}

}  // namespace
}  // namespace glenoid::test
