#include <algorithm>
#include <cmath>

#include "host/bridge/core/cia402.hpp"
#include "host/bridge/core/implementation.hpp"
#include "host/bridge/core/words.hpp"

namespace glenoid::bridge {
namespace {

constexpr std::int64_t kTellAgainNs = 1'000'000'000;
constexpr std::int64_t kStartWaitNs = 2'000'000'000;  // for a stream of setpoints after "start"
constexpr std::int64_t kResetLowNs = 50'000'000;      // controlword 00h before the rising edge of bit 7
constexpr std::int64_t kResetTryNs = 300'000'000;     // one try, edge and answer
constexpr int kResetTries = 3;
constexpr double kArrived = 1e-9;  // rad: rounding of the limiter's sums

}  // namespace

void Bridge::Implementation::become(State state) noexcept {
  if (state == state_) return;
  reporter_.report(Severity::Info, code(Notice::StateChanged), {}, code(state), code(state_), "%s -> %s", words(state_),
                   words(state));
  state_ = state;
}

void Bridge::Implementation::reject(Rejection reason) noexcept {
  ++setpoints_rejected_;
  last_rejection_ = reason;
  const Gate::Detail& detail = gate_.detail();
  const bool beyond = reason == Rejection::Position || reason == Rejection::Velocity || reason == Rejection::Step;
  if (beyond && state_ == State::Run && detail.joint >= 0 &&
      settings_.joints[static_cast<std::size_t>(detail.joint)].on_limit == OnLimit::Stop)
    trip(Fault::LimitExceeded, nodes_[static_cast<std::size_t>(detail.joint)].subject(), detail.value, detail.limit,
         words(reason));
  std::int64_t& told_ns = rejection_told_ns_[static_cast<std::size_t>(reason)];
  if (reason == Rejection::NotArmed || now_ns_ - told_ns < kTellAgainNs) return;
  told_ns = now_ns_;
  reporter_.report(Severity::Warning, code(Notice::SetpointRejected), {-1, 0, detail.joint}, detail.value, detail.limit,
                   "setpoint rejected: %s", words(reason));
}

void Bridge::Implementation::take(const Setpoint& setpoint) noexcept {
  const Gate::Command command{command_rad(), command_stamp(sync_ns_), state_ == State::Run || state_ == State::Hold,
                              blending_ || state_ == State::Hold};
  const Rejection reason = gate_.check(setpoint, now_ns_, command, clock_);
  if (reason != Rejection::None) {
    reject(reason);
    if (gate_.two_publishers() && armed())
      trip(Fault::TwoPublishers, {}, static_cast<double>(setpoint.sequence), static_cast<double>(gate_.sequence()),
           "sequence beside");
    return;
  }
  ++setpoints_accepted_;
  accepted_ns_ = now_ns_;
  resampler_.push(setpoint);
}

void Bridge::Implementation::advance() noexcept {
  switch (state_) {
    case State::Idle:
      arming_ ? advance_arming() : advance_idle();
      break;
    case State::Ready:
      advance_ready();
      break;
    case State::Run:
      advance_run();
      break;
    case State::Hold:
      advance_hold();
      break;
    case State::Stop:
    case State::Fault:
      advance_stopped();
      break;
  }
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    Joint& joint = joints_[j];
    if (!joint.held) {
      if (nodes_[j].has_feedback()) joint.target = nodes_[j].feedback().position_actual;
      command_rad_[j] = joint.measured_rad;
      joint.limiter.reset(joint.measured_rad);
      continue;
    }
    const auto counts = joint.scale.counts(joint.limiter.position_rad());
    if (counts && !stopped()) {
      joint.target = *counts;
      command_rad_[j] = joint.limiter.position_rad();
    } else if (!counts && !stopped()) {
      trip(Fault::CountOverflow, nodes_[j].subject(), joint.limiter.position_rad(), 0, "rad");
      advance_stopped();
    }
  }
}

