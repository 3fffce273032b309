#include "host/bridge/can/bus_load.hpp"

#include <array>

namespace glenoid::can {

double bus_load(std::span<const PeriodicFrame> frames, double bit_rate, Stuffing stuffing) noexcept {
  double bits_per_s = 0.0;
  for (const PeriodicFrame& frame : frames) {
    bits_per_s += static_cast<double>(frame_bits(frame.data_bytes, false, stuffing)) * frame.rate_hz;
  }
  return bits_per_s / bit_rate;
}

double traffic_load(const BusTraffic& traffic, Stuffing stuffing) noexcept {
  const auto drives = static_cast<double>(traffic.drives);
  const std::array<PeriodicFrame, 6> frames = {{
      {0, traffic.sync_rate_hz},
      {traffic.rpdo_bytes, drives * traffic.sync_rate_hz},
      {traffic.tpdo_bytes, drives * traffic.sync_rate_hz},
      {traffic.second_tpdo_bytes, drives * traffic.second_tpdo_rate_hz},
      {1, drives * traffic.drive_heartbeat_rate_hz},
      {1, traffic.master_heartbeat_rate_hz},
  }};
  return bus_load(frames, traffic.bit_rate, stuffing) + traffic.reserve;
}

double worst_case_load(const BusTraffic& traffic) noexcept { return traffic_load(traffic, Stuffing::Worst); }

}  // namespace glenoid::can
