#include "glenoid/kinematics.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "support/allocation_guard.hpp"
#include "support/arms.hpp"
#include "support/environment.hpp"
#include "support/matchers.hpp"
#include "support/random.hpp"

namespace glenoid::test {
namespace {

Mat3 about(const Vec3& axis, double angle) { return Eigen::AngleAxisd(angle, axis).toRotationMatrix(); }

double wrapped(double angle) { return std::remainder(angle, 2.0 * kPi); }

double distance(const Posture& a, const Posture& b) {
  return std::max((a.R_TU - b.R_TU).cwiseAbs().maxCoeff(), std::abs(a.phi - b.phi));
}

/// One posture in five hangs or nearly hangs, one in five has a nearly straight elbow (phi >= 1e-5; 0 is tested apart).
Vec4 awkward_angles(Random& random, int k) {
  Vec4 q = random_angles(random, {0.0, kWholeRange.theta_upper, 1e-5, kWholeRange.phi_upper});
  if (k % 10 == 0) q[kTheta] = 0.0;
  if (k % 10 == 1) q[kTheta] = random.log_uniform(1e-5, 0.1);
  if (k % 5 == 2) q[kPhi] = random.log_uniform(1e-5, 0.1);
  return q;
}

// --- Angles and rotations ------------------------------------------------------------------------------------------

TEST(PostureFromAngles, IsRotationAboutZThenXThenZ) {
  Random random(1);
  for (int k = 0; k < test_count(100000); ++k) {
    const Vec4 q = random_angles(random);
    const Posture posture = posture_from_angles(q);
    const Mat3 R = about(Vec3::UnitZ(), q[kEta]) * about(Vec3::UnitX(), q[kTheta]) * about(Vec3::UnitZ(), q[kZeta]);
    ASSERT_TRUE(near(posture.R_TU, R, 2e-15));
    ASSERT_EQ(posture.phi, q[kPhi]);
  }
}

TEST(AnglesFromPosture, InvertTheAnglesToRounding) {
  Random random(2);
  for (int k = 0; k < test_count(1000000); ++k) {
    Vec4 q = random_angles(random);
    if (k % 10 == 1) q[kTheta] = random.log_uniform(1e-5, 0.1);
    const Vec4 near_q = q + random.vector4(2.0);
    const Vec4 back = angles_from_posture(posture_from_angles(q), near_q);
    // eta and zeta are conditioned by 1/sin(theta); their sum is not.
    const double tolerance = 1e-15 * (4.0 + 4.0 / std::sin(q[kTheta]));
    ASSERT_NEAR(back[kTheta], q[kTheta], 4e-15);
    ASSERT_NEAR(back[kEta], q[kEta], tolerance);
    ASSERT_NEAR(back[kZeta], q[kZeta], tolerance);
    ASSERT_EQ(back[kPhi], q[kPhi]);
  }
}

TEST(AnglesFromPosture, AreUnwrappedNextToTheGivenOnes) {
  const Vec4 q(1.0, 2.0, -2.5, 0.7);
  for (const double turns : {-3.0, -1.0, 0.0, 2.0}) {
    const Vec4 near_q = q + 2.0 * kPi * turns * Vec4(0.0, 1.0, -1.0, 0.0);
    EXPECT_TRUE(near(angles_from_posture(posture_from_angles(q), near_q), near_q, 1e-14));
  }
}

TEST(AnglesFromPosture, TakeEtaFromNearbyWhereItIsUndefined) {
  for (const double theta : {0.0, kPi}) {
    const Vec4 q(theta, 0.8, -0.3, 0.5);
    const Vec4 near_q(theta, 2.0, 1.0, 0.0);
    const Vec4 back = angles_from_posture(posture_from_angles(q), near_q);
    EXPECT_EQ(back[kEta], 2.0);
    EXPECT_LE(distance(posture_from_angles(back), posture_from_angles(q)), 1e-9) << "but it is the same posture";
  }
}

TEST(AxialRotation, IsEtaPlusZeta) {
  Random random(3);
  for (int k = 0; k < test_count(100000); ++k) {
    const Vec4 q = random_angles(random);
    const double tau = axial_rotation(posture_from_angles(q).R_TU);
    ASSERT_NEAR(wrapped(tau - q[kEta] - q[kZeta]), 0.0, 4e-15 / (1.0 + std::cos(q[kTheta])));
  }
}

TEST(AxialRotation, IsTheTwistLeftAfterTheShortestSwing) {
  // R = (swing about a horizontal axis) Rz(tau).
  Random random(4);
  for (int k = 0; k < 10000; ++k) {
    const Mat3 R = posture_from_angles(random_angles(random, {0.0, 2.9, 0.0, 1.0})).R_TU;
    const Mat3 swing = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), R.col(2)).toRotationMatrix();
    EXPECT_TRUE(near(swing * about(Vec3::UnitZ(), axial_rotation(R)), R, 1e-13));
  }
}

