#include <algorithm>
#include <array>
#include <cmath>

#include "exo_shoulder.hpp"
#include "glenoid/exoskeleton.hpp"

namespace glenoid {
namespace {

constexpr double kResolution = 1e-5;        // rad: a worst value is not sought more closely than this
constexpr double kLimitRounding = 1e-9;     // rad: a joint this far beyond its limit still is on it
constexpr double kLargestStep = 0.5 * kPi;  // rad between samples: unwrapping is unambiguous below pi
constexpr int kMaxDepth = 15;               // bisections of one interval of the guide: 1e-6 of the motion
constexpr std::size_t kSamples = ExoGuide::kIntervals + 1;

/// Quantities that are followed along the motion: six joints and the angle between the first and the third axis.
constexpr int kTracks = 7, kAxisAngle = 6;
using Tracks = Eigen::Matrix<double, kTracks, 1>;

struct Sample {
  double s = 0.0;
  Tracks value = Tracks::Zero(), rate = Tracks::Zero();
};

/// Cubic through values and rates at the two ends of [0, h].
struct Hermite {
  double f0, d0, c2, c3, h;

  Hermite(const Sample& a, const Sample& b, int track) noexcept : f0(a.value[track]), d0(a.rate[track]), h(b.s - a.s) {
    const double slope = (b.value[track] - f0) / h, d1 = b.rate[track];
    c2 = (3.0 * slope - 2.0 * d0 - d1) / h;
    c3 = (d0 + d1 - 2.0 * slope) / (h * h);
  }
  [[nodiscard]] double operator()(double x) const noexcept { return f0 + x * (d0 + x * (c2 + x * c3)); }
  /// Places in (0, h) where the slope vanishes; NaN where there is none.
  [[nodiscard]] std::array<double, 2> turning_points() const noexcept {
    const double root = std::sqrt(c2 * c2 - 3.0 * c3 * d0);
    const double sum = -(c2 + std::copysign(root, c2));  // stable pair of roots of d0 + 2 c2 x + 3 c3 x^2
    return {inside(d0 / sum), inside(sum / (3.0 * c3))};
  }

 private:
  [[nodiscard]] double inside(double x) const noexcept { return x > 0.0 && x < h ? x : std::nan(""); }
};

/// Follows one assembly along one motion.
class Walk {
 public:
  Walk(const ExoModel& model, const JetSource& motion, ExoBranch branch, ExoPathCheck& out) noexcept
      : model_(model), motion_(motion), branch_(branch), out_(out) {}

  Status run(const Vec3& start_q) noexcept {
    begin(start_q);
    std::array<Sample, kSamples> samples;
    Vec3 near_q = start_q;
    for (std::size_t k = 0; k < kSamples; ++k) {
      samples[k] = evaluate(static_cast<double>(k) / ExoGuide::kIntervals, near_q);
      if (failure_ != Status::Ok) return failure_;
      near_q = shoulder(samples[k]);
    }
    out_.start_step_rad = (shoulder(samples[0]) - start_q).cwiseAbs().maxCoeff();
    prime_limits(samples);
    store(0, samples[0]);
    for (std::size_t k = 1; k < kSamples; ++k) {
      refine(samples[k - 1], samples[k], 0);
      if (failure_ != Status::Ok) return failure_;
      store(k, samples[k]);
    }
    return verdict();
  }

 private:
  static Vec3 shoulder(const Sample& sample) noexcept { return sample.value.segment<3>(kShoulder1); }

  void begin(const Vec3& start_q) noexcept {
    out_ = ExoPathCheck();
    out_.guide = resting_guide({branch_, start_q, 0.0});
    out_.margin_rad = out_.singularity_rad = out_.limit_margin_rad = kNoExoLimit;
    out_.residual_m = -1.0;
  }

  void store(std::size_t k, const Sample& sample) noexcept {
    for (std::size_t i = 0; i < 3; ++i) out_.guide.shoulder_q[k][i] = sample.value[kShoulder1 + static_cast<int>(i)];
  }

  /// Joint limits of all samples at once, so that little is left to refine; only where their unwrapping is sure.
  void prime_limits(const std::array<Sample, kSamples>& samples) noexcept {
    for (std::size_t k = 1; k < kSamples; ++k) {
      if (largest_step(samples[k - 1], samples[k]) > kLargestStep) return record_limits(samples[0]);
    }
    for (const Sample& sample : samples) record_limits(sample);
  }

