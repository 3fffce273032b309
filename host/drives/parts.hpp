#pragma once

// What a Drive is made of. Private to this directory.

#include <array>
#include <cstdint>

#include "host/drives/dictionary.hpp"
#include "host/drives/drive.hpp"
#include "host/drives/emergency.hpp"
#include "host/drives/line.hpp"
#include "host/drives/pdo.hpp"
#include "host/drives/power.hpp"
#include "host/drives/sdo_server.hpp"
#include "host/drives/servo.hpp"

namespace glenoid::drives {

/// What a communication error does, as in 2F10h.
enum class Reaction : std::uint8_t { None = 0, Report = 1, Hold = 2, QuickStop = 3, Fault = 4, DisableVoltage = 5 };

/// Motor side of a drive: CiA 402 over the dictionary, the reference and the servo.
class Motion {
 public:
  Motion(const Profile& profile, double position_rad) noexcept;

  void restart(Dictionary& objects) noexcept;
  /// Whole servo steps until `now_ns`, and the rest of a step too if `exactly`.
  void advance(Dictionary& objects, std::int64_t now_ns, bool exactly) noexcept;
  /// Controlword and mode of the dictionary became active.
  void control(Dictionary& objects, std::int64_t now_ns) noexcept;
  /// SYNC, or a target without SYNC: go to 607Ah within 60C2h.
  void follow(Dictionary& objects) noexcept;
  /// Reaction to trouble.
  void quick_stop(const Dictionary& objects) noexcept;
  void disable_voltage(const Dictionary& objects) noexcept;
  void fail(Dictionary& objects, std::uint16_t code) noexcept;
  void stand_still() noexcept { reference_.hold(reference_.position()); }
  /// Bits of 6041h that communication knows: remote, synchronised, SYNC lost.
  void set_link_bits(std::uint16_t bits, bool lost) noexcept;
  /// Writes what can be read from outside into the dictionary.
  void publish(Dictionary& objects) const noexcept;

  /// Code of a fault that arose in the motion since the last call, 0 none.
  std::uint16_t take_fault() noexcept;
  /// True once after a fault was reset.
  bool take_reset() noexcept;

  [[nodiscard]] Servo& servo() noexcept { return servo_; }
  [[nodiscard]] const Servo& servo() const noexcept { return servo_; }
  [[nodiscard]] const Reference& reference() const noexcept { return reference_; }
  [[nodiscard]] const Power& power() const noexcept { return power_; }
  [[nodiscard]] double counts_per_rad() const noexcept { return counts_per_rad_; }
  [[nodiscard]] double worst_following_error_rad() const noexcept { return worst_error_rad_; }
  [[nodiscard]] std::uint16_t statusword(const Dictionary& objects) const noexcept;

 private:
  void apply(PowerEffect effect, const Dictionary& objects) noexcept;
  void step(Dictionary& objects, double step_s) noexcept;
  void watch_following_error(Dictionary& objects, double step_s) noexcept;
  [[nodiscard]] double following_error_rad() const noexcept { return reference_.position() - servo_.measured(); }
  [[nodiscard]] bool follows() const noexcept;

  Mechanics mechanics_;
  std::int64_t enable_ns_;
  double counts_per_rad_;
  Power power_;
  Reference reference_;
  Servo servo_;
  std::int64_t servo_ns_ = -1;
  std::int64_t enable_at_ns_ = 0;
  std::int64_t mode_ = 0;
  std::uint16_t link_bits_ = 0;
  bool halted_ = false, fresh_ = false, limited_ = false, following_error_ = false, sync_lost_ = false;
  double error_time_s_ = 0.0, worst_error_rad_ = 0.0;
  std::uint16_t fault_ = 0;
  bool was_reset_ = false;
};

/// 60C2h as a period, s; one servo step if it is 0.
double interpolation_period_s(const Dictionary& objects) noexcept;

/// The drive: communication side, and the motion behind it.
struct Drive::Parts final : ObjectServer {
  Parts(const Profile& profile, const Placement& placement);

  // drive.cpp
  std::int64_t forward(std::int64_t now_ns) noexcept;
  void boot(std::int64_t now_ns) noexcept;
  void advance(std::int64_t now_ns, Outbox& out) noexcept;
  void receive(const can::Frame& frame, std::int64_t now_ns, Outbox& out) noexcept;
  void inject(const Fault& fault, std::int64_t now_ns, Outbox& out) noexcept;
  void end_fault() noexcept;
  [[nodiscard]] bool deaf() const noexcept;
  [[nodiscard]] bool concerns(const can::Frame& frame) const noexcept;

  // objects.cpp
  Abort read(std::uint16_t index, std::uint8_t sub, std::span<std::uint8_t> into, std::size_t& size) noexcept override;
  Abort writable(std::uint16_t index, std::uint8_t sub) noexcept override;
  Abort write(std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> bytes,
              bool size_known) noexcept override;
  Abort check(std::size_t row, std::int64_t value) const noexcept;
  void written(std::size_t row) noexcept;

  // communication.cpp
  void on_nmt(const can::Frame& frame) noexcept;
  void enter(Nmt state) noexcept;
  void reset_communication() noexcept;
  void on_sync(const can::Frame& frame, Outbox& out) noexcept;
  void count_sync() noexcept;
  void on_pdo(const can::Frame& frame) noexcept;
  void on_sdo(const can::Frame& frame, Outbox& out) noexcept;
  void on_heartbeat(const can::Frame& frame) noexcept;
  void watch() noexcept;
  void connection_lost(std::uint16_t code) noexcept;
  void react(std::uint16_t code, Reaction reaction) noexcept;
  void good_news() noexcept;
  void report(std::uint16_t code) noexcept;
  void produce(Outbox& out) noexcept;
  void send_heartbeat(Outbox& out) noexcept;
  void update_link_bits() noexcept;

  Profile profile;
  Placement placement;
  Dictionary objects;
  SdoServer sdo;
  ReceivePdos received;
  TransmitPdos transmitted;
  Emergency emergency;
  Motion motion;
  Line line;
  DriveCounters counters;

  Nmt nmt = Nmt::Initialising;
  std::int64_t now_ns = -1;
  std::int64_t boot_done_ns = -1;
  std::int64_t next_heartbeat_ns = -1;
  std::int64_t last_sync_ns = -1;
  bool sync_lost = false;
  bool warned = false;  ///< an error that was only reported is in 1001h
  bool fresh_setpoint = false;

  struct Consumer {
    std::int64_t last_ns = -1;  ///< -1: not yet heard
  };
  std::array<Consumer, kConsumers> consumers{};

  Fault fault;
  std::int64_t fault_end_ns = -1;
  Fault requested;  ///< by a write to 2F00h, injected after the answer
  bool request_waits = false;
};

}  // namespace glenoid::drives
