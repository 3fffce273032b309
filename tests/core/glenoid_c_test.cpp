#include "glenoid/glenoid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "glenoid/motion.hpp"
#include "support/matchers.hpp"

extern "C" int glenoid_reach_from_c(void);  // glenoid_c_client.c: the header compiled as C

namespace glenoid::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<double, 3> kTarget = {0.20, 0.42, 0.25};

struct Destroy {
  void operator()(glenoid_motion* motion) const noexcept { glenoid_destroy(motion); }
};
using Motion = std::unique_ptr<glenoid_motion, Destroy>;

glenoid_settings defaults() {
  glenoid_settings settings;
  glenoid_default_settings(&settings);
  return settings;
}

Motion create(const glenoid_settings& settings) { return Motion(glenoid_create(&settings, 0.0, nullptr, 0)); }

std::string refusal_of(const glenoid_settings& settings) {
  std::array<char, 2000> message{};
  const Motion motion(glenoid_create(&settings, 0.0, message.data(), message.size()));
  EXPECT_EQ(motion, nullptr);
  return message.data();
}

template <class Vector, std::size_t n>
void expect_same(const double (&c)[n], const Vector& cpp) {
  for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(c[i], cpp[static_cast<Eigen::Index>(i)]);
}

void expect_same(const glenoid_sample& c, const MotionSample& cpp) {
  expect_same(c.q_rad, cpp.q);
  expect_same(c.dq_rad_per_s, cpp.dq);
  expect_same(c.ddq_rad_per_s2, cpp.ddq);
  expect_same(c.shoulder_m, cpp.shoulder);
  expect_same(c.elbow_m, cpp.elbow);
  expect_same(c.wrist_m, cpp.wrist);
  expect_same(c.girdle, cpp.girdle);
  EXPECT_EQ(c.swivel_rad, cpp.swivel);
  EXPECT_EQ(c.progress, cpp.progress);
  EXPECT_EQ(c.energy_kg_m2, cpp.energy);
  EXPECT_EQ(c.misalignment_m, cpp.misalignment);
  expect_same(c.exo_q_rad, cpp.exo_q);
  expect_same(c.exo_dq_rad_per_s, cpp.exo_dq);
  EXPECT_EQ(c.status, static_cast<int>(cpp.status));
}

TEST(CInterface, GivesTheNumbersOfTheCoreBitForBit) {
  const Motion motion = create(defaults());
  ASSERT_NE(motion, nullptr);
  MotionGenerator generator((MotionSettings()));
  ASSERT_EQ(glenoid_command(motion.get(), 0.0, kTarget.data(), 1, 0), GLENOID_OK);
  ASSERT_EQ(generator.command(0.0, {Vec3(kTarget.data()), true, false}), Status::Ok);
  for (int k = 0; k <= 20; ++k) {
    const double time = 0.1 * k;
    glenoid_sample c;
    MotionSample cpp;
    ASSERT_EQ(glenoid_sample_at(motion.get(), time, &c), GLENOID_OK);
    ASSERT_EQ(generator.sample(time, cpp), Status::Ok);
    expect_same(c, cpp);
  }
}

TEST(CInterface, PassesEverySettingOn) {
  glenoid_settings c = defaults();
  c.stature_m = 1.62, c.mass_kg = 58.0, c.female = 1, c.left_arm = 1;
  c.upper_arm_length_m = 0.29, c.forearm_length_m = 0.24, c.shoulder_distance_m = 0.16;
  c.rhythm_gain = 0.7, c.rhythm_smoothing_rad = 0.05, c.moving_shoulder = 0;
  c.swivel_mode = 2, c.swivel_prescribed_rad = 0.3, c.duration_s = 1.1;
  c.limits_upper_rad[0] = 2.5, c.limits_lower_rad[2] = -1.5, c.start_q_rad[3] = 0.9;
  MotionSettings cpp;
  cpp.subject.stature_m = 1.62, cpp.subject.mass_kg = 58.0, cpp.subject.female = cpp.subject.left_arm = true;
  cpp.subject.upper_arm_length_m = 0.29, cpp.subject.forearm_length_m = 0.24, cpp.subject.shoulder_distance_m = 0.16;
  cpp.rhythm.gain = 0.7, cpp.rhythm.smoothing_rad = 0.05, cpp.moving_shoulder = false;
  cpp.swivel_mode = SwivelMode::Prescribed, cpp.swivel_prescribed_rad = 0.3, cpp.duration_s = 1.1;
  cpp.limits.upper[0] = 2.5, cpp.limits.lower[2] = -1.5, cpp.start_q[3] = 0.9;
  const Motion motion = create(c);
  ASSERT_NE(motion, nullptr);
  MotionGenerator generator(cpp);
  const std::array<double, 3> target = {-0.25, 0.30, 0.05};  // a left arm reaches to the left
  ASSERT_EQ(glenoid_command(motion.get(), 0.2, target.data(), 1, 0), GLENOID_OK);
  ASSERT_EQ(generator.command(0.2, {Vec3(target.data()), true, false}), Status::Ok);
  glenoid_sample c_sample;
  MotionSample cpp_sample;
  ASSERT_EQ(glenoid_sample_at(motion.get(), 0.8, &c_sample), GLENOID_OK);
  ASSERT_EQ(generator.sample(0.8, cpp_sample), Status::Ok);
  expect_same(c_sample, cpp_sample);
}

