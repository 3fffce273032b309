#pragma once

// The one table of process data: codec, start-up sequence, EDS, DBC and bus load read it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace glenoid::bridge {

/// An object of the dictionary inside a PDO.
struct PdoEntry {
  std::uint16_t index;
  std::uint8_t subindex;
  std::uint8_t bits;
  bool is_signed;
  std::string_view name;
  std::string_view unit;  ///< of one count; empty: none

  /// As 16xxh and 1Axxh hold it.
  [[nodiscard]] constexpr std::uint32_t mapping() const noexcept {
    return (static_cast<std::uint32_t>(index) << 16) | (static_cast<std::uint32_t>(subindex) << 8) | bits;
  }
};

/// A PDO, seen from the drive: receive PDOs go to it.
struct Pdo {
  std::string_view name;
  bool receive;
  std::uint16_t communication;  ///< 14xxh or 18xxh
  std::uint16_t mapping;        ///< 16xxh or 1Axxh
  std::uint32_t cob_id;         ///< plus node id
  std::uint8_t transmission;    ///< type: 1 = every SYNC
  std::span<const PdoEntry> entries;

  [[nodiscard]] constexpr std::uint8_t bytes() const noexcept {
    std::size_t bits = 0;
    for (const PdoEntry& entry : entries) bits += entry.bits;
    return static_cast<std::uint8_t>(bits / 8);
  }
};

inline constexpr std::array<PdoEntry, 2> kRpdo1Entries = {{
    {0x6040, 0, 16, false, "controlword", ""},
    {0x607A, 0, 32, true, "target_position", "count"},
}};
inline constexpr std::array<PdoEntry, 3> kTpdo1Entries = {{
    {0x6041, 0, 16, false, "statusword", ""},
    {0x6064, 0, 32, true, "position_actual", "count"},
    {0x6077, 0, 16, true, "torque_actual", "per mille of rated torque"},
}};

inline constexpr std::array<PdoEntry, 2> kTpdo2Entries = {{
    {0x606C, 0, 32, true, "velocity_actual", "count/s"},
    {0x603F, 0, 16, false, "error_code", ""},
}};

inline constexpr Pdo kRpdo1 = {"RPDO1", true, 0x1400, 0x1600, 0x200, 1, kRpdo1Entries};
inline constexpr Pdo kTpdo1 = {"TPDO1", false, 0x1800, 0x1A00, 0x180, 1, kTpdo1Entries};
/// Off unless the configuration asks for it, and how often.
inline constexpr Pdo kTpdo2 = {"TPDO2", false, 0x1801, 0x1A01, 0x280, 10, kTpdo2Entries};
inline constexpr std::array<Pdo, 3> kPdoTable = {kRpdo1, kTpdo1, kTpdo2};

static_assert(kRpdo1.bytes() == 6 && kTpdo1.bytes() == 8 && kTpdo2.bytes() == 6);

}  // namespace glenoid::bridge
