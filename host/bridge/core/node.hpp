#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/bridge/can/frame.hpp"
#include "host/bridge/core/codec.hpp"
#include "host/bridge/core/messages.hpp"
#include "host/bridge/core/reporter.hpp"
#include "host/bridge/core/sdo_client.hpp"
#include "host/bridge/core/settings.hpp"
#include "host/bridge/core/startup.hpp"

namespace glenoid::bridge {

/// One drive as the master sees it: found, checked, configured, started; then its answers and its signs of life.
///
/// Does not decide what a loss means: it says what happened, the bridge reacts.
class Node {
 public:
  enum class Phase : std::uint8_t {
    Probe,           ///< asks until somebody answers; a drive that was on already sends no boot-up
    Identify,        ///< 1000h, 1018h, 6502h
    PreOperational,  ///< confirmed by its heartbeat
    Configure,       ///< written and read back
    Start,           ///< confirmed by its heartbeat
    ModeCheck,       ///< 6061h
    Operational,
    Failed,   ///< stays until restart()
    Release,  ///< 1016h off, so that it does not miss us
    Released
  };

  /// What happened since clear_incidents(), first cause first.
  struct Incidents {
    bool rebooted = false;
    bool heartbeat_lost = false;
    bool left_operational = false;
    bool failed = false;
    std::uint16_t emergency = 0;  ///< error code, 0 none
  };

  Node(const Settings& settings, std::size_t joint);

  /// Begins again with the probe; what it was told before counts no more.
  void restart(std::int64_t now_ns) noexcept;
  void release() noexcept;

  /// A frame of this drive (identifier minus node id is a function code the master listens to).
  void receive(const can::Frame& frame, std::int64_t now_ns, Reporter& reporter) noexcept;
  /// Lets time pass. What is to be sent goes to `frames`.
  /// @param sdo_allowed  room for an SDO request in this cycle; set false when it was used
  void step(std::int64_t now_ns, bool& sdo_allowed, BusOutput& output, Reporter& reporter) noexcept;

  /// Counts whether the SYNC of this cycle was answered. Call once per step, after the frames were handed over.
  void close_cycle(bool sync_sent) noexcept;

  [[nodiscard]] Phase phase() const noexcept { return phase_; }
  [[nodiscard]] bool operational() const noexcept { return phase_ == Phase::Operational; }
  [[nodiscard]] bool has_feedback() const noexcept { return has_feedback_; }
  /// It answered the SYNC of this cycle.
  [[nodiscard]] bool answered() const noexcept { return answered_; }
  [[nodiscard]] int missed_in_a_row() const noexcept { return missed_in_a_row_; }
  [[nodiscard]] const Tpdo1& feedback() const noexcept { return feedback_; }
  [[nodiscard]] DriveState state() const noexcept { return state_; }
  [[nodiscard]] const Incidents& incidents() const noexcept { return incidents_; }
  void clear_incidents() noexcept { incidents_ = {}; }
  [[nodiscard]] std::uint16_t error_code() const noexcept { return error_code_; }
  [[nodiscard]] const Subject& subject() const noexcept { return subject_; }
  [[nodiscard]] DriveStatus status(std::int64_t now_ns) const noexcept;

 private:
  void enter(Phase phase, std::int64_t now_ns, Reporter& reporter) noexcept;
  void fail(Reporter& reporter, const char* why, double value, double limit) noexcept;
  void on_heartbeat(Nmt nmt, std::int64_t now_ns, Reporter& reporter) noexcept;
  void on_emergency(const can::Frame& frame, Reporter& reporter) noexcept;
  void on_feedback(const can::Frame& frame) noexcept;
  void on_second_feedback(const can::Frame& frame) noexcept;
  void step_probe(std::int64_t now_ns, Reporter& reporter) noexcept;
  void step_list(const std::vector<StartupStep>& list, Phase next, std::int64_t now_ns, Reporter& reporter) noexcept;
  void step_nmt(std::uint8_t command, Nmt wanted, Phase next, std::int64_t now_ns, BusOutput& output,
                Reporter& reporter) noexcept;
  void step_mode(std::int64_t now_ns, Reporter& reporter) noexcept;
  void step_release(std::int64_t now_ns, BusOutput& output, Reporter& reporter) noexcept;
  void finish_step(const StartupStep& step, std::uint32_t value, Reporter& reporter) noexcept;

  const Settings* settings_;
  const JointSettings* joint_;
  Subject subject_;
  std::vector<StartupStep> identity_;
  std::vector<StartupStep> configuration_;
  SdoClient sdo_;

  Phase phase_ = Phase::Probe;
  std::int64_t phase_since_ns_ = -1;  // -1: not begun
  std::int64_t next_action_ns_ = 0;
  std::size_t step_ = 0;
  bool asked_ = false;      // the transfer of the step under way was begun
  bool verifying_ = false;  // its read-back is under way
  bool told_silent_ = false;

  Nmt nmt_ = Nmt::Unknown;
  std::int64_t heartbeat_ns_ = -1;
  std::uint16_t error_code_ = 0;
  Incidents incidents_{};

  Tpdo1 feedback_{};
  DriveState state_ = DriveState::Unknown;
  bool has_feedback_ = false;
  bool answered_ = false;
  bool arrived_ = false;
  int missed_in_a_row_ = 0;
  std::int64_t missed_ = 0;
};

}  // namespace glenoid::bridge