TEST(CInterface, DefaultsAreThoseOfTheCore) {
  const glenoid_settings settings = defaults();
  const MotionSettings core;
  EXPECT_EQ(settings.stature_m, core.subject.stature_m);
  EXPECT_EQ(settings.duration_s, core.duration_s);
  EXPECT_EQ(settings.rhythm_model, static_cast<int>(core.rhythm.model));
  EXPECT_EQ(settings.swivel_mode, static_cast<int>(core.swivel_mode));
  EXPECT_EQ(settings.moving_shoulder, 1);
  expect_same(settings.start_q_rad, core.start_q);
  expect_same(settings.limits_upper_rad, core.limits.upper);
}

TEST(CInterface, StopAndDisableArePassedOn) {
  const Motion motion = create(defaults());
  ASSERT_EQ(glenoid_command(motion.get(), 0.0, kTarget.data(), 0, 0), GLENOID_OK);
  glenoid_sample sample;
  ASSERT_EQ(glenoid_sample_at(motion.get(), 0.5, &sample), GLENOID_OK);
  EXPECT_EQ(sample.status, static_cast<int>(MotionStatus::Idle)) << "not enabled: no movement";
  ASSERT_EQ(glenoid_command(motion.get(), 1.0, kTarget.data(), 1, 0), GLENOID_OK);
  ASSERT_EQ(glenoid_command(motion.get(), 1.5, kTarget.data(), 1, 1), GLENOID_OK);
  ASSERT_EQ(glenoid_sample_at(motion.get(), 20.0, &sample), GLENOID_OK);
  EXPECT_EQ(sample.status, static_cast<int>(MotionStatus::Stopped));
  EXPECT_LT(sample.progress, 1.0);
}

TEST(CInterface, BadCommandsAreRefusedWithAMessageAndChangeNothing) {
  const Motion motion = create(defaults());
  ASSERT_EQ(glenoid_command(motion.get(), 0.0, kTarget.data(), 1, 0), GLENOID_OK);
  EXPECT_STREQ(glenoid_message(motion.get()), "");
  glenoid_sample before, after;
  ASSERT_EQ(glenoid_sample_at(motion.get(), 0.7, &before), GLENOID_OK);
  const std::array<double, 3> bad = {0.2, kNaN, 0.1};
  EXPECT_EQ(glenoid_command(motion.get(), 0.5, nullptr, 1, 0), GLENOID_OUT_OF_RANGE);
  EXPECT_TRUE(contains(glenoid_message(motion.get()), "target")) << glenoid_message(motion.get());
  EXPECT_EQ(glenoid_command(motion.get(), 0.5, bad.data(), 1, 0), GLENOID_NOT_FINITE);
  EXPECT_TRUE(contains(glenoid_message(motion.get()), "target")) << glenoid_message(motion.get());
  EXPECT_EQ(glenoid_command(motion.get(), kNaN, kTarget.data(), 1, 0), GLENOID_NOT_FINITE);
  EXPECT_TRUE(contains(glenoid_message(motion.get()), "time")) << glenoid_message(motion.get());
  EXPECT_EQ(glenoid_sample_at(motion.get(), kNaN, &after), GLENOID_NOT_FINITE);
  ASSERT_EQ(glenoid_sample_at(motion.get(), 0.7, &after), GLENOID_OK);
  EXPECT_EQ(before.q_rad[0], after.q_rad[0]);
  EXPECT_EQ(before.status, after.status);
}

