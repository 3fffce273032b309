#pragma once

// One simulated drive on a desk: a master's view of it, without a bus and without a clock.

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <vector>

#include "host/drives/drive.hpp"

namespace glenoid::test {

inline constexpr std::int64_t kMs = 1'000'000;

/// Answer to an SDO request.
struct SdoAnswer {
  std::uint32_t abort = 0;  ///< 0: done
  std::int64_t value = 0;   ///< of an upload, unsigned
};

class DriveBench {
 public:
  explicit DriveBench(const drives::Profile& profile = {}, const drives::Placement& placement = {});

  /// Everything the drive sent since it was asked last.
  std::vector<can::Frame> take();
  /// The frames of an identifier among them; the others are lost.
  std::vector<can::Frame> take(std::uint32_t id);

  void give(std::uint32_t id, std::initializer_list<unsigned> bytes);
  /// Lets time pass in steps of at most 0.5 ms.
  void wait(std::int64_t ns);

  SdoAnswer upload(std::uint16_t index, std::uint8_t sub = 0);
  std::uint32_t download(std::uint16_t index, std::uint8_t sub, std::int64_t value, int bytes);

  /// Re-maps a PDO of the drive in the order CiA 301 asks for; true if every write was accepted.
  bool map(std::uint16_t communication, std::int64_t cob_id, unsigned type,
           std::initializer_list<std::uint32_t> objects);

  /// Boots, maps RPDO1 {6040h, 607Ah} and TPDO1 {6041h, 6064h, 6077h} to every SYNC, mode 8, 2 ms, operational.
  void prepare();
  /// Controlwords 06h, 07h, 0Fh over PDOs and SYNCs, the target at the actual position.
  void enable();

  void sync();
  /// RPDO1 with controlword and target, counts.
  void setpoint(unsigned controlword, std::int64_t target);
  /// One bus cycle of 2 ms that begins now: SYNC, setpoint for the next SYNC, the rest of the time.
  void cycle(unsigned controlword, std::int64_t target);
  /// Statusword and position of the last TPDO1.
  struct Feedback {
    unsigned statusword = 0;
    std::int64_t position = 0;
    int torque = 0;
  };
  std::optional<Feedback> feedback();

  [[nodiscard]] std::int64_t counts(double rad) const;
  [[nodiscard]] unsigned state() const;  ///< 6041h masked to the state bits

  drives::Drive drive;
  std::int64_t now_ns = 0;

 private:
  drives::Outbox out_;
  std::vector<can::Frame> frames_;
  void collect();
};

}  // namespace glenoid::test
