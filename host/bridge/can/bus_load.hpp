#pragma once

// How much of a classic CAN bus a CANopen mapping takes, in the worst case.

#include <cstddef>
#include <span>

namespace glenoid::can {

/// How many stuff bits to count on.
enum class Stuffing {
  None,   ///< data that never needs any
  Worst,  ///< one after every fourth bit: data that alternates against the rule
};

/// Bits of a classic frame on the wire, with the three bits of interframe space.
///
/// Equation  n data bytes take 47 + 8n bits with an 11-bit identifier and 67 + 8n with 29 bits (ISO 11898-1); between start
///           of frame and CRC lie s = 34 + 8n or 54 + 8n of them, and at worst floor((s - 1) / 4) stuff bits come on top.
///
/// @param[in]  data_bytes  0..8; more is taken as 8.
constexpr std::size_t frame_bits(std::size_t data_bytes, bool extended, Stuffing stuffing) noexcept {
  const std::size_t data_bits = 8 * (data_bytes < 8 ? data_bytes : 8);
  const std::size_t stuffable = (extended ? 54 : 34) + data_bits;
  return (extended ? 67 : 47) + data_bits + (stuffing == Stuffing::Worst ? (stuffable - 1) / 4 : 0);
}

/// A frame that comes again and again.
struct PeriodicFrame {
  std::size_t data_bytes = 0;
  double rate_hz = 0.0;
};

/// Share of a bus that 11-bit frames take; 1 is a full bus.
///
/// @param[in]  frames      data bytes and rate (Hz) of each.
/// @param[in]  bit_rate    bit/s, > 0.
double bus_load(std::span<const PeriodicFrame> frames, double bit_rate, Stuffing stuffing) noexcept;

/// What travels on one bus, as the bridge's configuration states it.
struct BusTraffic {
  double bit_rate = 1e6;                  ///< bit/s
  double sync_rate_hz = 500.0;            ///< SYNC without counter
  std::size_t drives = 6;                 ///< each gets the RPDO and answers with the TPDO, once per SYNC
  std::size_t rpdo_bytes = 6;             ///< controlword, target position
  std::size_t tpdo_bytes = 8;             ///< statusword, position, torque
  double second_tpdo_rate_hz = 0.0;       ///< per drive; 0: none
  std::size_t second_tpdo_bytes = 6;      ///< velocity, error code
  double drive_heartbeat_rate_hz = 10.0;  ///< per drive
  double master_heartbeat_rate_hz = 50.0;
  double reserve = 0.0;  ///< share kept for SDO and EMCY, 0..1, added as it is
};

/// Worst-case share of a bus. More than kLoadRefused must not be configured, more than kLoadWarned deserves a warning.
double worst_case_load(const BusTraffic& traffic) noexcept;
/// The same with any count of stuff bits.
double traffic_load(const BusTraffic& traffic, Stuffing stuffing) noexcept;

inline constexpr double kLoadRefused = 0.90;
inline constexpr double kLoadWarned = 0.80;

}  // namespace glenoid::can
