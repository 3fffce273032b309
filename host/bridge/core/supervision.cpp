#include <algorithm>
#include <cmath>

#include "host/bridge/core/canopen.hpp"
#include "host/bridge/core/cia402.hpp"
#include "host/bridge/core/implementation.hpp"
#include "host/bridge/core/pdo_table.hpp"
#include "host/bridge/core/words.hpp"

namespace glenoid::bridge {
namespace {

bool has_power(DriveState state) noexcept {
  return state == DriveState::OperationEnabled || state == DriveState::QuickStopActive;
}

constexpr std::int64_t kForeignNs = 1'000'000'000;  // without orders of somebody else, until he counts as gone

}  // namespace

void Bridge::Implementation::supervise(const Inputs& inputs) noexcept {
  if (inputs.local_estop) estop("local input");
  const std::int64_t gap_ns = last_step_ns_ < 0 ? 0 : now_ns_ - last_step_ns_;
  if ((armed() || arming_) && gap_ns > settings_.quick_stop_after_ns)
    trip(Fault::LoopStalled, {}, 1e-9 * static_cast<double>(gap_ns),
         1e-9 * static_cast<double>(settings_.quick_stop_after_ns), "seconds without a cycle");
  supervise_buses();
  supervise_masters();
  for (std::size_t j = 0; j < nodes_.size(); ++j) supervise_node(j);
  for (std::size_t j = 0; j < nodes_.size(); ++j) supervise_power(j);
  if (!armed() && !arming_) return;
  supervise_answers();
  for (std::size_t j = 0; j < nodes_.size(); ++j) supervise_motion(j);
}

void Bridge::Implementation::supervise_buses() noexcept {
  for (std::size_t b = 0; b < buses_.size(); ++b) {
    const BusMonitor& bus = buses_[b];
    const Subject subject{static_cast<std::int32_t>(b), 0, -1};
    if (bus.link_up() != link_told_[b]) {
      link_told_[b] = bus.link_up();
      reporter_.report(bus.link_up() ? Severity::Info : Severity::Error, code(Notice::BusState), subject, 0, 0,
                       "bus %zu: link %s", b, bus.link_up() ? "up" : "down");
      for (std::size_t j = 0; j < nodes_.size(); ++j) {
        if (settings_.joints[j].bus != b) continue;
        if (armed() || arming_ || stopped())
          joints_[j].lost = true;
        else
          nodes_[j].restart(now_ns_);
      }
      if (!bus.link_up() && (armed() || arming_)) trip(Fault::LinkDown, subject, 0, 0, "no link");
    }
    if (bus.off() && !off_told_[b]) trip(Fault::BusOff, subject, 0, 0, "controller reports bus-off");
    off_told_[b] = bus.off();
    if (bus.stalled() && (armed() || arming_))
      trip(Fault::TransmitStalled, subject, static_cast<double>(bus.status().outstanding), settings_.transmit_skips,
           "frames still queued, cycles in a row");
  }
}

/// What only a master sends: a second bridge, a played log, frames that an earlier process left in a queue.
bool Bridge::Implementation::is_order(std::size_t bus, const can::Frame& frame) const noexcept {
  if (frame.id == canopen::kNmtId || frame.id == canopen::kSyncId) return true;
  if (frame.id == canopen::kHeartbeatId + settings_.master_id) return true;
  const std::uint32_t function = frame.id & ~0x7FU;
  if (function < kRpdo1.cob_id || function > kRpdo1.cob_id + 0x300 || (function & 0x80U) != 0)
    return false;  // RPDO1..4
  return std::any_of(settings_.joints.begin(), settings_.joints.end(),
                     [&](const JointSettings& j) { return j.bus == bus && j.node == (frame.id & 0x7FU); });
}

bool Bridge::Implementation::has_foreign_master(std::size_t bus) const noexcept {
  return foreign_[bus].time_ns >= 0 && now_ns_ - foreign_[bus].time_ns < kForeignNs;
}

void Bridge::Implementation::supervise_masters() noexcept {
  for (std::size_t b = 0; b < buses_.size(); ++b) {
    if (foreign_[b].time_ns != now_ns_) continue;
    const Subject subject{static_cast<std::int32_t>(b), 0, -1};
    if (armed() || arming_) {
      trip(Fault::ForeignMaster, subject, foreign_[b].id, 0, "identifier");
    } else if (now_ns_ - foreign_told_ns_[b] >= kForeignNs) {
      foreign_told_ns_[b] = now_ns_;
      reporter_.report(Severity::Warning, code(Notice::ForeignFrames), subject, foreign_[b].id, 0,
                       "bus %zu: %03Xh of another master; no arming beside it", b,
                       static_cast<unsigned>(foreign_[b].id));
    }
  }
}

void Bridge::Implementation::supervise_node(std::size_t j) noexcept {
  Node& node = nodes_[j];
  const Node::Incidents incidents = node.incidents();
  node.clear_incidents();
  if (joints_[j].lost) return;
  if (incidents.rebooted) {
    lose(j, Fault::DriveRebooted, 0, 0, "boot-up message");
  } else if (incidents.heartbeat_lost) {
    lose(j, Fault::HeartbeatLost, 1e-9 * static_cast<double>(node.status(now_ns_).heartbeat_age_ns),
         1e-9 * static_cast<double>(settings_.heartbeat_timeout_ns), "seconds without a heartbeat");
  } else if (incidents.left_operational) {
    lose(j, Fault::DriveLeftNmt, code(node.status(now_ns_).nmt), code(Nmt::Operational),
         canopen::words(node.status(now_ns_).nmt).data());
  } else if (incidents.failed) {
    joints_[j].lost = true;
    trip(Fault::StartUpFailed, node.subject(), 0, 0, "see the event before");
  }
  if (incidents.emergency != 0 && (armed() || arming_))
    trip(Fault::DriveEmergency, node.subject(), incidents.emergency, 0,
         canopen::emergency_words(incidents.emergency).data());
}

/// A drive needs its configuration again. Idle: begin at once. Otherwise that waits for the operator's reset.
void Bridge::Implementation::lose(std::size_t j, Fault fault, double value, double limit, const char* what) noexcept {
  if (state_ == State::Idle && !arming_) {
    reporter_.report(Severity::Warning, code(fault), nodes_[j].subject(), value, limit, "%s: %s (%s), configured again",
                     settings_.joints[j].name.c_str(), words(fault), what);
    nodes_[j].restart(now_ns_);
    return;
  }
  joints_[j].lost = true;
  trip(fault, nodes_[j].subject(), value, limit, what);
}

/// A drive that was told to be without power and still has it can only be stopped by hand: that must be said.
void Bridge::Implementation::supervise_power(std::size_t j) noexcept {
  Joint& joint = joints_[j];
  const bool expected = armed() || arming_ || powered_stop_;
  if (expected || !nodes_[j].operational() || !has_power(nodes_[j].state())) {
    joint.power_since_ns = -1;
    joint.power_told = false;
  } else if (joint.power_since_ns < 0) {
    joint.power_since_ns = now_ns_;
  } else if (!joint.power_told && now_ns_ - joint.power_since_ns > settings_.state_timeout_ns) {
    joint.power_told = true;
    trip(Fault::DriveKeepsPower, nodes_[j].subject(), 1e-9 * static_cast<double>(now_ns_ - joint.power_since_ns),
         1e-9 * static_cast<double>(settings_.state_timeout_ns), cia402::words(nodes_[j].state()).data());
  }
}

void Bridge::Implementation::supervise_answers() noexcept {
  for (std::size_t b = 0; b < buses_.size(); ++b) {
    int drives = 0;
    int silent = 0;
    std::size_t worst = 0;
    for (std::size_t j = 0; j < nodes_.size(); ++j) {
      if (settings_.joints[j].bus != b) continue;
      ++drives;
      if (nodes_[j].missed_in_a_row() < settings_.feedback_misses) continue;
      ++silent;
      worst = j;
    }
    if (silent == 0) continue;
    const double missed = nodes_[worst].missed_in_a_row();
    if (silent == drives && drives > 1)
      trip(Fault::BusSilent, {static_cast<std::int32_t>(b), 0, -1}, missed, settings_.feedback_misses,
           "SYNCs without an answer");
    else
      trip(Fault::FeedbackLost, nodes_[worst].subject(), missed, settings_.feedback_misses, "SYNCs without an answer");
  }
}

void Bridge::Implementation::supervise_motion(std::size_t j) noexcept {
  Joint& joint = joints_[j];
  const Node& node = nodes_[j];
  const JointSettings& settings = settings_.joints[j];
  const DriveState state = node.state();
  if (state == DriveState::Fault || state == DriveState::FaultReaction)
    return trip(Fault::DriveFault, node.subject(), node.feedback().statusword, 0, cia402::words(state).data());
  if (!armed()) return;
  if (state != DriveState::OperationEnabled)
    return trip(Fault::DriveLeftOperation, node.subject(), node.feedback().statusword, 0, cia402::words(state).data());
  if ((node.feedback().statusword & cia402::kFollowsTarget) == 0)
    return trip(Fault::DriveNotFollowing, node.subject(), node.feedback().statusword, 0, "statusword bit 12 is 0");
  if ((node.feedback().statusword & cia402::kFollowingError) != 0)
    return trip(Fault::FollowingError, node.subject(), node.feedback().statusword, 0, "statusword bit 13 is 1");
  const double low = settings.lower_rad - settings.measured_margin_rad;
  const double high = settings.upper_rad + settings.measured_margin_rad;
  if (joint.measured_rad < low || joint.measured_rad > high)
    return trip(Fault::MeasuredOutOfRange, node.subject(), joint.measured_rad, joint.measured_rad < low ? low : high,
                "rad");
  // The drive may be at any of the last commands: it applies them one SYNC later and answers for the one before.
  const auto [least, most] = std::minmax({sent_rad_[0][j], sent_rad_[1][j], sent_rad_[2][j]});
  joint.following_rad = joint.measured_rad - std::clamp(joint.measured_rad, least, most);
  if (!(std::abs(joint.following_rad) > settings.following_window_rad)) {
    joint.following_since_ns = -1;
  } else if (joint.following_since_ns < 0) {
    joint.following_since_ns = now_ns_;
  } else if (now_ns_ - joint.following_since_ns >= settings.following_time_ns) {
    trip(Fault::FollowingError, node.subject(), joint.following_rad, settings.following_window_rad, "rad");
  }
}

/// Every fault goes through here: quick stop of all drives, latched. Only the first one is kept.
void Bridge::Implementation::trip(Fault fault, const Subject& subject, double value, double limit,
                                  const char* what) noexcept {
  const char* joint = subject.joint >= 0 ? settings_.joints[static_cast<std::size_t>(subject.joint)].name.c_str() : "";
  const char* const colon = *joint != '\0' ? ": " : "";
  if (value == 0.0 && limit == 0.0)
    reporter_.report(Severity::Error, code(fault), subject, value, limit, "%s%s%s (%s)", joint, colon, words(fault),
                     what);
  else
    reporter_.report(Severity::Error, code(fault), subject, value, limit, "%s%s%s (%s: %g, limit %g)", joint, colon,
                     words(fault), what, value, limit);
  if (fault == Fault::FollowingError && subject.joint >= 0)
    joints_[static_cast<std::size_t>(subject.joint)].blind = true;
  if (stopped()) return;
  powered_stop_ = armed() || arming_;
  fault_ = fault;
  stopped_ns_ = now_ns_;
  arming_ = stopping_ = disarm_at_rest_ = blending_ = false;
  start_since_ns_ = -1;
  stop_sent_.fill(false);
  gate_.close();
  resampler_.clear();
  for (BusMonitor& bus : buses_) bus.request_purge();
  const bool clean = fault == Fault::EStop || fault == Fault::StaleSetpoints || fault == Fault::LoopStalled;
  become(clean ? State::Stop : State::Fault);
}

void Bridge::Implementation::estop(const char* source) noexcept {
  local_estop_ = true;  // for this step: no reset beside it
  if (!stopped()) trip(Fault::EStop, {}, 0, 0, source);
}

}  // namespace glenoid::bridge
