#include "host/bridge/core/node.hpp"

#include <array>
#include <cstdio>

#include "host/bridge/core/bytes.hpp"
#include "host/bridge/core/canopen.hpp"
#include "host/bridge/core/cia402.hpp"
#include "host/bridge/core/pdo_table.hpp"

namespace glenoid::bridge {
namespace {

constexpr std::int64_t kProbePauseNs = 250'000'000;
constexpr std::int64_t kSilentAfterNs = 3'000'000'000;
constexpr std::int64_t kNmtRepeatNs = 100'000'000;
constexpr std::int64_t kModePollNs = 20'000'000;

constexpr std::int32_t code(Notice notice) { return static_cast<std::int32_t>(notice); }

}  // namespace

Node::Node(const Settings& settings, std::size_t joint)
    : settings_(&settings),
      joint_(&settings.joints[joint]),
      subject_{static_cast<std::int32_t>(joint_->bus), joint_->node, static_cast<std::int32_t>(joint)},
      identity_(identity_steps(*joint_)),
      configuration_(configuration_steps(settings, *joint_)),
      sdo_(joint_->node, settings.sdo_timeout_ns, settings.sdo_retries) {}

void Node::restart(std::int64_t now_ns) noexcept {
  sdo_.cancel();
  phase_ = Phase::Probe;
  phase_since_ns_ = next_action_ns_ = now_ns;
  step_ = 0;
  asked_ = verifying_ = told_silent_ = false;
  nmt_ = Nmt::Unknown;
  heartbeat_ns_ = -1;
  state_ = DriveState::Unknown;
  has_feedback_ = answered_ = arrived_ = false;
  missed_in_a_row_ = 0;
  error_code_ = 0;
  incidents_ = {};
}

void Node::release() noexcept {
  if (phase_ != Phase::Operational) {
    phase_ = Phase::Released;
    return;
  }
  sdo_.cancel();
  phase_ = Phase::Release;
  asked_ = false;
}

void Node::enter(Phase phase, std::int64_t now_ns, Reporter& reporter) noexcept {
  phase_ = phase;
  phase_since_ns_ = next_action_ns_ = now_ns;
  step_ = 0;
  asked_ = verifying_ = false;
  if (phase == Phase::Identify)
    reporter.report(Severity::Info, code(Notice::DriveFound), subject_, 0, 0, "%s: node %d answers",
                    joint_->name.c_str(), joint_->node);
  if (phase == Phase::Start)
    reporter.report(Severity::Info, code(Notice::DriveConfigured), subject_, 0, 0,
                    "%s: node %d configured, %zu objects read back", joint_->name.c_str(), joint_->node,
                    configuration_.size());
  if (phase == Phase::Operational)
    reporter.report(Severity::Info, code(Notice::DriveOperational), subject_, 0, 0, "%s: node %d operational",
                    joint_->name.c_str(), joint_->node);
}

void Node::fail(Reporter& reporter, const char* why, double value, double limit) noexcept {
  phase_ = Phase::Failed;
  sdo_.cancel();
  incidents_.failed = true;
  reporter.report(Severity::Error, static_cast<std::int32_t>(Fault::StartUpFailed), subject_, value, limit,
                  "%s: node %d: %s", joint_->name.c_str(), joint_->node, why);
}

void Node::receive(const can::Frame& frame, std::int64_t now_ns, Reporter& reporter) noexcept {
  if (frame.extended || frame.remote || frame.error) return;
  const std::uint32_t function = frame.id - joint_->node;
  if (function == kTpdo1.cob_id) {
    on_feedback(frame);
  } else if (function == kTpdo2.cob_id) {
    on_second_feedback(frame);
  } else if (function == canopen::kHeartbeatId && frame.size == 1) {
    on_heartbeat(static_cast<Nmt>(frame.data[0] & 0x7F), now_ns, reporter);
  } else if (function == canopen::kEmergencyId && frame.size == 8) {
    on_emergency(frame, reporter);
  } else if (function == canopen::kSdoResponseId) {
    if (const auto answer = canopen::sdo_answer(frame)) sdo_.receive(*answer);
  }
}

void Node::on_feedback(const can::Frame& frame) noexcept {
  const auto value = decode_tpdo1(frame);
  if (!value || !(phase_ == Phase::Operational || phase_ == Phase::ModeCheck || phase_ == Phase::Start)) return;
  feedback_ = *value;
  state_ = cia402::decode(value->statusword);
  has_feedback_ = arrived_ = true;
}

void Node::on_second_feedback(const can::Frame& frame) noexcept {
  const auto value = decode_tpdo2(frame);
  if (value && value->error_code != 0) error_code_ = value->error_code;  // 0 may be older than the last EMCY
}

void Node::on_heartbeat(Nmt nmt, std::int64_t now_ns, Reporter& reporter) noexcept {
  heartbeat_ns_ = now_ns;
  nmt_ = nmt;
  if (nmt == Nmt::BootUp) {
    if (phase_ == Phase::Operational) {
      incidents_.rebooted = true;
    } else if (phase_ != Phase::Failed && phase_ != Phase::Released) {
      if (phase_ != Phase::Probe)
        reporter.report(Severity::Warning, static_cast<std::int32_t>(Fault::DriveRebooted), subject_, 0, 0,
                        "%s: node %d rebooted during start-up, begins again", joint_->name.c_str(), joint_->node);
      restart(now_ns);
    }
  } else if (phase_ == Phase::Operational && nmt != Nmt::Operational) {
    incidents_.left_operational = true;
  }
}

void Node::on_emergency(const can::Frame& frame, Reporter& reporter) noexcept {
  error_code_ = get_u16(frame, 0);
  const bool cleared = error_code_ == 0;
  if (!cleared && incidents_.emergency == 0) incidents_.emergency = error_code_;
  reporter.report(cleared ? Severity::Info : Severity::Error,
                  code(cleared ? Notice::EmergencyCleared : Notice::Emergency), subject_, error_code_, 0,
                  "%s: node %d: EMCY %04Xh %s, error register %02Xh", joint_->name.c_str(), joint_->node,
                  static_cast<unsigned>(error_code_), canopen::emergency_words(error_code_).data(),
                  static_cast<unsigned>(frame.data[2]));
}

void Node::close_cycle(bool sync_sent) noexcept {
  answered_ = arrived_;
  arrived_ = false;
  if (phase_ != Phase::Operational) {
    missed_in_a_row_ = 0;
  } else if (answered_) {
    missed_in_a_row_ = 0;
  } else if (sync_sent) {
    ++missed_in_a_row_;
    if (has_feedback_) ++missed_;
  }
}

void Node::step(std::int64_t now_ns, bool& sdo_allowed, BusOutput& output, Reporter& reporter) noexcept {
  if (phase_since_ns_ < 0) restart(now_ns);
  switch (phase_) {
    case Phase::Probe:
      step_probe(now_ns, reporter);
      break;
    case Phase::Identify:
      step_list(identity_, Phase::PreOperational, now_ns, reporter);
      break;
    case Phase::PreOperational:
      step_nmt(static_cast<std::uint8_t>(canopen::NmtCommand::PreOperational), Nmt::PreOperational, Phase::Configure,
               now_ns, output, reporter);
      break;
    case Phase::Configure:
      step_list(configuration_, Phase::Start, now_ns, reporter);
      break;
    case Phase::Start:
      step_nmt(static_cast<std::uint8_t>(canopen::NmtCommand::Start), Nmt::Operational, Phase::ModeCheck, now_ns,
               output, reporter);
      break;
    case Phase::ModeCheck:
      step_mode(now_ns, reporter);
      break;
    case Phase::Release:
      step_release(now_ns, output, reporter);
      break;
    case Phase::Operational:
      if (now_ns - heartbeat_ns_ > settings_->heartbeat_timeout_ns) incidents_.heartbeat_lost = true;
      break;
    case Phase::Failed:
    case Phase::Released:
      break;
  }
  if (!sdo_allowed) return;
  if (const auto frame = sdo_.poll(now_ns)) {
    output.frames.push(*frame);
    sdo_allowed = false;
  }
}

void Node::step_probe(std::int64_t now_ns, Reporter& reporter) noexcept {
  if (sdo_.busy()) return;
  if (asked_) {
    asked_ = false;
    if (sdo_.result().outcome == SdoClient::Outcome::Done || sdo_.result().outcome == SdoClient::Outcome::Aborted) {
      enter(Phase::Identify, now_ns, reporter);
      return;
    }
    next_action_ns_ = now_ns + kProbePauseNs;
    if (!told_silent_ && now_ns - phase_since_ns_ > kSilentAfterNs) {
      told_silent_ = true;
      reporter.report(Severity::Warning, code(Notice::DriveSilent), subject_, 0, 0,
                      "%s: node %d does not answer, still asking", joint_->name.c_str(), joint_->node);
    }
  }
  if (now_ns < next_action_ns_) return;
  sdo_.upload(0x1000, 0);
  asked_ = true;
}

void Node::finish_step(const StartupStep& step, std::uint32_t value, Reporter& reporter) noexcept {
  if (step.kind == StartupStep::Kind::Write || step.kind == StartupStep::Kind::WriteIfPresent)
    reporter.report(Severity::Info, code(Notice::ObjectWritten), subject_, value, step.value,
                    "%s: node %d: %04Xh:%02X = %u (%s), read back", joint_->name.c_str(), joint_->node,
                    static_cast<unsigned>(step.index), static_cast<unsigned>(step.subindex), value, step.name.data());
  ++step_;
  asked_ = verifying_ = false;
}

void Node::step_list(const std::vector<StartupStep>& list, Phase next, std::int64_t now_ns,
                     Reporter& reporter) noexcept {
  if (sdo_.busy()) return;
  if (asked_) {
    const StartupStep& step = list[step_];
    const SdoClient::Result result = sdo_.result();
    const bool writes = step.kind != StartupStep::Kind::Check;
    const bool absent = result.outcome == SdoClient::Outcome::Aborted &&
                        (result.value == canopen::kAbortNoObject || result.value == canopen::kAbortNoSubindex);
    if (step.kind == StartupStep::Kind::WriteIfPresent && absent) {
      if (step.index == kHeartbeatConsumer)
        reporter.report(
            Severity::Warning, code(Notice::DriveUnwatched), subject_, 0, 0,
            "%s: node %d has no 1016h: it will not stop when the bridge is gone; the configuration accepts that",
            joint_->name.c_str(), joint_->node);
      ++step_;
      asked_ = verifying_ = false;
    } else if (result.outcome != SdoClient::Outcome::Done) {
      std::array<char, 120> why{};
      std::snprintf(why.data(), why.size(), "%04Xh:%02X (%s): SDO abort %08Xh, %s", static_cast<unsigned>(step.index),
                    static_cast<unsigned>(step.subindex), step.name.data(), result.value,
                    canopen::abort_words(result.value).data());
      return fail(reporter, why.data(), result.value, step.value);
    } else if (writes && !verifying_ && step.kind != StartupStep::Kind::WriteOnly) {
      sdo_.upload(step.index, step.subindex);
      verifying_ = true;
      return;
    } else if (step.kind != StartupStep::Kind::WriteOnly && (result.value & step.mask) != (step.value & step.mask)) {
      std::array<char, 120> why{};
      std::snprintf(why.data(), why.size(), "%04Xh:%02X (%s): reads %Xh, must be %Xh",
                    static_cast<unsigned>(step.index), static_cast<unsigned>(step.subindex), step.name.data(),
                    result.value & step.mask, step.value & step.mask);
      return fail(reporter, why.data(), result.value, step.value);
    } else {
      finish_step(step, result.value, reporter);
    }
  }
  if (step_ == list.size()) return enter(next, now_ns, reporter);
  const StartupStep& step = list[step_];
  if (step.kind == StartupStep::Kind::Check)
    sdo_.upload(step.index, step.subindex);
  else
    sdo_.download(step.index, step.subindex, step.bytes, step.value);
  asked_ = true;
}

/// Repeats the command until a heartbeat that came after the first one confirms it.
void Node::step_nmt(std::uint8_t command, Nmt wanted, Phase next, std::int64_t now_ns, BusOutput& output,
                    Reporter& reporter) noexcept {
  // A heartbeat is needed for that: the drive's producer is switched on in the first of these phases.
  if (phase_ == Phase::PreOperational && step_ == 0 && !sdo_.busy()) {
    if (asked_) {
      step_ = 1;  // an abort shows up when the configuration writes it again
    } else {
      sdo_.download(0x1017, 0, 2, static_cast<std::uint32_t>(settings_->drive_heartbeat_ns / 1'000'000));
      asked_ = true;
    }
  }
  const std::int64_t limit_ns = settings_->state_timeout_ns + 2 * settings_->drive_heartbeat_ns;
  if (nmt_ == wanted && heartbeat_ns_ > phase_since_ns_ && !sdo_.busy()) return enter(next, now_ns, reporter);
  if (now_ns - phase_since_ns_ > limit_ns)
    return fail(reporter,
                wanted == Nmt::Operational ? "its heartbeat does not confirm operational"
                                           : "its heartbeat does not confirm pre-operational",
                static_cast<double>(nmt_), static_cast<double>(wanted));
  if (now_ns < next_action_ns_) return;
  output.frames.push(canopen::nmt(static_cast<canopen::NmtCommand>(command), joint_->node));
  next_action_ns_ = now_ns + kNmtRepeatNs;
}

void Node::step_mode(std::int64_t now_ns, Reporter& reporter) noexcept {
  if (sdo_.busy()) return;
  if (asked_) {
    asked_ = false;
    const SdoClient::Result result = sdo_.result();
    const bool read = result.outcome == SdoClient::Outcome::Done;
    if (read && (result.value & 0xFF) == static_cast<std::uint32_t>(cia402::kModeCsp))
      return enter(Phase::Operational, now_ns, reporter);
    if (now_ns - phase_since_ns_ > settings_->state_timeout_ns)
      return fail(reporter, "6061h does not show cyclic synchronous position", result.value, cia402::kModeCsp);
    next_action_ns_ = now_ns + kModePollNs;
  }
  if (now_ns < next_action_ns_) return;
  sdo_.upload(0x6061, 0);
  asked_ = true;
}

void Node::step_release(std::int64_t now_ns, BusOutput& output, Reporter& reporter) noexcept {
  if (sdo_.busy()) return;
  if (!asked_) {
    sdo_.download(kHeartbeatConsumer, 1, 4, 0);
    asked_ = true;
    return;
  }
  output.frames.push(canopen::nmt(canopen::NmtCommand::PreOperational, joint_->node));
  enter(Phase::Released, now_ns, reporter);
}

DriveStatus Node::status(std::int64_t now_ns) const noexcept {
  DriveStatus status;
  status.node_id = joint_->node;
  status.nmt = nmt_;
  status.state = state_;
  status.statusword = feedback_.statusword;
  status.error_code = error_code_;
  status.heartbeat_age_ns = heartbeat_ns_ < 0 ? -1 : now_ns - heartbeat_ns_;
  status.missed_feedback = missed_;
  return status;
}

}  // namespace glenoid::bridge
