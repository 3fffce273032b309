#pragma once

// What the core is told once. Checked by the reader of the configuration (host/bridge/config.hpp), not here.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace glenoid::bridge {

/// An object written to a drive at start-up beside those of the standard sequence.
struct ExtraObject {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
  std::uint8_t bytes = 4;  ///< 1, 2 or 4
  std::int64_t value = 0;
};

enum class OnLimit : std::uint8_t { Clamp, Stop };

/// One joint and its drive.
///
///     counts = round(sign * ratio * encoder_counts_per_turn * (q - offset_rad) / (2 pi))
struct JointSettings {
  std::string name;
  std::size_t bus = 0;
  std::uint8_t node = 1;

  double gear_ratio = 1.0;  ///< motor turns per joint turn
  int sign = 1;
  double offset_rad = 0.0;
  double encoder_counts_per_turn = 4096;  ///< of the motor
  double rated_torque_Nm = 0.0;           ///< at the joint, 6077h = 1000 stands for it; 0: effort is not reported

  double lower_rad = 0.0;
  double upper_rad = 0.0;
  double velocity_rad_per_s = 0.0;
  double acceleration_rad_per_s2 = 0.0;
  double step_rad = 0.0;             ///< most that a setpoint may differ from the previous command at rest
  double start_window_rad = 0.0;     ///< most that the first setpoint may differ from where the joint is
  double blend_rad_per_s = 0.0;      ///< speed of closing that difference
  double measured_margin_rad = 0.0;  ///< measured position may be this far outside the limits
  double following_window_rad = 0.0;
  std::int64_t following_time_ns = 0;
  OnLimit on_limit = OnLimit::Clamp;

  std::int16_t quick_stop_option = 6;        ///< 605Ah: 2 ramp, then off; 6 ramp and stay
  std::int16_t fault_reaction = 2;           ///< 605Eh
  std::uint32_t vendor = 0;                  ///< 1018h:01, 0: any
  std::uint32_t product = 0;                 ///< 1018h:02, 0: any
  bool may_lack_heartbeat_consumer = false;  ///< without 1016h it goes on when the bridge is gone; somebody accepted that
  std::vector<ExtraObject> objects;
};

/// How setpoint stamps become instants of the bridge's clock.
enum class TimeBase : std::uint8_t {
  Stamp,     ///< stamps are this machine's CLOCK_MONOTONIC
  Estimated  ///< stamps are the producer's own clock; offset and drift are estimated from the arrivals
};

struct Settings {
  std::string name;
  std::size_t bus_count = 1;
  std::vector<double> bit_rate_bit_per_s;  ///< of each bus; missing: 1e6
  std::vector<JointSettings> joints;

  std::int64_t period_ns = 2'000'000;
  std::uint8_t second_tpdo_every = 0;  ///< SYNCs from one TPDO2 to the next, 0: off
  std::int64_t setpoint_period_ns = 2'000'000;
  std::int64_t delay_ns = 4'000'000;  ///< setpoints are followed this much later
  TimeBase time_base = TimeBase::Stamp;
  std::int64_t hold_after_ns = 6'000'000;
  std::int64_t quick_stop_after_ns = 50'000'000;
  std::int64_t disarm_after_ns = 500'000'000;
  std::int64_t max_age_ns = 50'000'000;
  std::int64_t max_lead_ns = 100'000'000;

  std::uint8_t master_id = 0x7F;
  std::int64_t master_heartbeat_ns = 20'000'000;
  std::int64_t consumer_heartbeat_ns = 60'000'000;  ///< what the drives wait for, 1016h
  std::int64_t drive_heartbeat_ns = 100'000'000;    ///< 1017h
  std::int64_t heartbeat_timeout_ns = 250'000'000;

  std::int64_t sdo_timeout_ns = 100'000'000;
  int sdo_retries = 3;
  std::int64_t state_timeout_ns = 1'000'000'000;  ///< of one step of the NMT and CiA 402 walks
  int feedback_misses = 5;                        ///< in a row, then FeedbackLost
  int transmit_skips = 5;                         ///< in a row, then TransmitStalled
};

}  // namespace glenoid::bridge
