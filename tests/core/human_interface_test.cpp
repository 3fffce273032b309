// The human-like choices through the C interface: posture prior and measured rhythm give the core's own numbers.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

#include "glenoid/glenoid.h"
#include "glenoid/motion.hpp"
#include "support/environment.hpp"
#include "support/random.hpp"

namespace glenoid::test {
namespace {

struct Destroy {
  void operator()(glenoid_motion* motion) const noexcept { glenoid_destroy(motion); }
};

/// Both interfaces at one movement of the given mode; gives the core's swivel angle at the end.
double compare(int swivel_mode, const std::array<double, 3>& target, bool left) {
  glenoid_settings settings;
  glenoid_default_settings(&settings);
  settings.swivel_mode = swivel_mode;
  settings.rhythm_model = 3;
  settings.left_arm = left ? 1 : 0;
  const std::unique_ptr<glenoid_motion, Destroy> motion(glenoid_create(&settings, 0.0, nullptr, 0));
  MotionSettings own;
  own.swivel_mode = static_cast<SwivelMode>(swivel_mode);
  own.rhythm.model = RhythmModel::Measured;
  own.subject.left_arm = left;
  MotionGenerator generator(own, 0.0);
  EXPECT_NE(motion, nullptr);
  EXPECT_EQ(glenoid_command(motion.get(), 0.0, target.data(), 1, 0), GLENOID_OK);
  EXPECT_EQ(generator.command(0.0, {Vec3(target.data()), true, false}), Status::Ok);
  MotionSample sample;
  for (const double time : {0.0, 0.4, 0.9, 5.0}) {
    glenoid_sample c;
    EXPECT_EQ(glenoid_sample_at(motion.get(), time, &c), GLENOID_OK);
    EXPECT_EQ(generator.sample(time, sample), Status::Ok);
    for (int i = 0; i < 4; ++i) EXPECT_EQ(c.q_rad[i], sample.q[i]);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(c.elbow_m[i], sample.elbow[i]);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(c.shoulder_m[i], sample.shoulder[i]);
    EXPECT_EQ(c.swivel_rad, sample.swivel);
    EXPECT_EQ(c.status, static_cast<int>(sample.status));
  }
  EXPECT_EQ(sample.status, MotionStatus::Arrived);
  return sample.swivel;
}

TEST(HumanInterface, PriorThroughCIsThatOfTheCoreBitForBit) {
  Random random(1);
  for (int k = 0; k < test_count(8); ++k) {
    const bool left = k % 2 == 1;
    const double x = random.uniform(0.05, 0.30);
    const std::array<double, 3> target = {left ? -x : x, random.uniform(0.28, 0.40), random.uniform(-0.1, 0.25)};
    const double human = compare(3, target, left), cheapest = compare(1, target, left);
    EXPECT_GT(std::abs(human - cheapest), 1e-6) << "the mode is passed on: another posture is chosen";
  }
}

}  // namespace
}  // namespace glenoid::test
