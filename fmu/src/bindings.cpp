#include "bindings.hpp"

#include <optional>

namespace glenoid::fmu {
namespace {

template <int Size>
Eigen::Matrix<double, Size, 1> vector_at(const Values& values, Index first) noexcept {
  return Eigen::Map<const Eigen::Matrix<double, Size, 1>>(values.data() + first);
}

template <int Size>
void put(Values& values, Index first, const Eigen::Matrix<double, Size, 1>& vector) noexcept {
  Eigen::Map<Eigen::Matrix<double, Size, 1>>(values.data() + first) = vector;
}

template <class Enum>
Enum enum_at(const Values& values, Index index) noexcept {
  return static_cast<Enum>(static_cast<int>(values[index]));
}

/// 0 stands for "scaled from stature".
std::optional<double> length_at(const Values& values, Index index) noexcept {
  return values[index] == 0.0 ? std::nullopt : std::optional<double>(values[index]);
}

/// Component of a vector variable that starts at `first`, or -1.
int component(int index, Index first, int size) noexcept {
  const int offset = index - static_cast<int>(first);
  return offset >= 0 && offset < size ? offset : -1;
}

ExoSettings exo_from(const Values& values) noexcept {
  ExoSettings exo;
  exo.axes = {vector_at<3>(values, kExoAxis1), vector_at<3>(values, kExoAxis2), vector_at<3>(values, kExoAxis3)};
  exo.base = vector_at<3>(values, kExoBase);
  exo.cuff = vector_at<3>(values, kExoCuff);
  exo.girdle_order = enum_at<GirdleOrder>(values, kExoGirdleOrder);
  exo.girdle_drives = enum_at<GirdleDrives>(values, kExoGirdleDrives);
  exo.girdle_link_m = values[kExoGirdleLink];
  exo.base_follows_girdle = values[kExoBaseFollowsGirdle] != 0.0;
  exo.min_singularity_rad = values[kExoMinSingularity];
  exo.lower = vector_at<6>(values, kExoLower);
  exo.upper = vector_at<6>(values, kExoUpper);
  return exo;
}

Subject subject_from(const Values& values) noexcept {
  Subject subject;
  subject.stature_m = values[kSubjectStature];
  subject.mass_kg = values[kSubjectMass];
  subject.female = values[kSubjectFemale] != 0.0;
  subject.left_arm = values[kSubjectLeftArm] != 0.0;
  subject.upper_arm_length_m = length_at(values, kSubjectUpperArmLength);
  subject.forearm_length_m = length_at(values, kSubjectForearmLength);
  subject.shoulder_distance_m = length_at(values, kSubjectShoulderDistance);
  return subject;
}

}  // namespace

MotionSettings settings_from(const Values& values) {
  MotionSettings settings;
  settings.subject = subject_from(values);
  settings.rhythm.model = enum_at<RhythmModel>(values, kRhythmModel);
  settings.rhythm.gain = values[kRhythmGain];
  settings.rhythm.smoothing_rad = values[kRhythmSmoothing];
  settings.moving_shoulder = values[kMetricMovingShoulder] != 0.0;
  settings.axial_factor = values[kMetricAxialFactor];
  settings.swivel_mode = enum_at<SwivelMode>(values, kSwivelMode);
  settings.swivel_prescribed_rad = values[kSwivelPrescribed];
  settings.duration_s = values[kMotionDuration];
  settings.timing = enum_at<TimingLaw>(values, kMotionTiming);
  settings.limits.lower = vector_at<4>(values, kLimitsLower);
  settings.limits.upper = vector_at<4>(values, kLimitsUpper);
  settings.start_q = vector_at<4>(values, kStartQ);
  settings.exo = exo_from(values);
  return settings;
}

MotionCommand command_from(const Values& values) noexcept {
  MotionCommand command;
  command.target = vector_at<3>(values, kTarget);
  command.enable = values[kEnable] != 0.0;
  command.stop = values[kStop] != 0.0;
  return command;
}

void store(double time_s, const MotionSample& sample, Values& values) noexcept {
  values[kTime] = time_s;
  put<4>(values, kQ, sample.q);
  put<4>(values, kDq, sample.dq);
  put<4>(values, kDdq, sample.ddq);
  put<3>(values, kShoulder, sample.shoulder);
  put<3>(values, kElbow, sample.elbow);
  put<3>(values, kWrist, sample.wrist);
  put<3>(values, kGirdle, sample.girdle);
  values[kSwivel] = sample.swivel;
  values[kProgress] = sample.progress;
  values[kEnergy] = sample.energy;
  values[kMisalignment] = sample.misalignment;
  values[kExoResidual] = sample.exo_residual;
  put<6>(values, kExoQ, sample.exo_q);
  put<6>(values, kExoDq, sample.exo_dq);
  values[kStatus] = static_cast<double>(sample.status);
}

bool output_derivative(const MotionSample& sample, int index, int order, double& value) noexcept {
  if (const int k = component(index, kQ, 4); k >= 0 && (order == 1 || order == 2)) {
    value = order == 1 ? sample.dq[k] : sample.ddq[k];
  } else if (const int d = component(index, kDq, 4); d >= 0 && order == 1) {
    value = sample.ddq[d];
  } else if (const int e = component(index, kExoQ, 6); e >= 0 && (order == 1 || order == 2)) {
    value = order == 1 ? sample.exo_dq[e] : sample.exo_ddq[e];
  } else if (const int f = component(index, kExoDq, 6); f >= 0 && order == 1) {
    value = sample.exo_ddq[f];
  } else {
    return false;
  }
  return true;
}

bool same_fixed_parameters(const Values& a, const Values& b) noexcept {
  for (std::size_t i = 0; i < kVariables.size(); ++i) {
    if (kVariables[i].variability == Variability::Fixed && a[i] != b[i]) return false;
  }
  return true;
}

}  // namespace glenoid::fmu
