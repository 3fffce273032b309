#include "glenoid/mass_matrix.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "core/numeric_derivative.hpp"
#include "glenoid/kinematics.hpp"
#include "support/allocation_guard.hpp"
#include "support/arms.hpp"
#include "support/environment.hpp"
#include "support/matchers.hpp"
#include "support/random.hpp"

namespace glenoid::test {
namespace {

// Away from the chart's poles, where M loses rank; the body metric is tested there.
constexpr AngleRange kChart = {5.0 * kDegree, 150.0 * kDegree, 0.0, 150.0 * kDegree};

/// An arm that no table would give: every moment different, any rhythm.
ArmModel random_arm(Random& random, bool moving_shoulder) {
  ScaledArm arm = scale_subject(Subject());
  for (Segment* segment : {&arm.upper_arm, &arm.forearm}) {
    segment->length_m = random.uniform(0.2, 0.4);
    segment->mass_kg = random.uniform(1.0, 4.0);
    segment->com_m = random.uniform(0.3, 0.7) * segment->length_m;
    const Vec3 second_moment = 0.01 * (Vec3::Constant(0.6) + random.vector(0.5));
    segment->inertia_kg_m2 = Vec3::Constant(second_moment.sum()) - second_moment;
  }
  const RhythmSettings rhythm{RhythmModel::SoltaniZarrin2017, random.uniform(0.0, 1.5), 0.1};
  return make_arm_model(arm, Rhythm(rhythm, random.uniform(0.1, 0.2)), JointLimits(), moving_shoulder);
}

// --- Independent kinetic energy: each segment as six point masses ---------------------------------------------------

struct PointMass {
  double mass_kg;
  Vec3 local;  ///< from the proximal joint, in the segment's frame
};

/// Six points on the principal axes with the mass, the centre of mass and the inertia of the segment.
std::vector<PointMass> point_masses(const Segment& segment) {
  std::vector<PointMass> points;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double second_moment = 0.5 * segment.inertia_kg_m2.sum() - segment.inertia_kg_m2[k];
    const Vec3 offset = std::sqrt(3.0 * second_moment / segment.mass_kg) * Vec3::Unit(k);
    for (const double side : {-1.0, 1.0}) {
      points.push_back({segment.mass_kg / 6.0, side * offset - segment.com_m * Vec3::UnitZ()});
    }
  }
  return points;
}

using Points = Eigen::Matrix<double, 3, 12>;

/// Where the point masses are; rotations by Eigen, not by the library.
Points positions(const ArmModel& arm, const Vec4& q) {
  const Mat3 R = (Eigen::AngleAxisd(q[kEta], Vec3::UnitZ()) * Eigen::AngleAxisd(q[kTheta], Vec3::UnitX()) *
                  Eigen::AngleAxisd(q[kZeta], Vec3::UnitZ()))
                     .toRotationMatrix();
  const Mat3 R_F = R * Eigen::AngleAxisd(q[kPhi], Vec3::UnitX()).toRotationMatrix();
  const Vec3 shoulder = arm.moving_shoulder ? arm.rhythm.position(R.col(2)) : Vec3(Vec3::Zero());
  const Vec3 elbow = shoulder - arm.upper_arm.length_m * R.col(2);
  Points out;
  Eigen::Index k = 0;
  for (const PointMass& point : point_masses(arm.upper_arm)) out.col(k++) = shoulder + R * point.local;
  for (const PointMass& point : point_masses(arm.forearm)) out.col(k++) = elbow + R_F * point.local;
  return out;
}

double kinetic_energy(const ArmModel& arm, const Vec4& q, const Vec4& v) {
  const Points velocity = derivative_at_zero([&](double t) { return positions(arm, q + t * v); });
  double energy = 0.0;
  Eigen::Index k = 0;
  for (const Segment* segment : {&arm.upper_arm, &arm.forearm}) {
    for (const PointMass& point : point_masses(*segment))
      energy += 0.5 * point.mass_kg * velocity.col(k++).squaredNorm();
  }
  return energy;
}

/// Parameter: whether the shoulder moves in the metric.
class ArmMetricWith : public testing::TestWithParam<bool> {};

TEST_P(ArmMetricWith, IsTheKineticEnergyOfItsPointMasses) {
  Random random(1);
  for (int k = 0; k < test_count(2000); ++k) {
    const ArmModel arm = random_arm(random, GetParam());
    const Vec4 q = random_angles(random), v = random.vector4(1.0);
    const double energy = kinetic_energy(arm, q, v);
    ASSERT_NEAR(0.5 * v.dot(mass_matrix(arm, q) * v), energy, 1e-9 * energy) << q.transpose();
  }
}

TEST_P(ArmMetricWith, IsSymmetricPositiveDefiniteInsideTheLimits) {
  Random random(2);
  const ArmModel arm = default_arm({}, GetParam());
  for (int k = 0; k < test_count(20000); ++k) {
    const Vec4 q = random_angles(random, kChart);
    const Mat4 M = mass_matrix(arm, q);
    ASSERT_EQ(M, M.transpose());
    const double least = Eigen::SelfAdjointEigenSolver<Mat4>(M, Eigen::EigenvaluesOnly).eigenvalues()[0];
    ASSERT_GT(least, 1e-4) << q.transpose();  // kg.m2; 4e-4 is the least known at theta = 5 deg
  }
}

TEST_P(ArmMetricWith, InBodyRatesIsPositiveDefiniteEverywhere) {
  Random random(3);
  const ArmModel arm = default_arm({}, GetParam());
  for (const double theta : {0.0, 1e-8, 1e-3, 1.0, 3.0}) {
    for (const double phi : {0.0, 1e-8, 1.0, kPi}) {
      for (int k = 0; k < 100; ++k) {
        Vec4 q = random_angles(random);
        q[kTheta] = theta;
        q[kPhi] = phi;
        const Mat4 M = body_mass_matrix(arm, posture_from_angles(q));
        const Vec4 eigenvalues = Eigen::SelfAdjointEigenSolver<Mat4>(M, Eigen::EigenvaluesOnly).eigenvalues();
        // The least is at least that of the axial and elbow inertias, some 1e-3 kg.m2: no loss of rank at theta = 0 or phi = 0.
        EXPECT_GT(eigenvalues[0], 1e-3) << q.transpose();
      }
    }
  }
}

/// Body rates per Euler rate from the rotation itself.
Mat4 rate_map(const Vec4& q) {
  Mat4 G = Mat4::Zero();
  const Mat3 R = posture_from_angles(q).R_TU;
  for (Eigen::Index k = 0; k < 4; ++k) {
    const Mat3 dR = derivative_at_zero([&](double t) { return posture_from_angles(q + t * Vec4::Unit(k)).R_TU; });
    const Mat3 W = R.transpose() * dR;
    G.col(k).head<3>() = Vec3(W(2, 1), W(0, 2), W(1, 0));
  }
  G(3, 3) = 1.0;
  return G;
}

TEST_P(ArmMetricWith, InTheEulerChartIsTheBodyMetricThroughTheRateMap) {
  Random random(4);
  for (int k = 0; k < test_count(2000); ++k) {
    const ArmModel arm = random_arm(random, GetParam());
    const Vec4 q = random_angles(random);
    const Mat4 body = body_mass_matrix(arm, posture_from_angles(q));
    const Mat4 G = rate_map(q);
    ASSERT_TRUE(near(mass_matrix(arm, q), G.transpose() * body * G, 1e-11)) << q.transpose();
    ASSERT_NEAR(mass_matrix(arm, q).determinant(), std::pow(std::sin(q[kTheta]), 2) * body.determinant(), 1e-13)
        << "the chart's only pole is sin(theta)";
  }
}

TEST_P(ArmMetricWith, CoriolisForceIsThatOfTheMetricsDerivatives) {
  // Lagrange: C v = (sum_k v_k dM/dq_k) v - 1/2 (v' dM/dq_k v)_k.
  Random random(5);
  for (int n = 0; n < test_count(2000); ++n) {
    const ArmModel arm = random_arm(random, GetParam());
    const Vec4 q = random_angles(random), v = random.vector4(1.0);
    Vec4 expected = Vec4::Zero();
    for (Eigen::Index k = 0; k < 4; ++k) {
      const Mat4 dM = derivative_at_zero([&](double t) { return mass_matrix(arm, q + t * Vec4::Unit(k)); });
      expected += v[k] * dM * v;
      expected[k] -= 0.5 * v.dot(dM * v);
    }
    ASSERT_TRUE(near(coriolis_vector(arm, q, v), expected, 1e-10)) << q.transpose();
  }
}

TEST_P(ArmMetricWith, CoriolisForceDoesTheWorkThatKeepsTheEnergy) {
  // v'(M' - 2C)v = 0, with M' along the motion.
  Random random(6);
  for (int n = 0; n < test_count(2000); ++n) {
    const ArmModel arm = random_arm(random, GetParam());
    const Vec4 q = random_angles(random), v = random.vector4(1.0);
    const Mat4 M_rate = derivative_at_zero([&](double t) { return mass_matrix(arm, q + t * v); });
    ASSERT_NEAR(v.dot(coriolis_vector(arm, q, v)), 0.5 * v.dot(M_rate * v), 1e-10) << q.transpose();
  }
}

TEST_P(ArmMetricWith, CoriolisForceIsQuadraticInTheRates) {
  Random random(7);
  for (int n = 0; n < 1000; ++n) {
    const ArmModel arm = random_arm(random, GetParam());
    const Vec4 q = random_angles(random), v = random.vector4(1.0);
    const Vec4 once = coriolis_vector(arm, q, v);
    EXPECT_TRUE(near(coriolis_vector(arm, q, -3.0 * v), 9.0 * once, 1e-13));
    EXPECT_EQ(coriolis_vector(arm, q, Vec4::Zero()), Vec4::Zero());
  }
}

TEST_P(ArmMetricWith, GeodesicAccelerationIsTheSameInBodyRatesAndInTheChart) {
  // A curve with the chart's acceleration; its body rates, differentiated twice by numbers, must change as the body form says.
  Random random(8);
  for (int n = 0; n < 300; ++n) {
    const ArmModel arm = random_arm(random, GetParam());
    const Vec4 q = random_angles(random, {0.3, 2.8, 0.0, 2.6}), v = random.vector4(1.0);
    const Vec4 a = -mass_matrix(arm, q).llt().solve(coriolis_vector(arm, q, v));
    const auto body_rates = [&](double t) -> Vec4 { return rate_map(q + t * v + 0.5 * t * t * a) * (v + t * a); };
    const Vec4 expected = derivative_at_zero(body_rates);
    const Vec4 rates = body_rates(0.0);
    const PostureRates out = geodesic_acceleration(arm, posture_from_angles(q), {rates.head<3>(), rates[3]});
    // Twice-differenced rounding, 1e-12/h, and accelerations up to 1/sin(theta).
    EXPECT_TRUE(near(out.w_TU_U, expected.head<3>(), 1e-8));
    EXPECT_NEAR(out.phi, expected[3], 1e-8);
  }
}

TEST_P(ArmMetricWith, AtTheHangingArmDoesNotDependOnEta) {
  const ArmModel arm = default_arm({}, GetParam());
  const PostureRates rates{Vec3(0.5, -1.0, 0.7), 0.9};
  const Posture hanging = posture_from_angles(Vec4(0.0, 0.0, 0.4, 1.0));
  const Mat4 M = body_mass_matrix(arm, hanging);
  const PostureRates a = geodesic_acceleration(arm, hanging, rates);
  for (const double eta : {-3.0, -1.0, 0.5, 2.0}) {
    for (const double theta : {0.0, 1e-12}) {
      const Posture same = posture_from_angles(Vec4(theta, eta, 0.4 - eta, 1.0));
      EXPECT_TRUE(near(body_mass_matrix(arm, same), M, 1e-11)) << eta;
      EXPECT_TRUE(near(geodesic_acceleration(arm, same, rates).w_TU_U, a.w_TU_U, 1e-9)) << eta;
    }
  }
}

TEST_P(ArmMetricWith, NeedsNoHeapAtRunTime) {
  const ArmModel arm = default_arm({}, GetParam());
  const Vec4 q(0.5, 0.2, 0.1, 1.0), v(1.0, 2.0, 3.0, 4.0);
  double sum = 0.0;
  AllocationGuard guard;
  sum += mass_matrix(arm, q).sum() + coriolis_vector(arm, q, v).sum();
  sum += geodesic_acceleration(arm, posture_from_angles(q), {v.head<3>(), v[3]}).phi;
  EXPECT_EQ(guard.allocations(), 0);
  EXPECT_TRUE(std::isfinite(sum));
}

INSTANTIATE_TEST_SUITE_P(Shoulder, ArmMetricWith, testing::Bool(),
                         [](const auto& shoulder) { return shoulder.param ? "Moving" : "Fixed"; });

TEST(ArmMetric, WithAFixedShoulderIsIndependentOfEta) {
  Random random(9);
  const ArmModel arm = default_arm({}, false);
  for (int k = 0; k < 1000; ++k) {
    Vec4 q = random_angles(random);
    const Mat4 M = mass_matrix(arm, q);
    q[kEta] = random.uniform(-kPi, kPi);
    EXPECT_TRUE(near(mass_matrix(arm, q), M, 1e-14));
  }
}

TEST(ArmMetric, FeelsTheMovingShoulder) {
  // The shoulder's own displacement makes elevation heavier at mid range: 28 % more at 60 deg (any plane: at least 10 %).
  const Vec4 q = degrees(60.0, -30.0, 30.0, 60.0);
  const double moving = mass_matrix(default_arm({}, true), q)(kTheta, kTheta);
  const double fixed = mass_matrix(default_arm({}, false), q)(kTheta, kTheta);
  EXPECT_GT(moving, 1.1 * fixed);
}

TEST(ArmMetric, IsCheaperForTheAxialRotationThanForTheSwing) {
  // Straight arm: the axial moment is the sum of the axial inertias, the swing that of a rod about the shoulder.
  const ArmModel arm = default_arm({}, false);
  const Mat4 M = body_mass_matrix(arm, posture_from_angles(Vec4(1.0, 0.3, 0.2, 0.0)));
  const Segment& u = arm.upper_arm;
  const Segment& f = arm.forearm;
  EXPECT_NEAR(M(2, 2), u.inertia_kg_m2.z() + f.inertia_kg_m2.z(), 1e-15);
  const double reach = u.length_m + f.com_m;
  EXPECT_NEAR(M(0, 0),
              u.inertia_kg_m2.x() + u.mass_kg * u.com_m * u.com_m + f.inertia_kg_m2.x() + f.mass_kg * reach * reach,
              1e-14);
  EXPECT_NEAR(M(3, 3), f.inertia_kg_m2.x() + f.mass_kg * f.com_m * f.com_m, 1e-15);
}

}  // namespace
}  // namespace glenoid::test