  /// T at s. Distances count at once, joint limits when the unwrapping is sure.
  Sample evaluate(double s, const Vec3& near_q) noexcept {
    PostureJet posture;
    PointJet centre;
    motion_.evaluate(motion_.context, s, posture, centre);
    ExoSample exo;
    const Status status = map_to_exo(model_, branch_, posture, centre, near_q, exo);
    Sample sample;
    sample.s = s;
    if (status != Status::Ok && status != Status::ExoInfeasible) {
      failure_ = status;
      return sample;
    }
    sample.value << exo.q, exo.axis_angle_rad;
    sample.rate << exo.dq, exo.axis_angle_rate;
    ++out_.samples;
    record(s, exo);
    return sample;
  }

  void record(double s, const ExoSample& exo) noexcept {
    if (exo.margin_rad < out_.margin_rad) out_.margin_rad = exo.margin_rad, out_.margin_at = s;
    if (exo.singularity_rad < out_.singularity_rad) out_.singularity_rad = exo.singularity_rad, out_.singularity_at = s;
    if (exo.residual_m > out_.residual_m) out_.residual_m = exo.residual_m, out_.residual_at = s;
  }

  void record_limits(const Sample& sample) noexcept {
    for (int i = 0; i < 6; ++i) {
      record_limit(sample.s, i, false, sample.value[i] - model_.settings().lower[i]);
      record_limit(sample.s, i, true, model_.settings().upper[i] - sample.value[i]);
    }
  }

  void record_limit(double s, int joint, bool upper, double margin) noexcept {
    if (!has_limit(joint, upper) || !(margin < out_.limit_margin_rad)) return;
    out_.limit_margin_rad = margin;
    out_.limit_at = s;
    out_.limit_joint = joint;
    out_.limit_at_upper = upper;
  }

  [[nodiscard]] bool has_limit(int joint, bool upper) const noexcept {
    return upper ? model_.settings().upper[joint] < kNoExoLimit : model_.settings().lower[joint] > -kNoExoLimit;
  }

  /// Value of a track below (above, for `upper`) which a worst value would sink by the resolution; infinite if none.
  [[nodiscard]] double threshold(int track, bool upper) const noexcept {
    const double sign = upper ? -1.0 : 1.0;
    if (track == kAxisAngle) {
      const double end = upper ? model_.shoulder().most : model_.shoulder().least;
      return end + sign * (out_.margin_rad - kResolution);
    }
    if (!has_limit(track, upper)) return -sign * HUGE_VAL;
    const double limit = upper ? model_.settings().upper[track] : model_.settings().lower[track];
    return limit + sign * (out_.limit_margin_rad - kResolution);
  }

  /// Goes over [a, b] once more: b is unwrapped against what lies between.
  void refine(const Sample& a, Sample& b, int depth) noexcept {
    Sample middle = evaluate(0.5 * (a.s + b.s), shoulder(a));
    if (failure_ != Status::Ok) return;
    b.value.segment<3>(kShoulder1) = unwrapped(shoulder(b), shoulder(middle));
    bool split = largest_step(a, middle) > kLargestStep || largest_step(middle, b) > kLargestStep;
    if (!split || depth == kMaxDepth) {
      record_limits(middle);
      record_limits(b);
    }
    for (int track = 0; track < kTracks && !split; ++track) split = unresolved(a, middle, b, track);
    if (!split || depth == kMaxDepth) return;
    refine(a, middle, depth + 1);
    if (failure_ == Status::Ok) refine(middle, b, depth + 1);
  }

  static double largest_step(const Sample& a, const Sample& b) noexcept {
    return (shoulder(b) - shoulder(a)).cwiseAbs().maxCoeff();
  }

  /// Whether a track may pass its threshold somewhere on [a, b], and the cubics do not tell where well enough.
  /// Where they do, the turning point is evaluated exactly.
  bool unresolved(const Sample& a, const Sample& middle, const Sample& b, int track) noexcept {
    const double low = threshold(track, false), high = threshold(track, true);
    if (std::isinf(low) && std::isinf(high)) return false;
    const double error = std::abs(middle.value[track] - Hermite(a, b, track)(middle.s - a.s));
    for (const auto& [from, to] : {std::pair(&a, &middle), std::pair(&middle, &b)}) {
      const Hermite cubic(*from, *to, track);
      const double least = std::min(from->value[track], to->value[track]),
                   most = std::max(from->value[track], to->value[track]);
      if (error > kResolution && (least - error < low || most + error > high)) return true;
      for (const double x : cubic.turning_points()) {
        if (std::isnan(x)) continue;
        const double value = cubic(x);
        if (value - error >= low && value + error <= high) continue;
        if (error > kResolution) return true;
        record_limits(evaluate(from->s + x, shoulder(*from)));
      }
    }
    return false;
  }

