#pragma once

// The one table of objects: the dictionary, the checks of the SDO server, the PDO mapping rules and the EDS all come from it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace glenoid::drives {

/// Data types by their CiA 301 number.
enum class Type : std::uint8_t { I8 = 2, I16 = 3, I32 = 4, U8 = 5, U16 = 6, U32 = 7, Text = 9 };

enum class Access : std::uint8_t { Const, Ro, Wo, Rw };

/// Which PDOs may carry an object.
enum class Mappable : std::uint8_t { No, Rpdo, Tpdo, Both };

/// One row: an object or one of its sub-indices.
struct Object {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::string_view record;  ///< name of the array or record the row belongs to; empty for a plain variable
  std::string_view name;
  Type type = Type::U32;
  Access access = Access::Ro;
  Mappable mappable = Mappable::No;
  std::int64_t value = 0;  ///< default
  bool per_node = false;   ///< the node id is added to the default
};

constexpr int size_of(Type type) noexcept {
  switch (type) {
    case Type::I8:
    case Type::U8:
      return 1;
    case Type::I16:
    case Type::U16:
      return 2;
    case Type::I32:
    case Type::U32:
      return 4;
    case Type::Text:
      return 0;
  }
  return 0;
}

constexpr std::int64_t lowest(Type type) noexcept {
  const bool is_signed = type == Type::I8 || type == Type::I16 || type == Type::I32;
  return is_signed ? -(std::int64_t{1} << (8 * size_of(type) - 1)) : 0;
}

constexpr std::int64_t highest(Type type) noexcept {
  const bool is_signed = type == Type::I8 || type == Type::I16 || type == Type::I32;
  return (std::int64_t{1} << (8 * size_of(type) - (is_signed ? 1 : 0))) - 1;
}

inline constexpr int kPdos = 4;           ///< in each direction
inline constexpr int kMappedObjects = 8;  ///< at most, in one PDO
inline constexpr int kErrorHistory = 8;   ///< entries of 1003h
inline constexpr int kConsumers = 2;      ///< entries of 1016h
inline constexpr std::int64_t kPdoInvalid = std::int64_t{1} << 31;
inline constexpr std::int64_t kPdoNoRemote = std::int64_t{1} << 30;  ///< remote frames are not answered
inline constexpr std::int64_t kSaves = 1;                            ///< 1010h, 1011h: on command

/// Collects rows in order of address.
class TableBuilder {
 public:
  static constexpr std::size_t kCapacity = 256;
  std::array<Object, kCapacity> rows{};
  std::size_t count = 0;

  consteval void add(const Object& row) { rows[count++] = row; }

  consteval void variable(std::uint16_t index, std::string_view name, Type type, Access access, std::int64_t value = 0,
                          Mappable mappable = Mappable::No, bool per_node = false) {
    add({index, 0, "", name, type, access, mappable, value, per_node});
  }
  /// Begins a record or array whose highest sub-index is `highest_sub`.
  consteval void record(std::uint16_t index, std::string_view name, std::int64_t highest_sub) {
    record_ = {index, name, 0};
    add({index, 0, name, "Highest sub-index supported", Type::U8, Access::Const, Mappable::No, highest_sub, false});
  }
  /// The next sub-index of the record begun last.
  consteval void entry(std::string_view name, Type type, Access access, std::int64_t value = 0, bool per_node = false,
                       std::uint8_t sub = 0) {
    record_.sub = sub != 0 ? sub : static_cast<std::uint8_t>(record_.sub + 1);
    add({record_.index, record_.sub, record_.name, name, type, access, Mappable::No, value, per_node});
  }

 private:
  struct Record {
    std::uint16_t index = 0;
    std::string_view name;
    std::uint8_t sub = 0;
  } record_;
};

