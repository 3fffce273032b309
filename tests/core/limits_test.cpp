#include "glenoid/limits.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "support/arms.hpp"
#include "support/environment.hpp"
#include "support/matchers.hpp"
#include "support/random.hpp"

namespace glenoid::test {
namespace {

/// Independent of the kinematics under test elsewhere: the definition, by Eigen's rotations.
Posture posture_at(double theta, double eta, double zeta, double phi) {
  const Mat3 R = (Eigen::AngleAxisd(eta, Vec3::UnitZ()) * Eigen::AngleAxisd(theta, Vec3::UnitX()) *
                  Eigen::AngleAxisd(zeta, Vec3::UnitZ()))
                     .toRotationMatrix();
  return {R, phi};
}

double wrapped(double angle) { return std::remainder(angle, 2.0 * kPi); }

TEST(LimitedAngles, AreThetaEtaTauPhi) {
  // Rounding of R is eps; eta is ill-conditioned by 1/sin(theta), tau by 1/(1 + cos theta).
  Random random(1);
  constexpr double kEps = 1e-15;
  for (int k = 0; k < test_count(100000); ++k) {
    const Vec4 q = random_angles(random, {0.01, 3.0, 0.0, 2.5});
    const Vec4 a = limited_angles(posture_at(q[0], q[1], q[2], q[3]));
    ASSERT_NEAR(a[kLimitTheta], q[0], 8 * kEps);
    ASSERT_NEAR(wrapped(a[kLimitEta] - q[1]), 0.0, 8 * kEps / std::sin(q[0]));
    ASSERT_NEAR(wrapped(a[kLimitTau] - q[1] - q[2]), 0.0, 8 * kEps / (1.0 + std::cos(q[0])));
    ASSERT_EQ(a[kLimitPhi], q[3]);
    ASSERT_GT(a[kLimitEta], -kPi);
    ASSERT_GT(a[kLimitTau], -kPi);
  }
}

TEST(LimitedAngles, AxialRotationIsDefinedAtTheHangingArm) {
  for (const double theta : {0.0, 1e-300, 1e-8, 1e-5, 1e-3}) {
    for (const double eta : {-3.0, -1.0, 0.0, 2.0}) {
      const Vec4 a = limited_angles(posture_at(theta, eta, 0.4 - eta, 0.0));
      EXPECT_NEAR(a[kLimitTau], 0.4, 4e-15) << "theta " << theta << " eta " << eta;
      EXPECT_NEAR(a[kLimitTheta], theta, 4e-15);
    }
  }
  EXPECT_EQ(limited_angles(Posture())[kLimitEta], 0.0);
}

TEST(LimitMargin, IsTheLeastSignedDistanceOfAllLimits) {
  Random random(2);
  const JointLimits limits;
  for (int k = 0; k < test_count(100000); ++k) {
    // Inside or slightly outside, and all angles within pi of the middles, so that no wrapping is needed.
    Vec4 a;
    for (int i = 0; i < 4; ++i) a[i] = random.uniform(limits.lower[i] - 0.1, limits.upper[i] + 0.1);
    a[kLimitTheta] = std::max(a[kLimitTheta], 0.1);
    const LimitMargin margin = limit_margin(limits, posture_at(a[0], a[1], a[2] - a[1], a[3]));
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 4; ++i) least = std::min({least, a[i] - limits.lower[i], limits.upper[i] - a[i]});
    ASSERT_NEAR(margin.margin_rad, least, 1e-13);
    const int i = margin.angle;
    const double named = margin.at_upper ? limits.upper[i] - a[i] : a[i] - limits.lower[i];
    ASSERT_NEAR(named, margin.margin_rad, 1e-13) << "the named limit must be the nearest one";
  }
}

TEST(LimitMargin, EtaIsFreeBelowFiveDegreesOfElevation) {
  const double outside = 100.0 * kDegree;  // above the default 45
  const JointLimits limits;
  EXPECT_LT(limit_margin(limits, posture_at(5.001 * kDegree, outside, -outside, 1.0)).margin_rad, 0.0);
  EXPECT_GT(limit_margin(limits, posture_at(4.999 * kDegree, outside, -outside, 1.0)).margin_rad, 0.0);
}

TEST(LimitMargin, DoesNotDependOnEtaOfTheHangingArm) {
  const JointLimits limits;
  for (const double eta : {-3.0, 0.0, 3.0}) {
    const LimitMargin margin = limit_margin(limits, posture_at(0.0, eta, 0.2 - eta, 0.7));
    EXPECT_NEAR(margin.margin_rad, 0.0, 1e-15);
    EXPECT_EQ(margin.angle, kLimitTheta);
    EXPECT_FALSE(margin.at_upper);
  }
}

TEST(LimitMargin, CountsEtaAndTauModuloOneTurn) {
  // A range across +-180 deg: 170 .. 200 deg contains -175 deg.
  JointLimits limits;
  limits.lower = degrees(0.0, 170.0, 170.0, 0.0);
  limits.upper = degrees(150.0, 200.0, 200.0, 145.0);
  const LimitMargin inside = limit_margin(limits, posture_at(1.0, -175.0 * kDegree, 0.0, 1.0));
  EXPECT_NEAR(inside.margin_rad, 15.0 * kDegree, 1e-14);
  const LimitMargin outside = limit_margin(limits, posture_at(1.0, 160.0 * kDegree, 25.0 * kDegree, 1.0));
  EXPECT_NEAR(outside.margin_rad, -10.0 * kDegree, 1e-14);
  EXPECT_EQ(outside.angle, kLimitEta);
}

TEST(LimitMargin, OfNotANumberIsNotANumber) {
  Posture posture;
  posture.phi = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(limit_margin(JointLimits(), posture).margin_rad));
}

