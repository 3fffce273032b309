#include "host/bridge/core/words.hpp"

namespace glenoid::bridge {

const char* words(State state) noexcept {
  switch (state) {
    case State::Idle:
      return "IDLE";
    case State::Ready:
      return "READY";
    case State::Run:
      return "RUN";
    case State::Hold:
      return "HOLD";
    case State::Stop:
      return "STOP";
    case State::Fault:
      return "FAULT";
  }
  return "unknown state";
}

const char* words(Request request) noexcept {
  switch (request) {
    case Request::Arm:
      return "arm";
    case Request::Start:
      return "start";
    case Request::Stop:
      return "stop";
    case Request::EStop:
      return "e-stop";
    case Request::ResetFault:
      return "reset fault";
    case Request::Disarm:
      return "disarm";
  }
  return "unknown request";
}

const char* words(Rejection rejection) noexcept {
  switch (rejection) {
    case Rejection::None:
      return "accepted";
    case Rejection::Size:
      return "message has another length";
    case Rejection::Type:
      return "message has another type";
    case Rejection::NotFinite:
      return "a value is not finite";
    case Rejection::Count:
      return "number of joints is not the configured one";
    case Rejection::Mask:
      return "not all joints are commanded";
    case Rejection::Session:
      return "token of another session";
    case Rejection::Sequence:
      return "sequence number is not new";
    case Rejection::Age:
      return "stamp is too old";
    case Rejection::Future:
      return "stamp is too far ahead";
    case Rejection::Position:
      return "beyond a position limit";
    case Rejection::Velocity:
      return "beyond a velocity limit";
    case Rejection::Step:
      return "too far from the previous command";
    case Rejection::StartDistance:
      return "too far from where the joint is";
    case Rejection::NotArmed:
      return "not armed";
  }
  return "unknown rejection";
}

const char* words(Fault fault) noexcept {
  switch (fault) {
    case Fault::None:
      return "none";
    case Fault::EStop:
      return "emergency stop";
    case Fault::StaleSetpoints:
      return "setpoints stopped coming";
    case Fault::LoopStalled:
      return "the bridge did not run in time";
    case Fault::TwoPublishers:
      return "two sources send setpoints";
    case Fault::LimitExceeded:
      return "command beyond a limit";
    case Fault::FollowingError:
      return "following error";
    case Fault::MeasuredOutOfRange:
      return "measured position outside the limits";
    case Fault::DriveFault:
      return "drive in fault";
    case Fault::DriveEmergency:
      return "emergency message of a drive";
    case Fault::DriveLeftOperation:
      return "drive left operation enabled";
    case Fault::DriveNotFollowing:
      return "drive ignores its target";
    case Fault::DriveRebooted:
      return "drive rebooted";
    case Fault::DriveLeftNmt:
      return "drive is no longer operational";
    case Fault::HeartbeatLost:
      return "heartbeat of a drive lost";
    case Fault::FeedbackLost:
      return "drive stopped answering SYNC";
    case Fault::BusSilent:
      return "no drive of a bus answers SYNC";
    case Fault::BusOff:
      return "CAN controller is bus-off";
    case Fault::LinkDown:
      return "CAN interface is down";
    case Fault::TransmitStalled:
      return "frames do not reach the bus";
    case Fault::StartUpFailed:
      return "a drive could not be configured";
    case Fault::EnableTimeout:
      return "drives were not enabled in time";
    case Fault::CountOverflow:
      return "command does not fit the drive's counts";
    case Fault::ForeignMaster:
      return "another master commands the drives";
    case Fault::DriveKeepsPower:
      return "drive keeps its power";
  }
  return "unknown fault";
}

const char* words(BusState state) noexcept {
  switch (state) {
    case BusState::Active:
      return "active";
    case BusState::Warning:
      return "warning";
    case BusState::Passive:
      return "passive";
    case BusState::Off:
      return "bus-off";
    case BusState::Down:
      return "down";
  }
  return "unknown";
}

}  // namespace glenoid::bridge
