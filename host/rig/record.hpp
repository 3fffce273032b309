#pragma once

#include <cstdint>
#include <vector>

#include "host/bridge/can/frame.hpp"
#include "host/bridge/core/messages.hpp"

namespace glenoid::rig {

/// State of everything at the end of one cycle; per joint what is true, not what the encoders say.
struct CycleRecord {
  std::int64_t time_ns = 0;  ///< of the SYNC
  bridge::State state = bridge::State::Idle;
  bridge::Fault fault = bridge::Fault::None;
  std::uint32_t powered_mask = 0;  ///< bit k: drive k drives its motor
  bridge::JointValues position_rad{};
  bridge::JointValues velocity_rad_per_s{};
  bridge::JointValues torque_Nm{};  ///< at the joint, in the drive's own direction
  bridge::JointValues command_rad{};
};

struct FeedbackRecord {
  bridge::Feedback feedback;
  bridge::State state = bridge::State::Idle;  ///< when it was told
};

struct FrameRecord {
  std::int64_t time_ns = 0;
  std::int32_t bus = 0;
  can::Frame frame;
};

/// Everything that happened, oldest first.
struct Record {
  std::vector<CycleRecord> cycles;
  std::vector<FeedbackRecord> feedback;
  std::vector<bridge::Status> statuses;
  std::vector<bridge::Event> events;
  std::vector<bridge::Setpoint> setpoints;  ///< as they reached the bridge
  std::vector<bridge::Command> commands;
  std::vector<FrameRecord> frames;  ///< as they were on the bus
};

}  // namespace glenoid::rig