TEST(IsbAngles, AreInverse) {
  Random random(5);
  for (int k = 0; k < 1000; ++k) {
    const Vec4 q = random.vector4(3.0);
    EXPECT_TRUE(near(angles_from_isb(isb_from_angles(q)), q, 1e-15));
  }
}

TEST(IsbAngles, DescribeTheSameRotationInTheFramesOfWu2005) {
  // ISB: X forward, Y up, Z to the right; Y-X-Y with elevation as a negative rotation about X.
  Mat3 to_isb;
  to_isb << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  Random random(6);
  for (int k = 0; k < 10000; ++k) {
    const Vec4 q = random_angles(random);
    const Vec4 isb = isb_from_angles(q);
    const Mat3 R = about(Vec3::UnitY(), isb[0]) * about(Vec3::UnitX(), -isb[1]) * about(Vec3::UnitY(), isb[2]);
    EXPECT_TRUE(near(to_isb * posture_from_angles(q).R_TU * to_isb.transpose(), R, 4e-15));
    EXPECT_EQ(isb[3], q[kPhi]);
  }
}

// --- Forward kinematics and eq. (3) --------------------------------------------------------------------------------

TEST(ForwardKinematics, IsTheClosedFormOfTheAngles) {
  Random random(7);
  const ArmModel arm = default_arm();
  const double l_u = arm.upper_arm.length_m, l_f = arm.forearm.length_m;
  for (int k = 0; k < test_count(100000); ++k) {
    const Vec4 q = random_angles(random);
    const double st = std::sin(q[0]), ct = std::cos(q[0]), se = std::sin(q[1]), ce = std::cos(q[1]);
    const double sz = std::sin(q[2]), cz = std::cos(q[2]), sp = std::sin(q[3]), cp = std::cos(q[3]);
    const double along = sp * ct * cz + st * cp;
    const ArmPoints points = forward_kinematics(arm, posture_from_angles(q));
    ASSERT_EQ(points.shoulder, arm.rhythm.position(posture_from_angles(q).R_TU.col(2)));
    ASSERT_TRUE(near(points.elbow - points.shoulder, l_u * Vec3(-st * se, st * ce, -ct), 1e-15));
    const Vec3 reach(-l_u * st * se - l_f * (se * along + sp * sz * ce),
                     l_u * st * ce + l_f * (ce * along - sp * sz * se), -l_u * ct + l_f * (sp * st * cz - cp * ct));
    ASSERT_TRUE(near(points.wrist - points.shoulder, reach, 1e-15));
  }
}

TEST(ForwardKinematics, MeansWhatTheConventionsSay) {
  const ArmModel arm = default_arm({RhythmModel::Fixed, 1.0, 0.1});
  const auto forearm = [&arm](double theta, double eta, double zeta, double phi) -> Vec3 {
    const ArmPoints points = forward_kinematics(arm, posture_from_angles(degrees(theta, eta, zeta, phi)));
    return (points.wrist - points.elbow).normalized();
  };
  EXPECT_TRUE(near(forearm(90, 0, 0, 0), Vec3::UnitY(), 1e-15)) << "flexion points forward";
  EXPECT_TRUE(near(forearm(90, -90, 0, 0), Vec3::UnitX(), 1e-15)) << "abduction points to the right";
  EXPECT_TRUE(near(forearm(90, -90, 0, 90), Vec3::UnitZ(), 1e-15)) << "forearm up";
  EXPECT_TRUE(near(forearm(90, -90, 90, 90), Vec3::UnitY(), 1e-15)) << "internal rotation turns it forward";
}

TEST(PostureFromPoints, InvertsForwardKinematics) {
  Random random(8);
  const ArmModel arm = default_arm();
  for (int k = 0; k < test_count(1000000); ++k) {
    const Vec4 q = awkward_angles(random, k);
    const Posture posture = posture_from_angles(q);
    Posture back;
    ASSERT_EQ(posture_from_points(forward_kinematics(arm, posture), Mat3::Identity(), back), Status::Ok);
    // The axial rotation is conditioned by 1/sin(phi): 1e-16/1e-5 at worst.
    ASSERT_LE(distance(back, posture), 1e-10) << q.transpose();
  }
}

