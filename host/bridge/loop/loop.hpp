#pragma once

// The real-time loop: the only place where the core meets clock, buses and messages.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/bridge/can/port.hpp"
#include "host/bridge/config/config.hpp"
#include "host/bridge/core/bridge.hpp"
#include "host/bridge/lcm/lcm_port.hpp"
#include "host/bridge/lcm/ring.hpp"
#include "host/bridge/loop/estop_input.hpp"
#include "host/bridge/loop/frame_log.hpp"
#include "host/bridge/loop/histogram.hpp"

namespace glenoid::bridge {

/// What the loop measured.
struct LoopFigures {
  Histogram wake_up;     ///< deadline to running
  Histogram sync_error;  ///< |SYNC to SYNC - period|, from the echo where the bus has one, otherwise from sending
  Histogram rpdo_after_sync;
  Histogram tpdo_after_sync;
  Histogram setpoint_to_wire;  ///< stamp of a setpoint to the RPDOs sent next
  Histogram cycle_cpu;         ///< processor time from cycle to cycle, waking up and falling asleep included
  Histogram awake;             ///< of it: awake before the SYNC
  Histogram core;              ///< of it: in the core
  Histogram port;              ///< of it: in the buses' ports
  Histogram lcm;               ///< of it: between the loop and LCM's threads
  Counter cycles;
  Counter accepted, rejected;  ///< setpoints, as the last status says
  Counter late_cycles;         ///< left out because the loop was late by half a period or more

  /// All of it in short; any thread, while the loop runs too.
  [[nodiscard]] Figures in_short(std::int64_t now_ns) const noexcept;
};

struct LoopOptions {
  int priority = 80;        ///< SCHED_FIFO, 0: ordinary
  double duration_s = 0.0;  ///< 0: until told to stop
  double awake_us = 0.0;    ///< not slept before each SYNC, see wait_until
  bool silent = false;      ///< sends nothing: dry run
  bool deadman_test = false;
  int estop_descriptor = -1;
  std::string arming_obstacle;  ///< empty: arming is permitted
};

/// Runs a bridge until `stop`. SYNC at absolute deadlines start + n * period that are never re-based; a cycle whose deadline
/// was missed by half a period is left out, never caught up. Allocates, locks and logs nothing once it runs.
class Loop {
 public:
  /// @param ports  one per bus, in the order of the configuration
  /// @param lcm    may be null: no messages
  /// @param log    may be null
  Loop(const Config& config, std::vector<std::unique_ptr<can::Port>> ports, lcm_port::LcmPort* lcm, FrameLog* log,
       const LoopOptions& options);

  /// Until the duration is over, or a stop was asked for and the drives are released.
  void run() noexcept;

  /// From a signal handler or another thread.
  void request_stop() noexcept { stop_.store(true, std::memory_order_relaxed); }
  void request_estop() noexcept { estop_.store(true, std::memory_order_relaxed); }

  /// For one other thread: events in the order they happened.
  bool take_event(Event& into) noexcept { return events_.pop(into); }
  /// State of the bridge, for the same or another thread.
  [[nodiscard]] State state() const noexcept { return state_.load(std::memory_order_relaxed); }
  /// Any thread.
  [[nodiscard]] const LoopFigures& figures() const noexcept { return figures_; }
  /// After run() with deadman_test: every drive reported 8130h while the master was silent.
  [[nodiscard]] bool deadman_passed() const noexcept { return deadman_passed_; }
  /// It ended with a latched stop.
  [[nodiscard]] bool stopped_by_fault() const noexcept {
    return bridge_.state() == State::Fault || bridge_.state() == State::Stop;
  }

 private:
  void cycle(std::int64_t number, std::int64_t deadline_ns) noexcept;
  void collect_frames() noexcept;
  void collect_messages() noexcept;
  void collect_wishes(std::int64_t now_ns) noexcept;
  void lap(std::int64_t& part_ns) noexcept;
  void transmit() noexcept;
  void tell() noexcept;
  void observe(std::size_t bus, const can::Received& received) noexcept;
  void step_deadman(std::int64_t now_ns) noexcept;
  [[nodiscard]] bool finished(std::int64_t now_ns) noexcept;

  static constexpr std::size_t kFrames = 256;  // of one bus in one cycle; what is left comes with the next

  Settings settings_;
  double rpdo_phase_;
  std::vector<std::unique_ptr<can::Port>> ports_;
  lcm_port::LcmPort* lcm_;
  FrameLog* log_;
  LoopOptions options_;
  Bridge bridge_;
  EStopInput estop_input_;

  Inputs inputs_;
  Outputs outputs_;
  std::vector<std::vector<can::Received>> received_;
  std::array<Setpoint, lcm_port::Inbox::kNewest> setpoints_{};
  std::array<Command, 16> commands_{};
  std::array<bool, kMaxBuses> purge_failed_{};
  std::array<std::int64_t, kMaxBuses> sync_seen_ns_{};
  Status status_{};

  struct Parts {
    std::int64_t core_ns = 0, port_ns = 0, lcm_ns = 0;
  };
  Parts parts_{};
  std::int64_t lap_ns_ = 0;
  std::int64_t start_ns_ = 0;
  std::int64_t stop_since_ns_ = -1;
  std::int64_t deadman_since_ns_ = -1;
  std::uint32_t deadman_heard_ = 0;  // bit j: joint j reported 8130h
  bool deadman_passed_ = false;
  bool deadman_done_ = false;
  std::atomic<bool> stop_ = false;
  std::atomic<bool> estop_ = false;
  std::atomic<State> state_ = State::Idle;
  lcm_port::Ring<Event, 1024> events_;
  LoopFigures figures_;
};

}  // namespace glenoid::bridge
