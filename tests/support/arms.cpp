#include "support/arms.hpp"

namespace glenoid::test {

ArmModel default_arm(const RhythmSettings& rhythm, bool moving_shoulder) {
  const ScaledArm scaled = scale_subject(Subject());
  return make_arm_model(scaled, Rhythm(rhythm, scaled.shoulder_distance_m), JointLimits(), moving_shoulder);
}

}  // namespace glenoid::test