TEST(PostureFromPoints, LeavesTheAxialRotationOfAStraightArmToTheNearbyOne) {
  Random random(9);
  const ArmModel arm = default_arm();
  for (int k = 0; k < 1000; ++k) {
    Vec4 q = random_angles(random);
    q[kPhi] = 0.0;
    const Posture posture = posture_from_angles(q);
    Posture back;
    ASSERT_EQ(posture_from_points(forward_kinematics(arm, posture), posture.R_TU, back), Status::Ok);
    EXPECT_LE(distance(back, posture), 1e-10);
  }
}

TEST(PostureFromPoints, RefusesWhatIsNoArm) {
  Posture out;
  out.phi = 42.0;
  const Vec3 a(0.1, 0.2, 0.3), b(0.4, 0.2, 0.3), nan = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(posture_from_points({a, a, b}, Mat3::Identity(), out), Status::OutOfRange);
  EXPECT_EQ(posture_from_points({a, b, b}, Mat3::Identity(), out), Status::OutOfRange);
  EXPECT_EQ(posture_from_points({a, nan, b}, Mat3::Identity(), out), Status::NotFinite);
  EXPECT_EQ(out.phi, 42.0) << "unchanged unless Ok";
}

// --- Swivel angle --------------------------------------------------------------------------------------------------

TEST(SwivelAngle, TurnsTheElbowAboutTheLineToTheWrist) {
  Random random(10);
  for (int k = 0; k < test_count(100000); ++k) {
    const double l_u = random.uniform(0.2, 0.4), l_f = random.uniform(0.2, 0.4), alpha = random.uniform(-kPi, kPi);
    const double d = random.uniform(std::abs(l_u - l_f) + 0.02, l_u + l_f - 0.02);
    const Vec3 n = random.unit_vector(), down = -Vec3::UnitZ();
    if (std::hypot(n.x(), n.y()) < 0.05) continue;  // swivel undefined on the vertical, ill-conditioned near it
    const Vec3 u = (down - down.dot(n) * n).normalized();
    const double c = (l_u * l_u + d * d - l_f * l_f) / (2.0 * d), r = std::sqrt(l_u * l_u - c * c);
    const Vec3 shoulder = random.vector(0.3);
    const Vec3 elbow = shoulder + c * n + r * (std::cos(alpha) * u + std::sin(alpha) * u.cross(n));
    ASSERT_NEAR(wrapped(swivel_angle({shoulder, elbow, shoulder + d * n}) - alpha), 0.0, 1e-12);
  }
}

TEST(SwivelAngle, IsPositiveWithTheElbowOut) {
  const Vec3 shoulder(0.17, 0.0, 0.0), wrist(0.17, 0.4, 0.0);
  EXPECT_EQ(swivel_angle({shoulder, Vec3(0.17, 0.2, -0.2), wrist}), 0.0) << "elbow lowest";
  EXPECT_NEAR(swivel_angle({shoulder, Vec3(0.37, 0.2, 0.0), wrist}), 0.5 * kPi, 1e-15) << "lateral: to the right";
}

TEST(SwivelAngle, IsZeroWhereItIsUndefined) {
  const Vec3 shoulder(0.17, 0.0, 0.0);
  EXPECT_EQ(swivel_angle({shoulder, Vec3(0.37, 0.0, -0.2), shoulder - Vec3(0.0, 0.0, 0.4)}), 0.0)
      << "wrist straight below";
  EXPECT_EQ(swivel_angle({shoulder, shoulder, shoulder}), 0.0);
}

// --- Inverse kinematics --------------------------------------------------------------------------------------------

/// Condition number of (wrist in m, swivel in rad) as a function of the posture in rad.
double ik_condition(const ArmModel& arm, const Posture& posture) {
  constexpr double h = 1e-5;
  const auto outputs = [&](const Vec4& step) -> Vec4 {
    const Vec3 turn = step.head<3>();
    const Mat3 R = turn.norm() > 0.0 ? about(turn.normalized(), turn.norm()) : Mat3(Mat3::Identity());
    const ArmPoints points = forward_kinematics(arm, {posture.R_TU * R, posture.phi + step[3]});
    Vec4 out;
    out << points.wrist, swivel_angle(points);
    return out;
  };
  Mat4 J;
  for (Eigen::Index k = 0; k < 4; ++k) {
    Vec4 difference = outputs(h * Vec4::Unit(k)) - outputs(-h * Vec4::Unit(k));
    difference[3] = wrapped(difference[3]);
    J.col(k) = difference / (2.0 * h);
  }
  const Vec4 singular_values = J.jacobiSvd().singularValues();
  return singular_values[0] / singular_values[3];
}

