#include <cmath>

#include "host/bridge/core/implementation.hpp"
#include "host/bridge/core/words.hpp"

namespace glenoid::bridge {
namespace {

constexpr std::int64_t kCommandAgeNs = 1'000'000'000;  // older ones come from a recording

}  // namespace

void Bridge::Implementation::refuse(Request request, const char* why) noexcept {
  reporter_.report(Severity::Warning, code(Notice::Refused), {}, code(request), 0, "%s refused: %s", words(request),
                   why);
}

/// Stopping needs no token and no fresh stamp; everything else does.
void Bridge::Implementation::take(const Command& command) noexcept {
  if (command.request == Request::EStop) return estop("message");
  if (command.request == Request::Stop) return request_stop(false);
  if (command.time_ns < now_ns_ - kCommandAgeNs || command.time_ns > now_ns_ + kCommandAgeNs)
    return refuse(command.request, "stamp is not of now");
  if (shutting_down_) return refuse(command.request, "shutting down");
  if (command.request == Request::Arm) return request_arm();
  if (command.session != session_) return refuse(command.request, "token of another session");
  switch (command.request) {
    case Request::Start:
      return request_start();
    case Request::ResetFault:
      return request_reset();
    case Request::Disarm:
      return request_stop(true);
    default:
      return refuse(command.request, "not known");
  }
}

const char* Bridge::Implementation::obstacle_to_arming() const noexcept {
  if (stopped()) return "a stop is latched, reset it first";
  if (state_ != State::Idle || arming_) return "armed already";
  if (arming_obstacle_ != nullptr) return arming_obstacle_;
  if (local_estop_) return "the local e-stop is pressed";
  for (const BusMonitor& bus : buses_) {
    if (!bus.writable()) return "a bus is down";
    if (has_foreign_master(static_cast<std::size_t>(&bus - buses_.data()))) return "another master is on a bus";
    if (bus.purge_needed() || !bus.clear()) return "frames may still be queued and cannot be purged";
  }
  for (std::size_t j = 0; j < nodes_.size(); ++j) {
    if (!nodes_[j].operational()) return "not every drive is configured and operational";
    if (!nodes_[j].has_feedback() || nodes_[j].missed_in_a_row() >= settings_.feedback_misses)
      return "not every drive answers SYNC";
    if (nodes_[j].state() == DriveState::Fault || nodes_[j].state() == DriveState::FaultReaction)
      return "a drive is in fault, reset it first";
    if (joints_[j].power_since_ns >= 0) return "a drive still has power";
    const JointSettings& joint = settings_.joints[j];
    const double q = joints_[j].measured_rad;
    if (q < joint.lower_rad - joint.measured_margin_rad || q > joint.upper_rad + joint.measured_margin_rad)
      return "a joint is outside its limits";
  }
  return nullptr;
}

void Bridge::Implementation::request_arm() noexcept {
  if (const char* why = obstacle_to_arming()) return refuse(Request::Arm, why);
  arming_ = true;
  arming_progress_ = -1;
  progress_ns_ = arming_ns_ = now_ns_;
  for (Joint& joint : joints_) joint.held = false;
}

void Bridge::Implementation::request_start() noexcept {
  if (state_ != State::Ready) return refuse(Request::Start, "not READY");
  start_since_ns_ = now_ns_;
}

void Bridge::Implementation::request_stop(bool disarm_too) noexcept {
  start_since_ns_ = -1;
  if (arming_) {
    arming_ = false;
    disarm();
  } else if (state_ == State::Ready) {
    if (disarm_too) disarm();
  } else if (state_ == State::Run || state_ == State::Hold) {
    stopping_ = true;
    disarm_at_rest_ = disarm_at_rest_ || disarm_too;
    become(State::Hold);
  }
}

void Bridge::Implementation::request_reset() noexcept {
  if (armed() || arming_) return refuse(Request::ResetFault, "nothing is latched");
  if (local_estop_) return refuse(Request::ResetFault, "an e-stop is pressed");
  if (powered_stop_) return refuse(Request::ResetFault, "still stopping");
  for (BusMonitor& bus : buses_) {
    if (!bus.link_up()) return refuse(Request::ResetFault, "a link is down");
    if (bus.off())
      bus.restart();
    else
      bus.request_purge();
  }
  for (std::size_t j = 0; j < nodes_.size(); ++j) {
    const bool failed = nodes_[j].phase() == Node::Phase::Failed;
    if (joints_[j].lost || failed) nodes_[j].restart(now_ns_);
    joints_[j].lost = false;
    joints_[j].reset_since_ns = now_ns_;
  }
  reporter_.report(Severity::Info, code(Notice::FaultReset), {}, code(fault_), 0, "reset of: %s", words(fault_));
  fault_ = Fault::None;
  if (state_ != State::Idle) become(State::Idle);
}

void Bridge::Implementation::shut_down() noexcept {
  if (!shutting_down_) request_stop(true);
  shutting_down_ = true;
  if (armed() || powered_stop_) return;
  for (std::size_t j = 0; j < nodes_.size(); ++j)
    if (nodes_[j].phase() != Node::Phase::Release && nodes_[j].phase() != Node::Phase::Released &&
        nodes_[j].state() != DriveState::OperationEnabled)
      nodes_[j].release();
}

}  // namespace glenoid::bridge