TEST(CInterface, AnUnreachableTargetIsAStatusOfTheSampleWithAMessage) {
  const Motion motion = create(defaults());
  const std::array<double, 3> far = {3.0, 3.0, 3.0};
  EXPECT_EQ(glenoid_command(motion.get(), 0.0, far.data(), 1, 0), GLENOID_OK);
  EXPECT_STRNE(glenoid_message(motion.get()), "");
  glenoid_sample sample;
  ASSERT_EQ(glenoid_sample_at(motion.get(), 0.1, &sample), GLENOID_OK);
  EXPECT_EQ(sample.status, static_cast<int>(MotionStatus::TargetUnreachable));
}

TEST(CInterface, NullPointersAreRefused) {
  glenoid_sample sample;
  std::array<char, 100> message{};
  glenoid_default_settings(nullptr);
  glenoid_destroy(nullptr);
  EXPECT_EQ(glenoid_create(nullptr, 0.0, message.data(), message.size()), nullptr);
  EXPECT_TRUE(contains(message.data(), "settings")) << message.data();
  EXPECT_EQ(glenoid_create(nullptr, 0.0, nullptr, 100), nullptr);
  EXPECT_EQ(glenoid_command(nullptr, 0.0, kTarget.data(), 1, 0), GLENOID_OUT_OF_RANGE);
  EXPECT_EQ(glenoid_sample_at(nullptr, 0.0, &sample), GLENOID_OUT_OF_RANGE);
  EXPECT_STRNE(glenoid_message(nullptr), "");
  const Motion motion = create(defaults());
  EXPECT_EQ(glenoid_sample_at(motion.get(), 0.0, nullptr), GLENOID_OUT_OF_RANGE);
}

TEST(CInterface, AShortMessageBufferIsFilledAndTerminated) {
  glenoid_settings settings = defaults();
  settings.stature_m = 175.0;
  std::array<char, 8> message;
  message.fill('x');
  EXPECT_EQ(glenoid_create(&settings, 0.0, message.data(), 5), nullptr);
  EXPECT_EQ(std::string(message.data()), "subj");
  EXPECT_EQ(message[5], 'x');
  EXPECT_EQ(glenoid_create(&settings, 0.0, message.data(), 0), nullptr);
  EXPECT_EQ(message[0], 's');
}

struct BadSetting {
  const char* what;
  void (*spoil)(glenoid_settings&);
};

class CInterfaceRefuses : public testing::TestWithParam<BadSetting> {};

TEST_P(CInterfaceRefuses, TheSettingByName) {
  glenoid_settings settings = defaults();
  GetParam().spoil(settings);
  const std::string text = refusal_of(settings);
  EXPECT_TRUE(contains(text, GetParam().what)) << "said: " << text;
}

INSTANTIATE_TEST_SUITE_P(
    Each, CInterfaceRefuses,
    testing::Values(BadSetting{"stature", [](glenoid_settings& s) { s.stature_m = kNaN; }},
                    BadSetting{"mass", [](glenoid_settings& s) { s.mass_kg = -1.0; }},
                    BadSetting{"upper_arm.length", [](glenoid_settings& s) { s.upper_arm_length_m = -0.3; }},
                    BadSetting{"forearm.length", [](glenoid_settings& s) { s.forearm_length_m = kNaN; }},
                    BadSetting{"shoulder_distance", [](glenoid_settings& s) { s.shoulder_distance_m = -0.1; }},
                    BadSetting{"rhythm.model", [](glenoid_settings& s) { s.rhythm_model = 7; }},
                    BadSetting{"rhythm.gain", [](glenoid_settings& s) { s.rhythm_gain = 2.0; }},
                    BadSetting{"rhythm.smoothing", [](glenoid_settings& s) { s.rhythm_smoothing_rad = kNaN; }},
                    BadSetting{"swivel.mode", [](glenoid_settings& s) { s.swivel_mode = 0; }},
                    BadSetting{"swivel.prescribed", [](glenoid_settings& s) { s.swivel_prescribed_rad = kNaN; }},
                    BadSetting{"duration", [](glenoid_settings& s) { s.duration_s = 0.0; }},
                    BadSetting{"limits.lower[theta]", [](glenoid_settings& s) { s.limits_lower_rad[0] = 15.0; }},
                    BadSetting{"start", [](glenoid_settings& s) { s.start_q_rad[1] = kNaN; }}));

TEST(CInterface, RefusesAStartTimeThatIsNoTime) {
  const glenoid_settings settings = defaults();
  std::array<char, 100> message{};
  EXPECT_EQ(glenoid_create(&settings, kNaN, message.data(), message.size()), nullptr);
  EXPECT_TRUE(contains(message.data(), "time")) << message.data();
}

TEST(CInterface, WorksFromC) { EXPECT_EQ(glenoid_reach_from_c(), 0); }

}  // namespace
}  // namespace glenoid::test