consteval void add_identity(TableBuilder& table) {
  table.variable(0x1000, "Device type", Type::U32, Access::Const, 0x00020192);  // servo drive, CiA 402
  table.variable(0x1001, "Error register", Type::U8, Access::Ro, 0, Mappable::Tpdo);
  table.record(0x1003, "Pre-defined error field", 0);
  table.rows[table.count - 1].access = Access::Rw;
  for (int k = 0; k < kErrorHistory; ++k) table.entry("Standard error field", Type::U32, Access::Ro);
  table.variable(0x1005, "COB-ID SYNC", Type::U32, Access::Rw, 0x80);
  table.variable(0x1006, "Communication cycle period", Type::U32, Access::Rw);  // us, 0 = not supervised
  table.variable(0x1008, "Manufacturer device name", Type::Text, Access::Const);
  table.variable(0x1009, "Manufacturer hardware version", Type::Text, Access::Const);
  table.variable(0x100A, "Manufacturer software version", Type::Text, Access::Const);
  table.record(0x1010, "Store parameters", 1);
  table.entry("Save all parameters", Type::U32, Access::Rw, kSaves);
  table.record(0x1011, "Restore default parameters", 1);
  table.entry("Restore all default parameters", Type::U32, Access::Rw, kSaves);
  table.variable(0x1014, "COB-ID EMCY", Type::U32, Access::Rw, 0x80, Mappable::No, true);
  table.variable(0x1015, "Inhibit time EMCY", Type::U16, Access::Rw);  // 100 us
  table.record(0x1016, "Consumer heartbeat time", kConsumers);
  for (int k = 0; k < kConsumers; ++k) table.entry("Consumer heartbeat time", Type::U32, Access::Rw);
  table.variable(0x1017, "Producer heartbeat time", Type::U16, Access::Rw);  // ms
  table.record(0x1018, "Identity", 4);
  table.entry("Vendor-ID", Type::U32, Access::Const);
  table.entry("Product code", Type::U32, Access::Const);
  table.entry("Revision number", Type::U32, Access::Const);
  table.entry("Serial number", Type::U32, Access::Const, 0, true);
  table.variable(0x1019, "Synchronous counter overflow value", Type::U8, Access::Rw);
  table.record(0x1029, "Error behaviour", 1);
  table.entry("Communication error", Type::U8, Access::Rw);
}

/// Defaults as CiA 402 proposes: PDO 1 carries control- or statusword, PDO 2 the mode, PDO 3 the position; 2 to 4 are off.
consteval std::int64_t default_mapping(bool transmit, int pdo, int entry) {
  if (pdo >= 3 || entry > (pdo == 0 ? 0 : 1)) return 0;
  if (entry == 0) return transmit ? 0x60410010 : 0x60400010;
  if (pdo == 1) return transmit ? 0x60610008 : 0x60600008;
  return transmit ? 0x60640020 : 0x607A0020;
}

consteval void add_pdo_parameters(TableBuilder& table, bool transmit) {
  for (int pdo = 0; pdo < kPdos; ++pdo) {
    const auto base = static_cast<std::uint16_t>((transmit ? 0x1800 : 0x1400) + pdo);
    const std::int64_t id = (transmit ? 0x180 + kPdoNoRemote : 0x200) + 0x100 * pdo;
    table.record(base, transmit ? "TPDO communication parameter" : "RPDO communication parameter", transmit ? 6 : 5);
    table.entry(transmit ? "COB-ID used by TPDO" : "COB-ID used by RPDO", Type::U32, Access::Rw,
                pdo == 0 ? id : id + kPdoInvalid, true);
    table.entry("Transmission type", Type::U8, Access::Rw, 255);
    if (transmit) table.entry("Inhibit time", Type::U16, Access::Rw);  // 100 us
    table.entry("Event timer", Type::U16, Access::Rw, 0, false, 5);    // ms; of an RPDO: its deadline
    if (transmit) table.entry("SYNC start value", Type::U8, Access::Rw, 0, false, 6);
  }
}

consteval void add_pdo_mapping(TableBuilder& table, bool transmit) {
  for (int pdo = 0; pdo < kPdos; ++pdo) {
    const auto base = static_cast<std::uint16_t>((transmit ? 0x1A00 : 0x1600) + pdo);
    table.record(base, transmit ? "TPDO mapping parameter" : "RPDO mapping parameter",
                 pdo == 3 ? 0 : (pdo == 0 ? 1 : 2));
    table.rows[table.count - 1].access = Access::Rw;
    for (int k = 0; k < kMappedObjects; ++k) {
      table.entry("Mapped object", Type::U32, Access::Rw, default_mapping(transmit, pdo, k));
    }
  }
}