/// Without power. A drive that is still enabled is shut down first; one whose reset was asked for gets its edge.
void Bridge::Implementation::advance_idle() noexcept {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    Joint& joint = joints_[j];
    const DriveState state = nodes_[j].state();
    joint.held = joint.held && state == DriveState::OperationEnabled;
    joint.controlword = state == DriveState::OperationEnabled ? cia402::kShutdown : cia402::kDisableVoltage;
    if (joint.reset_since_ns < 0) continue;
    if (!nodes_[j].has_feedback()) joint.reset_since_ns = now_ns_;  // not configured yet: the edge waits
    const std::int64_t since_ns = now_ns_ - joint.reset_since_ns;
    if (state != DriveState::Fault && state != DriveState::FaultReaction && nodes_[j].has_feedback()) {
      joint.reset_since_ns = -1;
    } else if (since_ns >= kResetTries * kResetTryNs) {
      joint.reset_since_ns = -1;
      reporter_.report(Severity::Warning, code(Notice::Refused), nodes_[j].subject(), kResetTries, 0,
                       "%s: stays in fault", settings_.joints[j].name.c_str());
    } else if (since_ns % kResetTryNs >= kResetLowNs) {
      joint.controlword = cia402::kFaultReset;
    }
  }
}

/// All drives to switched on, then all to operation enabled, then bit 12 of all: READY. Each step is confirmed.
void Bridge::Implementation::advance_arming() noexcept {
  const bool all_on = std::all_of(nodes_.begin(), nodes_.end(), [](const Node& node) {
    return node.state() == DriveState::SwitchedOn || node.state() == DriveState::OperationEnabled;
  });
  int progress = 0;
  bool done = true;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    Joint& joint = joints_[j];
    const DriveState state = nodes_[j].state();
    const bool follows = state == DriveState::OperationEnabled &&
                         (nodes_[j].feedback().statusword & cia402::kFollowsTarget) != 0;
    joint.controlword = cia402::towards_enabled(state, all_on);
    if (joint.controlword == cia402::kEnableOperation && !joint.held) {
      joint.held = true;  // from here on the target stands still
      joint.limiter.reset(joint.measured_rad);
    }
    progress += code(state) + (follows ? 1 : 0);
    done = done && follows;
  }
  if (progress != arming_progress_) {
    arming_progress_ = progress;
    progress_ns_ = now_ns_;
  }
  if (now_ns_ - progress_ns_ > settings_.state_timeout_ns || now_ns_ - arming_ns_ > 4 * settings_.state_timeout_ns) {
    const auto* slow = std::find_if(nodes_.data(), nodes_.data() + nodes_.size(),
                                    [](const Node& n) { return n.state() != DriveState::OperationEnabled; });
    const Node& node = slow == nodes_.data() + nodes_.size() ? nodes_.front() : *slow;
    trip(Fault::EnableTimeout, node.subject(), node.feedback().statusword, 0, cia402::words(node.state()).data());
    return advance_stopped();
  }
  if (!done) return;
  arming_ = false;
  session_ = (entropy_ & 0x7FFF'FFFF'FFFF'FFFF) | 1;  // never 0
  gate_.open(session_);
  clock_.reset();
  resampler_.clear();
  sent_rad_.fill(command_rad_);
  reporter_.report(Severity::Info, code(Notice::Armed), {}, 0, 0, "armed: all drives follow their targets");
  become(State::Ready);
}

void Bridge::Implementation::hold_still() noexcept {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    joints_[j].controlword = cia402::kEnableOperation;
    if (reaches(j)) joints_[j].limiter.brake();
  }
}

void Bridge::Implementation::advance_ready() noexcept {
  hold_still();
  if (start_since_ns_ < 0) return;
  Sample sample;
  const bool fresh = gate_.any() && now_ns_ - accepted_ns_ < settings_.hold_after_ns;
  const auto result = resampler_.sample(command_stamp(sync_ns_ + settings_.period_ns), sample);
  if (fresh && (result == Resampler::Result::Interpolated || result == Resampler::Result::Extrapolated)) {
    start_since_ns_ = -1;
    blending_ = true;
    reporter_.report(Severity::Info, code(Notice::Started), {}, static_cast<double>(gate_.sequence()), 0, "started");
    become(State::Run);
    follow(sample);
  } else if (now_ns_ - start_since_ns_ > kStartWaitNs) {
    start_since_ns_ = -1;
    refuse(Request::Start, "no setpoints of this session came");
  }
}

