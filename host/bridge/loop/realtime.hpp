#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/bridge/can/descriptor.hpp"

namespace glenoid::bridge {

/// CLOCK_MONOTONIC and CLOCK_REALTIME, ns.
[[nodiscard]] std::int64_t monotonic_ns() noexcept;
[[nodiscard]] std::int64_t realtime_ns() noexcept;
/// Processor time of the calling thread, ns.
[[nodiscard]] std::int64_t thread_cpu_ns() noexcept;

/// Sleeps until an instant of CLOCK_MONOTONIC; a signal does not end it.
void sleep_until(std::int64_t time_ns) noexcept;
/// The same, awake for the last `awake_ns`: a wake-up that is late by less is not seen. Returns how long it was awake, ns.
std::int64_t wait_until(std::int64_t time_ns, std::int64_t awake_ns) noexcept;

/// While it lives, idle processors stay out of the states that take long to leave (PM QoS, /dev/cpu_dma_latency).
class IdleLatency {
 public:
  /// @param wanted  false: asks for nothing
  explicit IdleLatency(bool wanted) noexcept;
  [[nodiscard]] bool granted() const noexcept { return file_.valid(); }

 private:
  can::Descriptor file_;
};

/// Makes the calling thread real-time as far as the machine permits: SCHED_FIFO, memory locked, stack touched.
/// @param priority  1..99, 0: ordinary scheduling
/// @return what was not permitted, one sentence each; empty: everything was
[[nodiscard]] std::vector<std::string> become_realtime(int priority);

}  // namespace glenoid::bridge