consteval void add_vendor(TableBuilder& table) {
  table.record(0x2F00, "Fault injection", 3);
  table.entry("Kind", Type::U8, Access::Rw);  // FaultKind; writing it starts the fault
  table.entry("Amount", Type::U32, Access::Rw);
  table.entry("Duration", Type::U32, Access::Rw);  // ms
  table.record(0x2F10, "Reaction to communication errors", 4);
  table.entry("Loss of SYNC", Type::U8, Access::Rw, 1);        // Reaction; supervised while 1006h is not 0
  table.entry("SYNC tolerance", Type::U32, Access::Rw, 1000);  // us beyond 1006h
  table.entry("RPDO time-out", Type::U8, Access::Rw, 1);       // Reaction; supervised while 14xxh:05 is not 0
  table.entry("PDO length", Type::U8, Access::Rw, 1);          // Reaction
  table.variable(0x2F20, "Label", Type::Text, Access::Rw);     // free text of the user
}

consteval void add_device_control(TableBuilder& table) {
  table.variable(0x603F, "Error code", Type::U16, Access::Ro, 0, Mappable::Tpdo);
  table.variable(0x6040, "Controlword", Type::U16, Access::Rw, 0, Mappable::Both);
  table.variable(0x6041, "Statusword", Type::U16, Access::Ro, 0, Mappable::Tpdo);
  table.variable(0x605A, "Quick stop option code", Type::I16, Access::Rw, 2);
  table.variable(0x605B, "Shutdown option code", Type::I16, Access::Rw, 0);
  table.variable(0x605C, "Disable operation option code", Type::I16, Access::Rw, 1);
  table.variable(0x605D, "Halt option code", Type::I16, Access::Rw, 1);
  table.variable(0x605E, "Fault reaction option code", Type::I16, Access::Rw, 2);
  table.variable(0x6060, "Modes of operation", Type::I8, Access::Rw, 0, Mappable::Both);
  table.variable(0x6061, "Modes of operation display", Type::I8, Access::Ro, 0, Mappable::Tpdo);
}

consteval void add_motion(TableBuilder& table) {
  table.variable(0x6062, "Position demand value", Type::I32, Access::Ro, 0, Mappable::Tpdo);
  table.variable(0x6064, "Position actual value", Type::I32, Access::Ro, 0, Mappable::Tpdo);
  table.variable(0x6065, "Following error window", Type::U32, Access::Rw, 20000);             // counts, FFFFFFFFh = off
  table.variable(0x6066, "Following error time out", Type::U16, Access::Rw, 10);              // ms
  table.variable(0x606C, "Velocity actual value", Type::I32, Access::Ro, 0, Mappable::Tpdo);  // counts/s
  table.variable(0x6072, "Max torque", Type::U16, Access::Rw, 1000, Mappable::Both);          // per mille of 6076h
  table.variable(0x6076, "Motor rated torque", Type::U32, Access::Ro);                        // mNm
  table.variable(0x6077, "Torque actual value", Type::I16, Access::Ro, 0, Mappable::Tpdo);    // per mille of 6076h
  table.variable(0x607A, "Target position", Type::I32, Access::Rw, 0, Mappable::Both);
  table.record(0x607D, "Software position limit", 2);
  table.entry("Min position limit", Type::I32, Access::Rw, lowest(Type::I32));
  table.entry("Max position limit", Type::I32, Access::Rw, highest(Type::I32));
  table.variable(0x607F, "Max profile velocity", Type::U32, Access::Rw, highest(Type::U32));  // counts/s
  table.variable(0x6084, "Profile deceleration", Type::U32, Access::Rw, 1000000);             // counts/s^2
  table.variable(0x6085, "Quick stop deceleration", Type::U32, Access::Rw, 5000000);          // counts/s^2
  table.record(0x608F, "Position encoder resolution", 2);
  table.entry("Encoder increments", Type::U32, Access::Ro, 1);
  table.entry("Motor revolutions", Type::U32, Access::Ro, 1);
  table.record(0x6091, "Gear ratio", 2);
  table.entry("Motor revolutions", Type::U32, Access::Ro, 1);
  table.entry("Shaft revolutions", Type::U32, Access::Ro, 1);
  table.variable(0x60B0, "Position offset", Type::I32, Access::Rw, 0, Mappable::Both);
  table.variable(0x60B1, "Velocity offset", Type::I32, Access::Rw, 0, Mappable::Both);
  table.variable(0x60B2, "Torque offset", Type::I16, Access::Rw, 0, Mappable::Both);
  table.record(0x60C2, "Interpolation time period", 2);
  table.entry("Interpolation time period value", Type::U8, Access::Rw, 1);
  table.entry("Interpolation time index", Type::I8, Access::Rw, -3);
  table.variable(0x60F4, "Following error actual value", Type::I32, Access::Ro, 0, Mappable::Tpdo);
  table.variable(0x6502, "Supported drive modes", Type::U32, Access::Ro, 0x80);  // what is simulated: csp
}