void Bridge::Implementation::follow(const Sample& sample) noexcept {
  bool arrived = true;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    Joint& joint = joints_[j];
    joint.controlword = cia402::kEnableOperation;
    arrived = arrived && reaches(j);
    if (!reaches(j)) continue;
    const std::uint8_t limited = joint.limiter.follow(sample.position_rad[j], sample.velocity_rad_per_s[j], blending_);
    arrived = arrived && std::abs(joint.limiter.position_rad() - sample.position_rad[j]) <= kArrived;
    if (limited == kWithinLimits || blending_) continue;
    ++joint.limited;
    if (settings_.joints[j].on_limit == OnLimit::Stop) {
      trip(Fault::LimitExceeded, nodes_[j].subject(), sample.position_rad[j], joint.limiter.position_rad(),
           "wanted and allowed rad");
      return advance_stopped();
    }
    if ((joint.limited_told & limited) == limited) continue;
    joint.limited_told |= limited;  // once a session
    reporter_.report(Severity::Warning, code(Notice::Limited), nodes_[j].subject(), sample.position_rad[j],
                     joint.limiter.position_rad(), "%s: command limited in%s%s%s", settings_.joints[j].name.c_str(),
                     (limited & kPositionLimited) != 0 ? " position" : "",
                     (limited & kVelocityLimited) != 0 ? " velocity" : "",
                     (limited & kAccelerationLimited) != 0 ? " acceleration" : "");
  }
  if (arrived) blending_ = false;
}

void Bridge::Implementation::advance_run() noexcept {
  const std::int64_t age_ns = now_ns_ - accepted_ns_;
  if (age_ns >= settings_.hold_after_ns) {
    reporter_.report(Severity::Warning, code(Notice::Held), {}, 1e-9 * static_cast<double>(age_ns),
                     1e-9 * static_cast<double>(settings_.hold_after_ns), "no setpoint for %.1f ms: holding",
                     1e-6 * static_cast<double>(age_ns));
    become(State::Hold);
    return advance_hold();
  }
  Sample sample;
  const auto result = resampler_.sample(command_stamp(sync_ns_ + settings_.period_ns), sample);
  if (result == Resampler::Result::Empty || result == Resampler::Result::TooEarly) return hold_still();
  follow(sample);
}

void Bridge::Implementation::advance_hold() noexcept {
  const std::int64_t age_ns = now_ns_ - accepted_ns_;
  if (!stopping_ && age_ns >= settings_.quick_stop_after_ns) {
    trip(Fault::StaleSetpoints, {}, 1e-9 * static_cast<double>(age_ns),
         1e-9 * static_cast<double>(settings_.quick_stop_after_ns), "seconds without a setpoint");
    return advance_stopped();
  }
  if (!stopping_ && age_ns < settings_.hold_after_ns) {
    reporter_.report(Severity::Info, code(Notice::Resumed), {}, 0, 0, "setpoints are back: following again");
    blending_ = true;
    become(State::Run);
    return advance_run();
  }
  hold_still();
  if (!stopping_ || !all_at_rest()) return;
  stopping_ = false;
  resampler_.clear();
  reporter_.report(Severity::Info, code(Notice::Stopped), {}, 0, 0, "at rest");
  become(State::Ready);
  if (disarm_at_rest_) disarm();
}

void Bridge::Implementation::advance_stopped() noexcept {
  const std::int64_t disarm_ns = std::max<std::int64_t>(0, settings_.disarm_after_ns - settings_.quick_stop_after_ns);
  if (powered_stop_ && now_ns_ - stopped_ns_ >= disarm_ns) {
    powered_stop_ = false;
    session_ = 0;
    reporter_.report(Severity::Info, code(Notice::Disarmed), {}, 0, 0, "disarmed");
  }
  for (Joint& joint : joints_) {
    joint.blind = joint.blind && powered_stop_;
    joint.controlword = powered_stop_ && !joint.blind ? cia402::kQuickStop : cia402::kDisableVoltage;
    joint.held = joint.held && powered_stop_;
  }
}

void Bridge::Implementation::disarm() noexcept {
  disarm_at_rest_ = false;
  session_ = 0;
  gate_.close();
  resampler_.clear();
  for (Joint& joint : joints_) joint.limited_told = 0;
  reporter_.report(Severity::Info, code(Notice::Disarmed), {}, 0, 0, "disarmed");
  become(State::Idle);
  advance_idle();
}

bool Bridge::Implementation::all_at_rest() const noexcept {
  return std::all_of(joints_.begin(), joints_.end(), [](const Joint& joint) { return joint.limiter.at_rest(); });
}

}  // namespace glenoid::bridge
