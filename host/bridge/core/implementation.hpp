#pragma once

// Inside of the bridge: only the files of the core include this.

#include <array>
#include <cstdint>
#include <vector>

#include "host/bridge/core/bridge.hpp"
#include "host/bridge/core/bus_monitor.hpp"
#include "host/bridge/core/codec.hpp"
#include "host/bridge/core/gate.hpp"
#include "host/bridge/core/limits.hpp"
#include "host/bridge/core/node.hpp"
#include "host/bridge/core/producer_clock.hpp"
#include "host/bridge/core/reporter.hpp"
#include "host/bridge/core/resampler.hpp"

namespace glenoid::bridge {

class Bridge::Implementation {
 public:
  explicit Implementation(const Settings& settings);

  void sync(std::int64_t cycle, std::int64_t time_ns, Outputs& outputs) noexcept;
  void step(std::int64_t time_ns, const Inputs& inputs, Outputs& outputs) noexcept;

  [[nodiscard]] State state() const noexcept { return state_; }
  [[nodiscard]] Fault fault() const noexcept { return fault_; }
  [[nodiscard]] std::int64_t session() const noexcept { return session_; }
  [[nodiscard]] bool configured() const noexcept;
  [[nodiscard]] bool released() const noexcept;
  [[nodiscard]] std::span<const double> command_rad() const noexcept { return {command_rad_.data(), nodes_.size()}; }

 private:
  /// What the bridge knows of one joint beside its node.
  struct Joint {
    Scale scale;
    CommandLimiter limiter;
    std::uint16_t controlword = 0;
    std::int32_t target = 0;
    bool held = false;   ///< the target is a command; otherwise it goes with the measured position
    bool lost = false;   ///< its node must be configured again before arming
    bool blind = false;  ///< its measured position is not to be trusted: it cannot brake, so its power goes at once
    double measured_rad = 0.0;
    double velocity_rad_per_s = 0.0;
    std::int64_t measured_cycle = -1;
    double following_rad = 0.0;
    std::int64_t following_since_ns = -1;
    std::int64_t reset_since_ns = -1;  ///< a fault reset is under way
    std::int64_t power_since_ns = -1;  ///< it has power that it should not have
    bool power_told = false;
    std::uint8_t limited_told = 0;
    std::int64_t limited = 0;
  };

  // bridge.cpp: the cycle
  void receive(const Inputs& inputs) noexcept;
  void dispatch(std::size_t bus, const can::Frame& frame) noexcept;
  void measure(std::size_t joint) noexcept;
  void send() noexcept;
  void send_heartbeats(bool suppressed) noexcept;
  void publish_feedback() noexcept;
  void publish_status() noexcept;
  [[nodiscard]] std::uint64_t status_key() const noexcept;

  // supervision.cpp: what must never go unnoticed
  void supervise(const Inputs& inputs) noexcept;
  void supervise_buses() noexcept;
  void supervise_masters() noexcept;
  [[nodiscard]] bool is_order(std::size_t bus, const can::Frame& frame) const noexcept;
  [[nodiscard]] bool has_foreign_master(std::size_t bus) const noexcept;
  void supervise_node(std::size_t joint) noexcept;
  void supervise_power(std::size_t joint) noexcept;
  void supervise_answers() noexcept;
  void supervise_motion(std::size_t joint) noexcept;
  void lose(std::size_t joint, Fault fault, double value, double limit, const char* what) noexcept;
  void trip(Fault fault, const Subject& subject, double value, double limit, const char* what) noexcept;
  void estop(const char* source) noexcept;

  // requests.cpp: the operator
  void take(const Command& command) noexcept;
  void refuse(Request request, const char* why) noexcept;
  void request_arm() noexcept;
  void request_start() noexcept;
  void request_stop(bool disarm) noexcept;
  void request_reset() noexcept;
  void shut_down() noexcept;
  [[nodiscard]] const char* obstacle_to_arming() const noexcept;