TEST(Limits, DefaultsAreValid) {
  EXPECT_EQ(refusal([] { validate(JointLimits()); }), "");
}

TEST(Limits, AWholeTurnIsAllowed) {
  JointLimits limits;
  limits.lower = degrees(0.0, -180.0, -360.0, 0.0);
  limits.upper = degrees(180.0, 180.0, 0.0, 180.0);
  EXPECT_EQ(refusal([&] { validate(limits); }), "");
}

struct BadLimit {
  const char* what;
  int angle;
  double lower_deg, upper_deg;
};

class LimitsRefuse : public testing::TestWithParam<BadLimit> {};

TEST_P(LimitsRefuse, WithNameValueUnitAndRule) {
  JointLimits limits;
  limits.lower[GetParam().angle] = GetParam().lower_deg * kDegree;
  limits.upper[GetParam().angle] = GetParam().upper_deg * kDegree;
  const std::string text = refusal([&] { validate(limits); });
  EXPECT_TRUE(contains(text, GetParam().what)) << "said: " << text;
  EXPECT_TRUE(contains(text, " rad: must")) << "said: " << text;
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

INSTANTIATE_TEST_SUITE_P(Each, LimitsRefuse,
                         testing::Values(BadLimit{"limits.lower[theta]", kLimitTheta, -1.0, 150.0},
                                         BadLimit{"limits.upper[theta]", kLimitTheta, 0.0, 181.0},
                                         BadLimit{"must be below limits.upper[theta]", kLimitTheta, 90.0, 90.0},
                                         BadLimit{"must be below limits.upper[eta]", kLimitEta, 45.0, -135.0},
                                         BadLimit{"limits.upper[eta]", kLimitEta, -135.0, kNaN},
                                         BadLimit{"must be at most 2 pi above", kLimitEta, -200.0, 200.0},
                                         BadLimit{"limits.lower[eta+zeta]", kLimitTau, -361.0, -10.0},
                                         BadLimit{"limits.upper[eta+zeta]", kLimitTau, 0.0,
                                                  std::numeric_limits<double>::infinity()},
                                         BadLimit{"limits.lower[phi]", kLimitPhi, -5.0, 145.0},
                                         BadLimit{"limits.upper[phi]", kLimitPhi, 0.0, 181.0}));

TEST(Limits, EveryProblemIsNamedInOneException) {
  JointLimits limits;
  limits.upper = Vec4(150.0, 45.0, 80.0, 145.0);  // degrees by mistake
  const std::string text = refusal([&] { validate(limits); });
  for (const char* name : {"upper[theta]", "upper[eta]", "upper[eta+zeta]", "upper[phi]"}) {
    EXPECT_TRUE(contains(text, name)) << text;
  }
}

}  // namespace
}  // namespace glenoid::test
