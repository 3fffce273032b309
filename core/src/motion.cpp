#include "glenoid/motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "glenoid/mass_matrix.hpp"
#include "motion_jet.hpp"
#include "motion_settings.hpp"

namespace glenoid {
namespace {

constexpr double kSameTarget = 1e-3;  // m
constexpr double kStopShare = 0.3;   // of the movement's duration: its peak deceleration is then 1.6 of the natural one
constexpr double kLeastFade = 0.05;  // s
constexpr double kRestRate = 1e-9;   // rad/s below which nothing has to fade out

/// Time that the movement under way still needs, by the clock of its larger part.
double remaining_time(const MotionState& s, double time) {
  if (s.stopping != 0) return s.stop_time_s + s.stop_duration_s - time;
  const double early = s.move_time_s + s.fade_duration_s - time;
  return s.fade_share > 0.5 && early > kLeastFade ? early : s.move_time_s + s.duration_s - time;
}

}  // namespace

struct MotionGenerator::Impl {
  MotionSettings settings;
  ScaledArm scaled;
  ArmModel arm;
  Vec3 start_centre;  ///< glenohumeral centre at the start posture, right-arm frame
  ExoModel exo;
  PosturePrior prior;
  ReachPlanner planner;
  ReachPlan plan;
  MotionState state, next;
  ExoPathCheck exo_check;
  std::array<char, 256> message{};

  Impl(const MotionSettings& s, double start_time);