  // operation.cpp: the motion
  void take(const Setpoint& setpoint) noexcept;
  void reject(Rejection reason) noexcept;
  void advance() noexcept;
  void advance_idle() noexcept;
  void advance_arming() noexcept;
  void advance_ready() noexcept;
  void advance_run() noexcept;
  void advance_hold() noexcept;
  void advance_stopped() noexcept;
  void follow(const Sample& sample) noexcept;
  void hold_still() noexcept;
  void become(State state) noexcept;
  void disarm() noexcept;
  [[nodiscard]] bool all_at_rest() const noexcept;
  /// The drive of joint `j` gets each command, so its command may move; limits hold from one that was sent to the next.
  [[nodiscard]] bool reaches(std::size_t j) const noexcept { return buses_[settings_.joints[j].bus].carries(); }
  [[nodiscard]] bool armed() const noexcept {
    return state_ == State::Ready || state_ == State::Run || state_ == State::Hold;
  }
  [[nodiscard]] bool stopped() const noexcept { return state_ == State::Stop || state_ == State::Fault; }
  [[nodiscard]] std::int64_t command_stamp(std::int64_t sync_ns) const noexcept {
    return clock_.stamp(sync_ns - settings_.delay_ns);
  }
  template <class Code>
  static constexpr std::int32_t code(Code value) noexcept {
    return static_cast<std::int32_t>(value);
  }

  Settings settings_;
  Reporter reporter_;
  std::vector<BusMonitor> buses_;
  std::vector<Node> nodes_;
  std::vector<Joint> joints_;
  Gate gate_;
  ProducerClock clock_;
  Resampler resampler_;

  State state_ = State::Idle;
  Fault fault_ = Fault::None;
  std::int64_t session_ = 0;
  std::int64_t entropy_ = 0;
  bool local_estop_ = false;
  const char* arming_obstacle_ = nullptr;
  bool shutting_down_ = false;

  bool arming_ = false;
  int arming_progress_ = 0;
  std::int64_t progress_ns_ = 0;
  std::int64_t arming_ns_ = 0;
  std::int64_t start_since_ns_ = -1;  // start asked for
  bool blending_ = false;
  bool stopping_ = false;  // hold was asked for
  bool disarm_at_rest_ = false;
  std::int64_t accepted_ns_ = 0;  // newest accepted setpoint
  std::int64_t stopped_ns_ = 0;
  bool powered_stop_ = false;  // quick stop commanded, not yet disarmed

  Outputs* outputs_ = nullptr;
  std::int64_t now_ns_ = 0;
  std::int64_t last_step_ns_ = -1;
  std::int64_t cycle_ = -1;
  std::int64_t sync_ns_ = 0;
  std::int64_t sync_sequence_ = -1;  // newest accepted setpoint when the SYNC went out
  std::int64_t sync_session_ = 0;
  std::array<bool, kMaxBuses> sync_sent_{};
  std::array<bool, kMaxBuses> link_told_{};
  std::array<bool, kMaxBuses> off_told_{};
  /// Newest order of somebody else.
  struct Foreign {
    std::int64_t time_ns = -1;
    std::uint32_t id = 0;
  };
  std::array<Foreign, kMaxBuses> foreign_{};
  std::array<std::int64_t, kMaxBuses> foreign_told_ns_{};
  std::array<bool, kMaxBuses> stop_sent_{};  // since the stop: no SYNC may make an older command active before it
  std::int64_t heartbeat_ns_ = -1;
  std::size_t sdo_turn_ = 0;

  JointValues command_rad_{};
  std::array<JointValues, 3> sent_rad_{};  // last commands, newest first
  std::int64_t cycles_ = 0;
  std::int64_t skipped_ = 0;
  std::int64_t skipped_told_ns_ = -1;
  std::int64_t setpoints_accepted_ = 0;
  std::int64_t setpoints_rejected_ = 0;
  Rejection last_rejection_ = Rejection::None;
  std::array<std::int64_t, kRejectionCount> rejection_told_ns_{};
  std::int64_t feedback_sequence_ = 0;
  std::int64_t status_sequence_ = 0;
  std::int64_t status_ns_ = -1;
  std::uint64_t status_key_ = 0;
};

}  // namespace glenoid::bridge
