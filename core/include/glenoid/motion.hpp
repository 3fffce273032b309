#pragma once

#include <array>
#include <memory>
#include <optional>

#include "glenoid/exoskeleton.hpp"
#include "glenoid/hand_clock.hpp"
#include "glenoid/swivel.hpp"
#include "glenoid/timing.hpp"

namespace glenoid {

/// Axial factor whose paths are nearest to people's (docs/human-likeness.md).
inline constexpr double kHumanAxialFactor = 3.0;

/// The factor in use: a given one, and for 0 that of people where the posture is that of people, else the kinetic energy's.
constexpr double effective_axial_factor(double factor, SwivelMode mode) noexcept {
  if (factor != 0.0) return factor;
  return mode == SwivelMode::HumanPrior ? kHumanAxialFactor : 1.0;
}

/// Everything that is fixed before the first movement. Units SI and rad; T is the thorax frame of the person's own side
/// (x to the right for both arms: a left arm is mirrored inside).
struct MotionSettings {
  Subject subject;
  RhythmSettings rhythm;
  bool moving_shoulder = true;
  double axial_factor = 0.0;  ///< of turning in the metric (M5, M6), 1..5; 1 = the kinetic energy; 0 = effective_axial_factor
  SwivelMode swivel_mode = SwivelMode::MinimumEnergy;
  double swivel_prescribed_rad = 0.2;
  PosturePriorCoefficients posture_prior{};  ///< used by HumanPrior, which is anchored at start_q
  double duration_s = 1.5;                   ///< of each movement; may be changed between movements
  TimingLaw timing = TimingLaw::MinimumJerkRiemannian;
  JointLimits limits;
  Vec4 start_q = Vec4(15.0, -30.0, 30.0, 60.0) * (kPi / 180.0);
  std::optional<Vec3> shoulder_start_m;  ///< measured glenohumeral centre at start_q: the rhythm is anchored there
  ExoSettings exo;
};

/// What the arm is doing. Numbers are those of the FMU's `status` and fixed for life.
enum class MotionStatus : int {
  Idle = 1,
  Moving = 2,
  Arrived = 3,
  Stopped = 4,
  TargetUnreachable = 5,
  LimitsInfeasible = 6,
  ExoInfeasible = 7,
  SolverFailed = 8,
};

/// Short name, as the FMU's enumeration item. Never null.
const char* to_string(MotionStatus status) noexcept;

struct MotionCommand {
  Vec3 target = Vec3(0.20, 0.42, 0.25);
  bool enable = true;
  bool stop = false;
};

/// Everything that the generator knows about one instant; all finite, always.
struct MotionSample {
  Vec4 q, dq, ddq;  ///< (theta, eta, zeta, phi): rad, rad/s, rad/s^2
  Posture posture;
  Vec3 shoulder, elbow, wrist;  ///< m in T
  Vec3 girdle;                  ///< (phi_ed rad, phi_pr rad, d_SG m)
  double swivel = 0.0;          ///< rad
  double progress = 0.0;        ///< lambda, 0..1
  double energy = 0.0;          ///< of the path on lambda, kg.m2
  double misalignment = 0.0;    ///< m, moving centre against that of the start posture
  Vec6 exo_q, exo_dq, exo_ddq;  ///< rad, rad/s, rad/s^2, order of ExoJoint
  double exo_residual = 0.0;    ///< m, what the girdle's drives cannot reach
  MotionStatus status = MotionStatus::Idle;
};

/// Everything that changes while running, as plain values: saving and restoring is a copy.
struct MotionState;

/// Plans and samples movements of one arm: the facade that FMU, command line and bridge use.
///
/// Call order: construct, then command() and sample() with times that do not decrease. A movement starts when `enable` is
/// true, `stop` is false and the target differs from the last accepted one by more than 1 mm. A new target during a movement
/// re-plans without a jump in q, dq or ddq. A target that cannot be served brings the arm to rest along its path
/// and is reported in the status; it never moves a resting arm. Instances are independent; one thread per instance.
class MotionGenerator {
 public:
  /// @throws std::invalid_argument with one line per problem: variable, value, unit, rule.
  explicit MotionGenerator(const MotionSettings& settings, double start_time_s = 0.0);
  ~MotionGenerator();
  MotionGenerator(MotionGenerator&&) noexcept;
  MotionGenerator& operator=(MotionGenerator&&) noexcept;

  /// Takes the inputs that hold from time_s on. Ok also when the status becomes one of 5..8: the command was understood.
  /// @return NotFinite (nothing changes) @alloc none
  Status command(double time_s, const MotionCommand& command) noexcept;

  /// State of the arm at time_s (not before the last command). @return NotFinite, output unchanged. @alloc none
  Status sample(double time_s, MotionSample& out) const noexcept;

  /// Duration of the movements accepted from now on. @return NotFinite, OutOfRange (0.05..60 s).
  Status set_duration(double duration_s) noexcept;

  /// Path and certificate of the last accepted movement (order 0 before the first).
  [[nodiscard]] const GeodesicPath& path() const noexcept;
  [[nodiscard]] const Certificate& certificate() const noexcept;
  [[nodiscard]] const ArmModel& arm() const noexcept;
  [[nodiscard]] const ScaledArm& scaled_arm() const noexcept;
  [[nodiscard]] const MotionSettings& settings() const noexcept;
  /// One sentence about the last refused command ("" if none): what, value, unit, rule. Valid until the next command.
  [[nodiscard]] const char* message() const noexcept;

  [[nodiscard]] const MotionState& state() const noexcept;
  /// Takes a state saved from an instance with the same settings.
  /// @return OutOfRange if the state is not one (checked numbers, ranges), and then nothing changes.
  Status restore(const MotionState& state) noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct MotionState {
  static constexpr int kGuide = 32;
  double move_time_s = 0.0;      ///< when the current movement was accepted
  double duration_s = 1.0;       ///< of the current movement
  double next_duration_s = 1.0;  ///< of movements accepted from now on
  double stop_time_s = 0.0;      ///< when the controlled stop began
  double stop_duration_s = 0.0;
  double fade_duration_s = 0.0;  ///< 0: nothing of an earlier motion is left
  double fade_share = 0.0;       ///< share of the path, 0..1, that keeps the clock of the earlier motion (T3)
  int moving = 0;                ///< a movement was accepted
  int stopping = 0;
  int rest_status = 1;         ///< MotionStatus once at rest
  int target_known = 0;        ///< `target` was accepted and not given up since
  int refused = 0;             ///< `refused_target` was the last one refused
  int hand_timing = 0;         ///< 1: the hand clock below is in use; 2: the homing law
  Vec3 target = Vec3::Zero();  ///< last accepted, right-arm frame
  Vec3 refused_target = Vec3::Zero();
  /// Earlier motion fading out after a re-plan: body rates and accelerations at move_time_s (T3).
  Vec3 fade_w = Vec3::Zero(), fade_dw = Vec3::Zero();
  double fade_dphi = 0.0, fade_ddphi = 0.0;
  std::array<Vec4, kGuide + 1> guide_q{};  ///< unwrapped q at uniform times of the movement
  HandClock hand_clock;
  ExoGuide exo_guide;
  GeodesicPath path;
  Certificate certificate;
};

}  // namespace glenoid
