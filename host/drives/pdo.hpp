#pragma once

#include <array>
#include <cstdint>

#include "host/bridge/can/frame.hpp"
#include "host/drives/dictionary.hpp"

namespace glenoid::drives {

/// Which objects a PDO carries, resolved from its mapping record.
struct PdoMap {
  struct Field {
    std::size_t row = kObjects;  ///< kObjects: a dummy, skipped
    std::size_t bytes = 0;
  };
  std::array<Field, kMappedObjects> fields{};
  std::size_t count = 0;
  std::size_t bytes = 0;
};

/// Checks a write to an identifier (1014h, 14xxh:01, 18xxh:01): bit 31 off, 11 bits, not one of another service, and not another
/// one while it is in use.
Abort check_cob_id(std::int64_t old, std::int64_t value) noexcept;

/// Checks a write to a communication or mapping record (1400h to 1BFFh) against the rules of re-mapping.
Abort check_pdo_write(const Dictionary& objects, std::size_t row, std::int64_t value, bool operational,
                      bool dummy_mapping) noexcept;

/// PDOs a drive receives. Synchronous ones wait for the SYNC that makes them active.
class ReceivePdos {
 public:
  enum class Outcome : std::uint8_t { NotMine, Waits, Active, TooShort, TooLong };

  /// Takes parameters and mapping of a PDO (from 0) over from the dictionary and forgets what waits.
  void configure(const Dictionary& objects, int pdo) noexcept;
  /// The same for all.
  void configure(const Dictionary& objects) noexcept;
  /// Whether a PDO in use has this identifier.
  [[nodiscard]] bool takes(std::uint32_t id) const noexcept;
  /// A frame. TooLong: the mapped part was taken; TooShort: nothing was.
  Outcome receive(Dictionary& objects, const can::Frame& frame, std::int64_t now_ns) noexcept;
  /// SYNC: what waits becomes active. Returns how many PDOs that were.
  int activate(Dictionary& objects) noexcept;
  /// Number of the PDO (from 1) whose deadline passed, told once per loss; 0 none.
  int expired(const Dictionary& objects, std::int64_t now_ns) noexcept;

 private:
  struct Pdo {
    std::uint32_t id = 0;
    bool valid = false;
    bool synchronous = false;
    bool waits = false;
    bool monitored = false;  ///< has come since it was configured and is not overdue
    std::int64_t last_ns = 0;
    PdoMap map;
    can::Frame frame;
  };
  static void write(Dictionary& objects, const Pdo& pdo) noexcept;

  std::array<Pdo, kPdos> pdos_{};
};

/// PDOs a drive sends.
class TransmitPdos {
 public:
  /// Takes parameters and mapping of a PDO (from 0) over from the dictionary; it counts as not yet sent.
  void configure(const Dictionary& objects, int pdo) noexcept;
  /// The same for all.
  void configure(const Dictionary& objects) noexcept;
  /// SYNC: which PDOs are due, as a bit mask. @param counter  of the SYNC frame, 0 without
  unsigned on_sync(const Dictionary& objects, unsigned counter) noexcept;
  /// Whether any PDO may be due without a SYNC.
  [[nodiscard]] bool event_driven() const noexcept;
  /// Event-driven PDOs that are due now: changed and not inhibited, or their timer ran out.
  unsigned on_time(const Dictionary& objects, std::int64_t now_ns) noexcept;
  /// The frame of a PDO with the objects' present values; it counts as sent.
  can::Frame sample(const Dictionary& objects, int pdo, std::int64_t now_ns) noexcept;

 private:
  struct Pdo {
    std::uint32_t id = 0;
    bool valid = false;
    unsigned type = 255;
    std::int64_t inhibit_ns = 0, event_ns = 0;
    unsigned start = 0;    ///< SYNC start value still waited for, 0 none
    unsigned elapsed = 0;  ///< SYNCs since the last transmission
    bool sent = false;     ///< since it was configured
    std::int64_t last_ns = 0;
    PdoMap map;
    can::Frame frame;  ///< the last sent
  };
  static can::Frame encode(const Dictionary& objects, const Pdo& pdo) noexcept;

  std::array<Pdo, kPdos> pdos_{};
};

}  // namespace glenoid::drives
