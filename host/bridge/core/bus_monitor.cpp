#include "host/bridge/core/bus_monitor.hpp"

#include "host/bridge/can/bus_load.hpp"
#include "host/bridge/can/error_frame.hpp"

namespace glenoid::bridge {
namespace {

constexpr std::int64_t kLoadWindowNs = 1'000'000'000;

BusState state_of(can::ControllerState state) noexcept {
  switch (state) {
    case can::ControllerState::Active:
      return BusState::Active;
    case can::ControllerState::Warning:
      return BusState::Warning;
    case can::ControllerState::Passive:
      return BusState::Passive;
    case can::ControllerState::Off:
      break;
  }
  return BusState::Off;
}

}  // namespace

void BusMonitor::observe(const BusInput& input) noexcept {
  link_up_ = input.link == can::Link::Up;
  outstanding_ = input.outstanding;
  refuses_ = input.counters.refused > refused_;
  refused_ = input.counters.refused;
  const bool sent = input.counters.sent > sent_;
  sent_ = input.counters.sent;
  if (outstanding_ > 0 || refuses_)
    ++failures_;
  else if (sent)
    failures_ = 0;
  if (purge_asked_) {
    purge_asked_ = false;
    // Where purging failed, only the echo of the last frame proves that nothing waits.
    purge_needed_ = input.purge_failed;
  }
  if (purge_needed_ && !purge_pending_ && outstanding_ == 0 && writable()) purge_needed_ = false;
  status_.refused = static_cast<std::int64_t>(input.counters.refused);
  status_.outstanding = static_cast<std::int64_t>(outstanding_);
  status_.overruns = static_cast<std::int64_t>(input.counters.overruns);
}

void BusMonitor::receive(const can::Frame& frame) noexcept {
  if (!frame.error) {
    load_bits_ += static_cast<double>(can::frame_bits(frame.size, frame.extended, can::Stuffing::None));
    return;
  }
  const can::ErrorReport report = can::decode_error(frame);
  if (report.has_state) {
    status_.state = state_of(report.state);
    if (report.state == can::ControllerState::Off) off_ = true;  // stays until restart(), whatever comes later
  }
  if (report.restarted && !off_) status_.state = BusState::Active;
  if (report.has_counters) {
    status_.tx_errors = report.tx_errors;
    status_.rx_errors = report.rx_errors;
  }
}

void BusMonitor::measure_load(std::int64_t now_ns) noexcept {
  const std::int64_t elapsed_ns = now_ns - load_since_ns_;
  if (elapsed_ns < kLoadWindowNs) return;
  status_.load = static_cast<float>(load_bits_ / (1e-9 * static_cast<double>(elapsed_ns) * bit_rate_));
  load_bits_ = 0.0;
  load_since_ns_ = now_ns;
}

void BusMonitor::request_purge() noexcept {
  if (outstanding_ == 0 && !off_) return;  // nothing is queued
  purge_pending_ = purge_needed_ = true;
}

bool BusMonitor::take_purge() noexcept {
  const bool purge = purge_pending_;
  purge_pending_ = false;
  purge_asked_ = purge_asked_ || purge;
  return purge;
}

void BusMonitor::restart() noexcept {
  if (!off_) return;
  off_ = false;
  status_.state = BusState::Active;
  purge_pending_ = purge_needed_ = true;
}

BusStatus BusMonitor::status() const noexcept {
  BusStatus status = status_;
  if (!link_up_)
    status.state = BusState::Down;
  else if (off_)
    status.state = BusState::Off;
  return status;
}

}  // namespace glenoid::bridge