bool contains_posture(const IkSolutions& solutions, const Posture& posture, double tolerance) {
  return std::any_of(solutions.postures.begin(), solutions.postures.begin() + solutions.count,
                     [&](const Posture& other) { return distance(other, posture) <= tolerance; });
}

TEST(InverseKinematics, FindsEveryPostureAgainFromItsWristAndSwivel) {
  Random random(11);
  const ArmModel arm = default_arm();
  int excluded = 0, tried = 0;
  for (int k = 0; k < test_count(100000); ++k) {
    // Not promised: elbows straighter than 0.05 deg, next to which the swivel turns half round within less than that angle.
    Vec4 q = awkward_angles(random, k);
    q[kPhi] = std::max(q[kPhi], 0.05 * kDegree);
    const Posture posture = posture_from_angles(q);
    const ArmPoints points = forward_kinematics(arm, posture);
    // Excluded: where the problem itself is ill-posed: double roots and wrists on the vertical through the shoulder, where the
    // swivel is undefined. At 0.05 deg a swivel is right to eps/sin(phi), some 1e-13; 1e4 times that is the tolerance.
    if (ik_condition(arm, posture) > 1e4) {
      ++excluded;
      continue;
    }
    ++tried;
    IkSolutions solutions;
    ASSERT_EQ(inverse_kinematics(arm, points.wrist, swivel_angle(points), solutions), Status::Ok);
    ASSERT_TRUE(contains_posture(solutions, posture, 1e-9))
        << "q = " << q.transpose() << ", " << solutions.count << " found";
  }
  EXPECT_LT(excluded, tried / 20) << "the excluded set must stay small";
}

TEST(InverseKinematics, EverySolutionReachesTheTargetWithTheSwivel) {
  Random random(12);
  const ArmModel arm = default_arm();
  for (int k = 0; k < test_count(20000); ++k) {
    const ArmPoints points = forward_kinematics(arm, posture_from_angles(random_angles(random)));
    const double swivel = random.uniform(-kPi, kPi);
    IkSolutions solutions;
    if (inverse_kinematics(arm, points.wrist, swivel, solutions) != Status::Ok) continue;
    for (int i = 0; i < solutions.count; ++i) {
      const Posture& posture = solutions.postures[static_cast<std::size_t>(i)];
      const ArmPoints there = forward_kinematics(arm, posture);
      ASSERT_TRUE(near(there.wrist, points.wrist, 1e-12));
      ASSERT_NEAR(wrapped(swivel_angle(there) - swivel), 0.0, 1e-9);
      ASSERT_GE(posture.phi, 0.0);
      ASSERT_TRUE(near(posture.R_TU.transpose() * posture.R_TU, Mat3::Identity(), 1e-14));
    }
  }
}

/// Sign changes of the scalar equation of the self-motion on a grid of elevations: a lower bound of the number of postures
/// with this wrist and swivel, independent of the solver.
int count_roots(const ArmModel& arm, const Vec3& wrist, double swivel) {
  constexpr int kGrid = 2000;
  const double l_u = arm.upper_arm.length_m, l_f = arm.forearm.length_m;
  int count = 0;
  double before = std::numeric_limits<double>::quiet_NaN();
  for (int k = 0; k <= kGrid; ++k) {
    const double theta = kPi * k / kGrid;
    const Vec3 reach = wrist - arm.rhythm.position(Vec3(0.0, -std::sin(theta), std::cos(theta)));
    const double d = reach.norm(), c = (l_u * l_u + d * d - l_f * l_f) / (2.0 * d), n_z = reach.z() / d;
    const double r = std::sqrt(l_u * l_u - c * c);  // NaN out of reach
    const double f = l_u * std::cos(theta) + c * n_z - r * std::sqrt(1.0 - n_z * n_z) * std::cos(swivel);
    if (f * before < 0.0) ++count;
    before = f;
  }
  return count;
}

/// Share of arms with phi in the range (deg) whose wrist and swivel belong to two postures or more; none may be missed.
double share_with_two(const ArmModel& arm, Random& random, double phi_lower, double phi_upper) {
  constexpr int kArms = 1000;
  int two = 0;
  for (int k = 0; k < kArms; ++k) {
    const Vec4 q = degrees(random.uniform(0.0, 150.0), random.uniform(-120.0, 60.0), random.uniform(-60.0, 120.0),
                           random.uniform(phi_lower, phi_upper));
    const ArmPoints points = forward_kinematics(arm, posture_from_angles(q));
    const double swivel = swivel_angle(points);
    IkSolutions solutions;
    EXPECT_EQ(inverse_kinematics(arm, points.wrist, swivel, solutions), Status::Ok);
    EXPECT_GE(solutions.count, count_roots(arm, points.wrist, swivel)) << q.transpose();
    if (solutions.count >= 2) ++two;
  }
  return static_cast<double>(two) / kArms;
}

