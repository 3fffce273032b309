#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "host/bridge/core/messages.hpp"
#include "host/bridge/core/producer_clock.hpp"
#include "host/bridge/core/settings.hpp"

namespace glenoid::bridge {

/// Decides which setpoints count. Each is used whole or not at all; every refusal has one reason.
class Gate {
 public:
  explicit Gate(const Settings& settings) noexcept;

  /// A session begins; nothing of an older one counts any more.
  void open(std::int64_t session) noexcept;
  void close() noexcept { session_ = 0; }

  /// What a setpoint is compared with.
  struct Command {
    std::span<const double> position_rad;  ///< previous command of each joint
    std::int64_t stamp_ns = 0;             ///< instant of the producer's clock it stands for
    bool moving = false;                   ///< a motion runs; before that the start windows apply
    bool joining = false;                  ///< it has not been caught up with yet: up to the start window is normal
  };

  /// @param now_ns  our clock
  /// @param clock   of the producer; observes every setpoint of this session that is new and well-formed
  /// @return None: accepted and remembered.
  Rejection check(const Setpoint& setpoint, std::int64_t now_ns, const Command& command, ProducerClock& clock) noexcept;

  /// Two sources use this session's token: sequence numbers step back while stamps go on, or one number has two stamps.
  [[nodiscard]] bool two_publishers() const noexcept { return conflicts_ >= kConflicts; }

  [[nodiscard]] std::int64_t session() const noexcept { return session_; }
  [[nodiscard]] std::int64_t sequence() const noexcept { return last_sequence_; }
  [[nodiscard]] bool any() const noexcept { return last_sequence_ >= 0; }
  /// Joint, value and limit of the last refusal, where it was about one joint.
  struct Detail {
    std::int32_t joint = -1;
    double value = 0.0;
    double limit = 0.0;
  };
  [[nodiscard]] const Detail& detail() const noexcept { return detail_; }

 private:
  static constexpr int kConflicts = 2;         // one may be a producer that restarted its numbers by mistake
  static constexpr std::size_t kHistory = 64;  // accepted (sequence, stamp) pairs that a repetition is recognised by

  struct Seen {
    std::int64_t sequence = -1;
    std::int64_t time_ns = 0;
  };

  [[nodiscard]] Rejection form(const Setpoint& setpoint) noexcept;
  [[nodiscard]] Rejection order(const Setpoint& setpoint) noexcept;
  [[nodiscard]] Rejection timing(const Setpoint& setpoint, std::int64_t now_ns, const ProducerClock& clock) noexcept;
  [[nodiscard]] Rejection reach(const Setpoint& setpoint, const Command& command) noexcept;
  [[nodiscard]] Rejection refuse(Rejection reason, std::size_t joint, double value, double limit) noexcept;

  std::span<const JointSettings> joints_;
  std::int64_t max_age_ns_;
  std::int64_t max_lead_ns_;
  std::int64_t session_ = 0;
  std::int64_t last_sequence_ = -1;
  std::int64_t last_time_ns_ = 0;
  int conflicts_ = 0;
  std::array<Seen, kHistory> history_{};
  std::size_t next_ = 0;
  Detail detail_{};
};

}  // namespace glenoid::bridge