  Status verdict() noexcept {
    if (out_.margin_rad < -kFeasibleRounding) {
      out_.refusal = ExoRefusal::OutOfReach;
    } else if (out_.singularity_rad < model_.settings().min_singularity_rad) {
      out_.refusal = ExoRefusal::Singular;
    } else if (out_.limit_margin_rad < -kLimitRounding) {
      out_.refusal = ExoRefusal::JointLimit;
    }
    return out_.refusal == ExoRefusal::None ? Status::Ok : Status::ExoInfeasible;
  }

  const ExoModel& model_;
  const JetSource& motion_;
  ExoBranch branch_;
  ExoPathCheck& out_;
  Status failure_ = Status::Ok;
};

/// Joints of the other assembly at the start of the motion, where the device would have to be.
Vec3 other_start(const ExoModel& model, const JetSource& motion, ExoBranch branch, const Vec3& near_q) noexcept {
  PostureJet posture;
  PointJet centre;
  motion.evaluate(motion.context, 0.0, posture, centre);
  ExoSample exo;
  const Status status = map_to_exo(model, branch, posture, centre, middle_of_limits(model.settings(), near_q), exo);
  return status == Status::Ok ? Vec3(exo.q.segment<3>(kShoulder1)) : near_q;
}

struct PathContext {
  const GeodesicPath* path;
  const Rhythm* rhythm;
};

void evaluate_on_path(const void* context, double s, PostureJet& posture, PointJet& centre) noexcept {
  const auto& on = *static_cast<const PathContext*>(context);
  evaluate_path(*on.path, s, posture);
  shoulder_centre_jet(*on.rhythm, posture, centre);
}

}  // namespace

ExoGuide resting_guide(const ExoStart& start) noexcept {
  ExoGuide guide;
  guide.branch = start.branch;
  guide.shoulder_q.fill({start.shoulder_q[0], start.shoulder_q[1], start.shoulder_q[2]});
  return guide;
}

Vec3 guide_angles(const ExoGuide& guide, double s) noexcept {
  const double place = std::clamp(s, 0.0, 1.0) * ExoGuide::kIntervals;
  const auto k = std::min(static_cast<std::size_t>(place), static_cast<std::size_t>(ExoGuide::kIntervals - 1));
  const double fraction = place - static_cast<double>(k);
  Vec3 out;
  for (std::size_t i = 0; i < 3; ++i) {
    const double a = guide.shoulder_q[k][i], b = guide.shoulder_q[k + 1][i];
    out[static_cast<int>(i)] = a + fraction * (b - a);
  }
  return out;
}

Status check_motion(const ExoModel& model, const JetSource& motion, const ExoStart& start, bool try_other_branch,
                    ExoPathCheck& out) noexcept {
  if (!start.shoulder_q.allFinite()) return Status::NotFinite;
  const Status status = Walk(model, motion, start.branch, out).run(start.shoulder_q);
  // Reach and singularity are the same for both branches.
  if (!try_other_branch || status == Status::Ok || out.refusal != ExoRefusal::JointLimit) return status;
  const ExoBranch branch = start.branch == ExoBranch::First ? ExoBranch::Second : ExoBranch::First;
  ExoPathCheck other;
  const Status answer = Walk(model, motion, branch, other).run(other_start(model, motion, branch, start.shoulder_q));
  if (answer != Status::Ok) return status;
  other.other_branch = true;
  other.start_step_rad = (guide_angles(other.guide, 0.0) - start.shoulder_q).cwiseAbs().maxCoeff();
  out = other;
  return answer;
}

Status check_path(const ExoModel& model, const GeodesicPath& path, const Rhythm& rhythm, const ExoStart& start,
                  bool try_other_branch, ExoPathCheck& out) noexcept {
  const PathContext context{&path, &rhythm};
  return check_motion(model, {&evaluate_on_path, &context}, start, try_other_branch, out);
}

}  // namespace glenoid
