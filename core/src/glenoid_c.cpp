// Names of the C interface are the only ones that the shared library exports.
#pragma GCC visibility push(default)
#include "glenoid/glenoid.h"
#pragma GCC visibility pop

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <optional>

#include "glenoid/motion.hpp"

struct glenoid_motion {
  glenoid::MotionGenerator generator;
  const char* refusal = nullptr;  ///< why this layer refused the last command; NULL if it did not
};

namespace {

using glenoid::MotionSample;
using glenoid::MotionSettings;
using glenoid::Status;

std::optional<double> given_unless_zero(double value) {
  return value == 0.0 ? std::nullopt : std::optional<double>(value);
}

template <class Vector, std::size_t n>
void store(const Vector& from, double (&to)[n]) noexcept {
  static_assert(static_cast<std::size_t>(Vector::SizeAtCompileTime) == n);
  std::copy_n(from.data(), n, to);
}

glenoid_status status_of(Status status) noexcept { return static_cast<glenoid_status>(status); }

void write_message(const char* text, char* message, std::size_t size) noexcept {
  if (message != nullptr && size > 0) std::snprintf(message, size, "%s", text);
}

MotionSettings settings_of(const glenoid_settings& from) {
  MotionSettings to;
  to.subject.stature_m = from.stature_m;
  to.subject.mass_kg = from.mass_kg;
  to.subject.female = from.female != 0;
  to.subject.left_arm = from.left_arm != 0;
  to.subject.upper_arm_length_m = given_unless_zero(from.upper_arm_length_m);
  to.subject.forearm_length_m = given_unless_zero(from.forearm_length_m);
  to.subject.shoulder_distance_m = given_unless_zero(from.shoulder_distance_m);
  to.rhythm.model = static_cast<glenoid::RhythmModel>(from.rhythm_model);
  to.rhythm.gain = from.rhythm_gain;
  to.rhythm.smoothing_rad = from.rhythm_smoothing_rad;
  to.moving_shoulder = from.moving_shoulder != 0;
  to.swivel_mode = static_cast<glenoid::SwivelMode>(from.swivel_mode);
  to.swivel_prescribed_rad = from.swivel_prescribed_rad;
  to.duration_s = from.duration_s;
  to.limits.lower = glenoid::Vec4(from.limits_lower_rad);
  to.limits.upper = glenoid::Vec4(from.limits_upper_rad);
  to.start_q = glenoid::Vec4(from.start_q_rad);
  return to;
}

glenoid_settings settings_of(const MotionSettings& from) noexcept {
  glenoid_settings to{};  // lengths 0: scaled from stature
  to.stature_m = from.subject.stature_m;
  to.mass_kg = from.subject.mass_kg;
  to.rhythm_model = static_cast<int>(from.rhythm.model);
  to.rhythm_gain = from.rhythm.gain;
  to.rhythm_smoothing_rad = from.rhythm.smoothing_rad;
  to.moving_shoulder = from.moving_shoulder ? 1 : 0;
  to.swivel_mode = static_cast<int>(from.swivel_mode);
  to.swivel_prescribed_rad = from.swivel_prescribed_rad;
  to.duration_s = from.duration_s;
  store(from.limits.lower, to.limits_lower_rad);
  store(from.limits.upper, to.limits_upper_rad);
  store(from.start_q, to.start_q_rad);
  return to;
}

glenoid_sample sample_of(const MotionSample& from) noexcept {
  glenoid_sample to;
  store(from.q, to.q_rad);
  store(from.dq, to.dq_rad_per_s);
  store(from.ddq, to.ddq_rad_per_s2);
  store(from.shoulder, to.shoulder_m);
  store(from.elbow, to.elbow_m);
  store(from.wrist, to.wrist_m);
  store(from.girdle, to.girdle);
  to.swivel_rad = from.swivel;
  to.progress = from.progress;
  to.energy_kg_m2 = from.energy;
  to.misalignment_m = from.misalignment;
  store(from.exo_q, to.exo_q_rad);
  store(from.exo_dq, to.exo_dq_rad_per_s);
  to.status = static_cast<int>(from.status);
  return to;
}

}  // namespace

void glenoid_default_settings(glenoid_settings* settings) {
  if (settings == nullptr) return;
  try {
    *settings = settings_of(MotionSettings());
  } catch (...) {  // nothing above throws today; the boundary holds whatever is added
    *settings = glenoid_settings{};
  }
}

glenoid_motion* glenoid_create(const glenoid_settings* settings, double start_time_s, char* message,
                               size_t message_size) {
  write_message("", message, message_size);
  if (settings == nullptr) {
    write_message("settings = NULL: must point to a glenoid_settings", message, message_size);
    return nullptr;
  }
  if (!std::isfinite(start_time_s)) {
    write_message("start_time is NaN or infinite, s: must be finite", message, message_size);
    return nullptr;
  }
  try {
    return new glenoid_motion{glenoid::MotionGenerator(settings_of(*settings), start_time_s)};
  } catch (const std::exception& error) {
    write_message(error.what(), message, message_size);
  } catch (...) {
    write_message("unknown exception", message, message_size);
  }
  return nullptr;
}

void glenoid_destroy(glenoid_motion* motion) { delete motion; }

glenoid_status glenoid_command(glenoid_motion* motion, double time_s, const double target_m[3], int enable, int stop) {
  if (motion == nullptr) return GLENOID_OUT_OF_RANGE;
  motion->refusal = nullptr;
  if (target_m == nullptr) {
    motion->refusal = "target = NULL: must point to three numbers, m";
    return GLENOID_OUT_OF_RANGE;
  }
  glenoid::MotionCommand command;
  command.target = glenoid::Vec3(target_m);
  command.enable = enable != 0;
  command.stop = stop != 0;
  if (!std::isfinite(time_s) || !command.target.allFinite()) {
    motion->refusal = std::isfinite(time_s) ? "target has a NaN or infinite component, m: must be finite"
                                            : "time is NaN or infinite, s: must be finite";
    return GLENOID_NOT_FINITE;
  }
  return status_of(motion->generator.command(time_s, command));
}

glenoid_status glenoid_sample_at(const glenoid_motion* motion, double time_s, glenoid_sample* out) {
  if (motion == nullptr || out == nullptr) return GLENOID_OUT_OF_RANGE;
  MotionSample sample;
  const Status status = motion->generator.sample(time_s, sample);
  if (status == Status::Ok) *out = sample_of(sample);
  return status_of(status);
}

const char* glenoid_message(const glenoid_motion* motion) {
  if (motion == nullptr) return "motion = NULL: must come from glenoid_create";
  return motion->refusal != nullptr ? motion->refusal : motion->generator.message();
}