consteval TableBuilder build_table() {
  TableBuilder table;
  add_identity(table);
  add_pdo_parameters(table, false);
  add_pdo_mapping(table, false);
  add_pdo_parameters(table, true);
  add_pdo_mapping(table, true);
  add_vendor(table);
  table.variable(0x6007, "Abort connection option code", Type::I16, Access::Rw, 1);
  add_device_control(table);
  add_motion(table);
  return table;
}

inline constexpr TableBuilder kBuiltTable = build_table();
inline constexpr std::size_t kObjects = kBuiltTable.count;

/// All rows, in order of address.
inline constexpr std::array<Object, kObjects> kObjectTable = [] {
  std::array<Object, kObjects> rows{};
  for (std::size_t k = 0; k < kObjects; ++k) rows[k] = kBuiltTable.rows[k];
  return rows;
}();

/// Row of an address; kObjects if the table has none.
constexpr std::size_t find_row(std::uint16_t index, std::uint8_t sub) noexcept {
  std::size_t low = 0, high = kObjects;
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    const Object& row = kObjectTable[middle];
    if (row.index < index || (row.index == index && row.sub < sub)) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  const bool found = low < kObjects && kObjectTable[low].index == index && kObjectTable[low].sub == sub;
  return found ? low : kObjects;
}

/// Row of an address that the code itself names: a misspelt one does not compile.
consteval std::size_t row_of(std::uint16_t index, std::uint8_t sub = 0) {
  const std::size_t row = find_row(index, sub);
  if (row == kObjects) throw "no such object";
  return row;
}

/// What an object accepts beyond what its type can hold.
struct Range {
  std::size_t row = 0;
  std::int64_t low = 0, high = 0;
};
inline constexpr std::array kRanges = {
    Range{row_of(0x1003, 0), 0, 0},        // only cleared
    Range{row_of(0x1019), 0, 240},         // 1 is refused by the drive
    Range{row_of(0x1029, 1), 0, 2},        // pre-operational, no change, stopped
    Range{row_of(0x2F00, 1), 0, 8},        // FaultKind
    Range{row_of(0x2F10, 1), 0, 5},        // Reaction
    Range{row_of(0x2F10, 3), 0, 5},        // Reaction
    Range{row_of(0x2F10, 4), 0, 5},        // Reaction
    Range{row_of(0x6007), 0, 3},           // nothing, fault, disable voltage, quick stop
    Range{row_of(0x605A), 0, 7},           // 4 is refused by the drive
    Range{row_of(0x605B), 0, 1},           // off, ramp
    Range{row_of(0x605C), 0, 1},           // off, ramp
    Range{row_of(0x605D), 1, 2},           // profile ramp, quick-stop ramp
    Range{row_of(0x605E), 0, 3},           // off, profile ramp, quick-stop ramp, current limit
    Range{row_of(0x6085), 1, 0xFFFFFFFF},  // counts/s^2
    Range{row_of(0x6084), 1, 0xFFFFFFFF},  // counts/s^2
    Range{row_of(0x60C2, 2), -6, 0},       // us to s
};

/// Range of a row.
constexpr Range range_of(std::size_t row) noexcept {
  for (const Range& range : kRanges) {
    if (range.row == row) return range;
  }
  return {row, lowest(kObjectTable[row].type), highest(kObjectTable[row].type)};
}

}  // namespace glenoid::drives