TEST(InverseKinematics, FindsSecondSolutionsOfNearlyStraightArms) {
  // Known of this model: two postures in about 39 % of arms with 5 to 15 deg of elbow flexion, 7 % with 15 to 25 deg, none
  // seen above 28 deg (shares of a sample: they depend on how it is drawn).
  Random random(13);
  const ArmModel arm = default_arm({RhythmModel::SoltaniZarrin2017, 1.0, 0.0});
  EXPECT_NEAR(share_with_two(arm, random, 5.0, 15.0), 0.35, 0.08);
  EXPECT_NEAR(share_with_two(arm, random, 15.0, 25.0), 0.07, 0.03);
  EXPECT_EQ(share_with_two(arm, random, 30.0, 140.0), 0.0);
}

TEST(InverseKinematics, NamesUnreachableTargetsWithANegativeMargin) {
  Random random(14);
  const ArmModel arm = default_arm();
  const double longest = arm.upper_arm.length_m + arm.forearm.length_m;
  for (int k = 0; k < 2000; ++k) {
    // Farther from every shoulder position than the arm is long: the shoulder stays within 1.01 d_0 of the origin.
    const Vec3 wrist = random.uniform(longest + 0.18, 3.0) * random.unit_vector();
    IkSolutions solutions;
    EXPECT_EQ(inverse_kinematics(arm, wrist, random.uniform(-3.0, 3.0), solutions), Status::TargetUnreachable);
    EXPECT_EQ(solutions.count, 0);
    EXPECT_LT(solutions.reach_margin_m, 0.0);
  }
}

TEST(InverseKinematics, NamesTargetsBeyondTheRangeOfSquares) {
  for (const double far : {1e5, 1e7, 1e154, 1e300}) {
    IkSolutions solutions;
    EXPECT_EQ(inverse_kinematics(default_arm(), {far, 0.0, 0.0}, 0.3, solutions), Status::TargetUnreachable) << far;
    EXPECT_NEAR(solutions.reach_margin_m / -far, 1.0, 1e-4) << far;
  }
}

TEST(InverseKinematics, MarginOfAFixedShoulderIsTheDistanceToTheReach) {
  Random random(15);
  const ArmModel arm = default_arm({RhythmModel::Fixed, 1.0, 0.1});
  const double longest = arm.upper_arm.length_m + arm.forearm.length_m;
  for (int k = 0; k < 2000; ++k) {
    const double d = random.uniform(0.8 * longest, 1.5 * longest);
    const Vec3 wrist = arm.rhythm.position(Vec3::UnitZ()) + d * random.unit_vector();
    IkSolutions solutions;
    const Status status = inverse_kinematics(arm, wrist, 0.3, solutions);
    EXPECT_NEAR(solutions.reach_margin_m, longest - d, 1e-6);
    if (std::abs(longest - d) > 1e-6) {
      EXPECT_EQ(status, d < longest ? Status::Ok : Status::TargetUnreachable) << longest - d;
    }
  }
}

TEST(InverseKinematics, RefusesWhatIsNotFinite) {
  const ArmModel arm = default_arm();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  IkSolutions solutions;
  EXPECT_EQ(inverse_kinematics(arm, Vec3(nan, 0.0, 0.0), 0.0, solutions), Status::NotFinite);
  EXPECT_EQ(inverse_kinematics(arm, Vec3(0.2, 0.3, 0.0), nan, solutions), Status::NotFinite);
}

TEST(Kinematics, NeedsNoHeapAtRunTime) {
  const ArmModel arm = default_arm();
  IkSolutions solutions;
  Posture back;
  AllocationGuard guard;
  const ArmPoints points = forward_kinematics(arm, posture_from_angles(Vec4(0.8, -0.3, 0.4, 1.0)));
  const Status there = inverse_kinematics(arm, points.wrist, swivel_angle(points), solutions);
  const Status again = posture_from_points(points, Mat3::Identity(), back);
  EXPECT_EQ(guard.allocations(), 0);
  EXPECT_EQ(there, Status::Ok);
  EXPECT_EQ(again, Status::Ok);
}

}  // namespace
}  // namespace glenoid::test
