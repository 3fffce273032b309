#include "glenoid/subject.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/matchers.hpp"
#include "support/random.hpp"

namespace glenoid::test {
namespace {

// A published figure is right to half a unit of its last printed digit.
double half_digit(int decimals) { return 0.5 * std::pow(10.0, -decimals); }

TEST(Subject, CheckSubjectHasThePrintedFigures) {
  const ScaledArm arm = scale_subject(Subject());  // 1.75 m, 75 kg, male
  EXPECT_NEAR(arm.upper_arm.length_m, 0.2832, half_digit(4));
  EXPECT_NEAR(arm.forearm.length_m, 0.2703, half_digit(4));
  EXPECT_NEAR(arm.upper_arm.mass_kg, 2.0325, 1e-12);
  EXPECT_NEAR(arm.forearm.mass_kg, 1.6725, 1e-12);
  EXPECT_NEAR(arm.upper_arm.com_m, 0.1634, half_digit(4));
  EXPECT_NEAR(arm.forearm.com_m, 0.1825, half_digit(4));
  EXPECT_TRUE(near(arm.upper_arm.inertia_kg_m2, Vec3(0.01251, 0.01251, 0.00407), half_digit(5)));
  EXPECT_TRUE(near(arm.forearm.inertia_kg_m2, Vec3(0.02301, 0.02301, 0.00185), half_digit(5)));
  EXPECT_NEAR(arm.shoulder_distance_m, 0.1699, half_digit(4));
}

TEST(Subject, TablePersonHasTheTablesLengthsAndMasses) {
  Subject woman;
  woman.female = true;
  woman.stature_m = 1.735;
  woman.mass_kg = 61.9;
  const ScaledArm arm = scale_subject(woman);
  EXPECT_NEAR(arm.upper_arm.length_m, 0.2751, 1e-15);
  EXPECT_NEAR(arm.forearm.length_m, 0.2643, 1e-15);
  EXPECT_NEAR(arm.upper_arm.mass_kg, 0.0255 * 61.9, 1e-14);
  EXPECT_NEAR(arm.forearm.mass_kg, (0.0138 + 0.0056) * 61.9, 1e-14);
  EXPECT_NEAR(arm.upper_arm.com_m, 0.5754 * 0.2751, 1e-15);
}

TEST(Subject, LumpedForearmMovesLikeForearmAndHand) {
  // Law: the kinetic energy of any planar motion of the lump is that of its parts (Koenig), here at the elbow as pivot.
  Subject man;
  man.stature_m = 1.741;
  man.mass_kg = 73.0;
  const Segment lump = scale_subject(man).forearm;
  const double m_f = 0.0162 * 73.0, m_h = 0.0061 * 73.0;
  const double c_f = 0.4574 * 0.2689, c_h = 0.2689 + 0.7900 * 0.0862;
  const auto transverse = [](double mass, double length, double k1, double k2) {
    return mass * length * length * 0.5 * (k1 * k1 + k2 * k2);
  };
  const double about_elbow = transverse(m_f, 0.2689, 0.276, 0.265) + m_f * c_f * c_f +
                             transverse(m_h, 0.0862, 0.628, 0.513) + m_h * c_h * c_h;
  EXPECT_NEAR(lump.mass_kg * lump.com_m, m_f * c_f + m_h * c_h, 1e-15);
  EXPECT_NEAR(lump.inertia_kg_m2.x() + lump.mass_kg * lump.com_m * lump.com_m, about_elbow, 1e-15);
  EXPECT_EQ(lump.inertia_kg_m2.x(), lump.inertia_kg_m2.y());
  EXPECT_NEAR(lump.inertia_kg_m2.z(), m_f * std::pow(0.121 * 0.2689, 2) + m_h * std::pow(0.401 * 0.0862, 2), 1e-15);
}

TEST(Subject, ScalesWithStatureAndMass) {
  // Lengths ~ stature, masses ~ mass, inertias ~ mass stature^2.
  Random random(1);
  for (int k = 0; k < 1000; ++k) {
    Subject base, other;
    base.female = other.female = k % 2 == 0;
    other.stature_m = random.uniform(0.5, 2.6);
    other.mass_kg = random.uniform(10.0, 400.0);
    const ScaledArm a = scale_subject(base), b = scale_subject(other);
    const double s = other.stature_m / base.stature_m, m = other.mass_kg / base.mass_kg;
    for (const auto member : {&ScaledArm::upper_arm, &ScaledArm::forearm}) {
      EXPECT_NEAR((b.*member).length_m, s * (a.*member).length_m, 1e-15);
      EXPECT_NEAR((b.*member).com_m, s * (a.*member).com_m, 1e-15);
      EXPECT_NEAR((b.*member).mass_kg, m * (a.*member).mass_kg, 1e-14);
      EXPECT_TRUE(near((b.*member).inertia_kg_m2, m * s * s * (a.*member).inertia_kg_m2, 1e-15));
    }
    EXPECT_NEAR(b.shoulder_distance_m, 0.60 * b.upper_arm.length_m, 1e-15);
  }
}

TEST(Subject, GivenLengthStretchesItsSegmentOnly) {
  const ScaledArm scaled = scale_subject(Subject());
  Subject subject;
  subject.upper_arm_length_m = 0.34;
  const ScaledArm arm = scale_subject(subject);
  const double stretch = 0.34 / scaled.upper_arm.length_m;
  EXPECT_EQ(arm.upper_arm.length_m, 0.34);
  EXPECT_EQ(arm.upper_arm.mass_kg, scaled.upper_arm.mass_kg);
  EXPECT_NEAR(arm.upper_arm.com_m, stretch * scaled.upper_arm.com_m, 1e-15);
  EXPECT_TRUE(near(arm.upper_arm.inertia_kg_m2, stretch * stretch * scaled.upper_arm.inertia_kg_m2, 1e-15));
  EXPECT_NEAR(arm.shoulder_distance_m, 0.60 * 0.34, 1e-15);
  EXPECT_EQ(arm.forearm.length_m, scaled.forearm.length_m);
  EXPECT_EQ(arm.forearm.com_m, scaled.forearm.com_m);
}

TEST(Subject, GivenFiguresAreTakenAsTheyAre) {
  Subject subject;
  subject.forearm_length_m = 0.25;
  subject.shoulder_distance_m = 0.2;
  subject.upper_arm_mass_kg = 3.0;
  subject.forearm_mass_kg = 2.0;
  subject.upper_arm_com_m = 0.15;
  subject.forearm_com_m = 0.26;  // a load in the hand: beyond the wrist
  subject.upper_arm_inertia_kg_m2 = Vec3(0.01, 0.011, 0.003);
  subject.forearm_inertia_kg_m2 = Vec3(0.02, 0.021, 0.002);
  const ScaledArm arm = scale_subject(subject);
  EXPECT_EQ(arm.forearm.length_m, 0.25);
  EXPECT_EQ(arm.shoulder_distance_m, 0.2);
  EXPECT_EQ(arm.upper_arm.mass_kg, 3.0);
  EXPECT_EQ(arm.forearm.mass_kg, 2.0);
  EXPECT_EQ(arm.upper_arm.com_m, 0.15);
  EXPECT_EQ(arm.forearm.com_m, 0.26);
  EXPECT_EQ(arm.upper_arm.inertia_kg_m2, Vec3(0.01, 0.011, 0.003));
  EXPECT_EQ(arm.forearm.inertia_kg_m2, Vec3(0.02, 0.021, 0.002));
}

TEST(Subject, GivenMassKeepsTheGyrationRadii) {
  const ScaledArm scaled = scale_subject(Subject());
  Subject subject;
  subject.forearm_mass_kg = 2.0 * scaled.forearm.mass_kg;
  EXPECT_TRUE(near(scale_subject(subject).forearm.inertia_kg_m2, 2.0 * scaled.forearm.inertia_kg_m2, 1e-15));
}

TEST(Subject, ReportNamesEveryFigureOnceWithItsSource) {
  Subject subject;
  subject.forearm_length_m = 0.25;
  const ScaledArm arm = scale_subject(subject);
  ASSERT_EQ(arm.report.size(), 13u);  // per segment: length, mass, com, three moments; and d_0
  int given = 0;
  for (const ScalingEntry& entry : arm.report) {
    EXPECT_FALSE(entry.name.empty());
    EXPECT_FALSE(entry.unit.empty());
    EXPECT_TRUE(std::isfinite(entry.value));
    if (entry.source == "given") ++given;
    if (entry.name == "forearm.length") {
      EXPECT_EQ(entry.value, 0.25);
      EXPECT_EQ(entry.source, "given");
    }
    if (entry.name == "forearm.com") {
      EXPECT_EQ(entry.value, arm.forearm.com_m);
      EXPECT_TRUE(contains(entry.source, "given length")) << entry.source;
    }
    if (entry.name == "upper_arm.mass") {
      EXPECT_TRUE(contains(entry.source, "de Leva 1996")) << entry.source;
    }
  }
  EXPECT_EQ(given, 1);
}

TEST(Subject, EveryProblemIsNamedInOneException) {
  Subject subject;
  subject.stature_m = 175.0;
  subject.mass_kg = -1.0;
  subject.upper_arm_length_m = 0.0;
  subject.forearm_length_m = 270.0;
  subject.shoulder_distance_m = std::numeric_limits<double>::quiet_NaN();
  subject.upper_arm_mass_kg = 0.0;
  subject.forearm_inertia_kg_m2 = Vec3(0.01, 0.01, 0.03);
  const std::string text = refusal([&] { scale_subject(subject); });
  for (const char* part : {"subject.stature = 175 m", "subject.mass = -1 kg", "upper_arm.length = 0 m",
                           "forearm.length = 270 m", "shoulder_distance = nan m", "upper_arm.mass = 0 kg",
                           "forearm.inertia[z] = 0.03 kg.m2: must not exceed the sum"}) {
    EXPECT_TRUE(contains(text, part)) << part << " missing in:\n" << text;
  }
}

struct BadSubject {
  const char* what;
  void (*spoil)(Subject&);
};

class SubjectRefuses : public testing::TestWithParam<BadSubject> {};

TEST_P(SubjectRefuses, WithNameAndRule) {
  Subject subject;
  GetParam().spoil(subject);
  const std::string text = refusal([&] { scale_subject(subject); });
  EXPECT_TRUE(contains(text, GetParam().what)) << "said: " << text;
  EXPECT_TRUE(contains(text, ": must")) << "said: " << text;
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

INSTANTIATE_TEST_SUITE_P(
    Each, SubjectRefuses,
    testing::Values(
        BadSubject{"subject.stature", [](Subject& s) { s.stature_m = 0.49; }},
        BadSubject{"subject.stature", [](Subject& s) { s.stature_m = kNaN; }},
        BadSubject{"subject.mass", [](Subject& s) { s.mass_kg = 401.0; }},
        BadSubject{"subject.mass", [](Subject& s) { s.mass_kg = kInfinity; }},
        BadSubject{"upper_arm.length", [](Subject& s) { s.upper_arm_length_m = -0.3; }},
        BadSubject{"forearm.length", [](Subject& s) { s.forearm_length_m = kInfinity; }},
        BadSubject{"shoulder_distance", [](Subject& s) { s.shoulder_distance_m = 0.0; }},
        BadSubject{"forearm.mass", [](Subject& s) { s.forearm_mass_kg = kNaN; }},
        BadSubject{"upper_arm.com", [](Subject& s) { s.upper_arm_com_m = 0.5; }},
        BadSubject{"forearm.com", [](Subject& s) { s.forearm_com_m = -0.1; }},
        BadSubject{"upper_arm.inertia[z]", [](Subject& s) { s.upper_arm_inertia_kg_m2 = Vec3(0.01, 0.01, 0.0); }},
        BadSubject{"forearm.inertia[x]", [](Subject& s) { s.forearm_inertia_kg_m2 = Vec3(kNaN, 0.01, 0.01); }}));

}  // namespace
}  // namespace glenoid::test