  [[nodiscard]] bool left() const { return settings.subject.left_arm; }
  void accept(double time, const Vec3& target);
  void refuse(double time, const Vec3& target, MotionStatus status);
  void begin_stop(double time, MotionStatus status_after);
  Status make_plan(double time, const Posture& start, const Vec3& target);
  void start_movement(double time, const PostureJet& jet);
  [[nodiscard]] double shared_way(double time, const Posture& now) const;
  void build_guide(const Vec4& near_q);
  void check_limits_on_the_way();
  Status check_exo(double time);
  void say_exo_refusal(const Vec3& target);
  void centre_of(const PostureJet& jet, PointJet& out) const { shoulder_centre_jet(arm.rhythm, jet, out); }
  [[nodiscard]] double guide_share(double virtual_time) const;
};

MotionGenerator::Impl::Impl(const MotionSettings& s, double start_time)
    : settings((glenoid::validate(s, start_time), s)),
      scaled(scale_subject(s.subject)),
      arm(build_arm(s, scaled)),
      start_centre(arm.rhythm.position(posture_from_angles(s.start_q).R_TU.col(2))),
      exo(s.exo, start_centre),
      prior(s.posture_prior, arm, posture_from_angles(s.start_q)) {
  validate_start(arm, s.start_q);
  const Posture start = posture_from_angles(s.start_q);
  state.move_time_s = start_time;
  state.duration_s = state.next_duration_s = s.duration_s;
  state.rest_status = static_cast<int>(MotionStatus::Idle);
  state.guide_q.fill(s.start_q);
  make_constant_path(start, state.path);
  ExoStart device;
  const Status fits = choose_branch(exo, start, start_centre, std::nullopt, device);
  state.exo_guide = resting_guide(device);
  if (fits == Status::ExoInfeasible) state.rest_status = static_cast<int>(MotionStatus::ExoInfeasible);
}

/// Position of a time on the guide tables, 0..1.
double MotionGenerator::Impl::guide_share(double virtual_time) const {
  return state.moving != 0 ? std::clamp((virtual_time - state.move_time_s) / state.duration_s, 0.0, 1.0) : 0.0;
}

void MotionGenerator::Impl::begin_stop(double time, MotionStatus status_after) {
  if (state.stopping == 0) {
    state.stopping = 1;
    state.stop_time_s = time;
    state.stop_duration_s = kStopShare * state.duration_s;
  }
  state.rest_status = static_cast<int>(status_after);
}

void MotionGenerator::Impl::refuse(double time, const Vec3& target, MotionStatus status) {
  if (!at_rest(state, time)) {
    begin_stop(time, status);
    state.target_known = 0;
  }
  state.rest_status = static_cast<int>(status);
  state.refused = 1;
  state.refused_target = target;
}

Status MotionGenerator::Impl::make_plan(double time, const Posture& start, const Vec3& target) {
  if (settings.swivel_mode == SwivelMode::Prescribed) {
    return planner.plan_prescribed(arm, start, target, settings.swivel_prescribed_rad, plan);
  }
  if (settings.swivel_mode == SwivelMode::HumanPrior) {
    return planner.plan_human_prior(arm, start, target, prior, plan);
  }
  if (at_rest(state, time)) return planner.plan_minimum_energy(arm, start, target, plan);
  PostureJet jet;
  ScalarJet progress;
  motion_jet(state, time, jet, progress);
  return planner.replan_minimum_energy(arm, start, target, state.path, progress.value, plan);
}

/// Share of the new way, 0..1, that the movement under way would have gone anyway (T3): that part keeps its clock.
double MotionGenerator::Impl::shared_way(double time, const Posture& now) const {
  if (state.stopping != 0) return 0.0;
  PostureJet jet;
  ScalarJet progress;
  movement_jet(state, time, jet, &progress);
  PostureRates earlier, planned, unused;
  evaluate_path(state.path, progress.value, jet);
  body_rates(jet, earlier, unused);
  evaluate_path(plan.path, 0.0, jet);
  body_rates(jet, planned, unused);
  const Vec4 a = (1.0 - progress.value) * (Vec4() << earlier.w_TU_U, earlier.phi).finished();
  const Vec4 b = (Vec4() << planned.w_TU_U, planned.phi).finished();
  const Vec4 p = body_mass_matrix(arm, now) * b;
  const double whole = b.dot(p);
  return whole > 0.0 ? std::clamp(a.dot(p) / whole, 0.0, 1.0) : 0.0;
}

/// Fills `next` with the planned path, the earlier motion fading out.
void MotionGenerator::Impl::start_movement(double time, const PostureJet& jet) {
  next.move_time_s = time;
  next.duration_s = state.next_duration_s;
  next.next_duration_s = state.next_duration_s;
  next.moving = 1;
  next.stopping = 0;
  next.rest_status = static_cast<int>(MotionStatus::Arrived);
  next.refused = 0;
  next.target_known = 1;
  next.path = plan.path;
  next.certificate = plan.certificate;
  PostureRates v, a;
  body_rates(jet, v, a);
  next.fade_w = v.w_TU_U, next.fade_dw = a.w_TU_U, next.fade_dphi = v.phi, next.fade_ddphi = a.phi;
  const bool fades = !at_rest(state, time) && std::max(v.w_TU_U.cwiseAbs().maxCoeff(), std::abs(v.phi)) > kRestRate;
  next.fade_duration_s = fades ? std::clamp(remaining_time(state, time), kLeastFade, next.duration_s) : 0.0;
  next.fade_share = fades ? shared_way(time, jet_posture(jet)) : 0.0;
  next.hand_timing = settings.timing == TimingLaw::MinimumJerkHand && fit_hand_clock(arm, next.path, next.hand_clock)
                         ? 1
                         : 0;
  if (settings.timing == TimingLaw::MinimumJerkHoming) next.hand_timing = 2;
}

/// Unwrapped angles along the movement, so that q is a continuous and pure function of time.
void MotionGenerator::Impl::build_guide(const Vec4& near_q) {
  Vec4 near = near_q;
  for (int k = 0; k <= MotionState::kGuide; ++k) {
    PostureJet jet;
    movement_jet(next, next.move_time_s + next.duration_s * k / MotionState::kGuide, jet, nullptr);
    Vec4 dq, ddq;
    angles_from_jet(jet, near, next.guide_q[static_cast<std::size_t>(k)], dq, ddq);
    near = next.guide_q[static_cast<std::size_t>(k)];
  }
}

/// A fading earlier motion leaves the path: the limits are those of what the arm will really do.
void MotionGenerator::Impl::check_limits_on_the_way() {
  if (next.fade_duration_s == 0.0) return;
  LimitViolation& v = next.certificate.limits;
  for (int k = 0; k <= MotionState::kGuide; ++k) {
    const double share = static_cast<double>(k) / MotionState::kGuide;
    PostureJet jet;
    ScalarJet progress;
    movement_jet(next, next.move_time_s + next.duration_s * share, jet, &progress);
    const LimitMargin m = limit_margin(arm.limits, jet_posture(jet));
    if (m.margin_rad < v.worst.margin_rad) v.worst = m, v.lambda = progress.value;
  }
  v.any = v.worst.margin_rad < -1e-6;
}

Status MotionGenerator::Impl::check_exo(double time) {
  struct Context {
    const Impl* self;
  } const context{this};
  JetSource source;
  source.context = &context;
  source.evaluate = [](const void* c, double s, PostureJet& posture, PointJet& centre) noexcept {
    const Impl& self = *static_cast<const Context*>(c)->self;
    const double T = self.next.duration_s;
    movement_jet(self.next, self.next.move_time_s + s * T, posture, nullptr);
    posture.dx *= T, posture.dz *= T, posture.dphi *= T;
    posture.ddx *= T * T, posture.ddz *= T * T, posture.ddphi *= T * T;
    self.centre_of(posture, centre);
  };
  const double virtual_time = state.stopping != 0 ? stopping_clock(time, state.stop_time_s, state.stop_duration_s).value
                                                  : time;
  const ExoStart device{state.exo_guide.branch, guide_angles(state.exo_guide, guide_share(virtual_time)), 0.0};
  const Status status = check_motion(exo, source, device, false, exo_check);
  if (status == Status::Ok) next.exo_guide = exo_check.guide;
  return status;
}

/// Why and where the device cannot follow, for the message.
void MotionGenerator::Impl::say_exo_refusal(const Vec3& target) {
  constexpr double kDegree = kPi / 180.0;
  const ExoPathCheck& c = exo_check;
  const Vec3 t = mirror_if(left(), target);
  const auto say = [this, &t](const char* what, double value, double at) {
    std::snprintf(
        message.data(), message.size(),
        "target = (%.4f, %.4f, %.4f) m: the exoskeleton cannot follow, %s %.2f deg at %.0f %% of the movement", t.x(),
        t.y(), t.z(), what, value / kDegree, 100.0 * at);
  };
  switch (c.refusal) {
    case ExoRefusal::Singular:
      return say("its distance from the singular set is only", c.singularity_rad, c.singularity_at);
    case ExoRefusal::JointLimit: {
      std::array<char, 64> what{};
      std::snprintf(what.data(), what.size(), "%s is beyond its %s limit by", exo_joint_name(c.limit_joint),
                    c.limit_at_upper ? "upper" : "lower");
      return say(what.data(), -c.limit_margin_rad, c.limit_at);
    }
    default:
      return say("out of reach of its axes by", -c.margin_rad, c.margin_at);
  }
}

void MotionGenerator::Impl::accept(double time, const Vec3& target) {
  PostureJet jet;
  ScalarJet progress;
  motion_jet(state, time, jet, progress);
  const Posture start = jet_posture(jet);
  const Status planned = make_plan(time, start, target);
  message[0] = '\0';
  const auto say = [this, &target](const char* text, double value, const char* unit) {
    const Vec3 t = mirror_if(left(), target);
    std::snprintf(message.data(), message.size(), "target = (%.6g, %.6g, %.6g) m: %s %.6g %s", t.x(), t.y(), t.z(),
                  text, value, unit);
  };
  constexpr double kDegree = kPi / 180.0;
  if (planned == Status::TargetUnreachable) {
    say("out of reach by", -plan.reach_margin_m, "m");
    return refuse(time, target, MotionStatus::TargetUnreachable);
  }
  if (planned == Status::LimitsInfeasible) {
    say("no posture within the joint limits; the best one misses by", -plan.best_margin.margin_rad / kDegree, "deg");
    return refuse(time, target, MotionStatus::LimitsInfeasible);
  }
  if (planned != Status::Ok) {
    say("the boundary-value solver did not converge, status", static_cast<double>(planned), "");
    return refuse(time, target, MotionStatus::SolverFailed);
  }
  const double virtual_time = state.stopping != 0 ? stopping_clock(time, state.stop_time_s, state.stop_duration_s).value
                                                  : time;
  const auto guide = static_cast<std::size_t>(std::lround(guide_share(virtual_time) * MotionState::kGuide));
  start_movement(time, jet);
  build_guide(state.guide_q[guide]);
  check_limits_on_the_way();
  const Status device = check_exo(time);
  if (device != Status::Ok) {
    say_exo_refusal(target);
    return refuse(time, target, MotionStatus::ExoInfeasible);
  }
  next.target = target;
  state = next;
}

const char* to_string(MotionStatus status) noexcept {
  switch (status) {
    case MotionStatus::Idle:
      return "Idle";
    case MotionStatus::Moving:
      return "Moving";
    case MotionStatus::Arrived:
      return "Arrived";
    case MotionStatus::Stopped:
      return "Stopped";
    case MotionStatus::TargetUnreachable:
      return "TargetUnreachable";
    case MotionStatus::LimitsInfeasible:
      return "LimitsInfeasible";
    case MotionStatus::ExoInfeasible:
      return "ExoInfeasible";
    case MotionStatus::SolverFailed:
      return "SolverFailed";
  }
  return "Unknown";
}

MotionGenerator::MotionGenerator(const MotionSettings& settings, double start_time_s)
    : impl_(std::make_unique<Impl>(settings, start_time_s)) {}
MotionGenerator::~MotionGenerator() = default;
MotionGenerator::MotionGenerator(MotionGenerator&&) noexcept = default;
MotionGenerator& MotionGenerator::operator=(MotionGenerator&&) noexcept = default;

Status MotionGenerator::command(double time_s, const MotionCommand& c) noexcept {
  if (!std::isfinite(time_s) || !c.target.allFinite()) return Status::NotFinite;
  MotionState& s = impl_->state;
  if (c.stop) {
    if (!at_rest(s, time_s)) impl_->begin_stop(time_s, MotionStatus::Stopped);
    return Status::Ok;
  }
  if (!c.enable) return Status::Ok;
  const Vec3 target = mirror_if(impl_->left(), c.target);
  if (s.refused != 0 && (target - s.refused_target).norm() <= kSameTarget) return Status::Ok;
  if (s.target_known != 0 && (target - s.target).norm() <= kSameTarget) {
    if (s.refused != 0 && at_rest(s, time_s)) {  // back to where the arm already is
      s.refused = 0;
      s.rest_status = static_cast<int>(s.stopping != 0 ? MotionStatus::Stopped : MotionStatus::Arrived);
      impl_->message[0] = '\0';
    }
    return Status::Ok;
  }
  impl_->accept(time_s, target);
  return Status::Ok;
}

Status MotionGenerator::sample(double time_s, MotionSample& out) const noexcept {
  if (!std::isfinite(time_s)) return Status::NotFinite;
  const Impl& m = *impl_;
  const MotionState& s = m.state;
  PostureJet jet;
  ScalarJet progress;
  motion_jet(s, time_s, jet, progress);
  const double virtual_time = s.stopping != 0 ? stopping_clock(time_s, s.stop_time_s, s.stop_duration_s).value : time_s;
  const double share = m.guide_share(virtual_time);
  const double place = share * MotionState::kGuide;
  const auto k = static_cast<std::size_t>(std::min(std::floor(place), MotionState::kGuide - 1.0));
  const double f = place - static_cast<double>(k);
  angles_from_jet(jet, (1.0 - f) * s.guide_q[k] + f * s.guide_q[k + 1], out.q, out.dq, out.ddq);
  out.posture = jet_posture(jet);

  PointJet centre;
  m.centre_of(jet, centre);
  const Vec3 zf = -std::sin(jet.phi) * out.posture.R_TU.col(1) + std::cos(jet.phi) * jet.z;
  const Vec3 elbow = centre.p - m.arm.upper_arm.length_m * jet.z;
  const ArmPoints points{centre.p, elbow, elbow - m.arm.forearm.length_m * zf};
  out.shoulder = mirror_if(m.left(), points.shoulder);
  out.elbow = mirror_if(m.left(), points.elbow);
  out.wrist = mirror_if(m.left(), points.wrist);
  out.girdle = girdle_coordinates(centre.p);
  out.swivel = swivel_angle(points);
  out.progress = progress.value;
  out.energy = s.path.energy;
  out.misalignment = (centre.p - m.start_centre).norm();

  ExoSample exo{};
  const Status mapped = map_to_exo(m.exo, s.exo_guide.branch, jet, centre, guide_angles(s.exo_guide, share), exo);
  out.exo_q = exo.q;
  out.exo_dq = exo.dq;
  out.exo_ddq = exo.ddq;
  out.exo_residual = exo.residual_m;
  (void)mapped;  // an infeasible start is the status; the sample is then the edge of the feasible set
  out.status = at_rest(s, time_s) ? static_cast<MotionStatus>(s.rest_status) : MotionStatus::Moving;
  return Status::Ok;
}

Status MotionGenerator::set_duration(double duration_s) noexcept {
  if (!std::isfinite(duration_s)) return Status::NotFinite;
  if (duration_s < kLeastDuration || duration_s > kMostDuration) return Status::OutOfRange;
  impl_->state.next_duration_s = duration_s;
  return Status::Ok;
}

const GeodesicPath& MotionGenerator::path() const noexcept { return impl_->state.path; }
const Certificate& MotionGenerator::certificate() const noexcept { return impl_->state.certificate; }
const ArmModel& MotionGenerator::arm() const noexcept { return impl_->arm; }
const ScaledArm& MotionGenerator::scaled_arm() const noexcept { return impl_->scaled; }
const MotionSettings& MotionGenerator::settings() const noexcept { return impl_->settings; }
const char* MotionGenerator::message() const noexcept { return impl_->message.data(); }
const MotionState& MotionGenerator::state() const noexcept { return impl_->state; }

Status MotionGenerator::restore(const MotionState& s) noexcept {
  if (!is_valid(s)) return Status::OutOfRange;
  impl_->state = s;
  return Status::Ok;
}

}  // namespace glenoid
