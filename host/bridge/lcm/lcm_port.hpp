#pragma once

// The bridge's end of LCM: one thread hears, one tells, and the real-time loop waits for neither.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "host/bridge/core/messages.hpp"
#include "host/bridge/lcm/convert.hpp"
#include "host/bridge/lcm/inbox.hpp"

namespace glenoid::lcm_port {

inline constexpr std::string_view kDefaultUrl = "udpm://239.255.76.67:7667?ttl=0";
inline constexpr const char* kSetpointChannel = "GLENOID_SETPOINT";
inline constexpr const char* kFeedbackChannel = "GLENOID_FEEDBACK";
inline constexpr const char* kStatusChannel = "GLENOID_STATUS";
inline constexpr const char* kEventChannel = "GLENOID_EVENT";
inline constexpr const char* kFiguresChannel = "GLENOID_FIGURES";
inline constexpr const char* kDeviceChannel = "GLENOID_DEVICE";
inline constexpr const char* kCommandChannel = "GLENOID_COMMAND";

/// The URL with its time to live written out.
/// @throws std::invalid_argument  a transport other than udpm:// or memq://, or a time to live other than 0, and the network
///                                is not allowed.
[[nodiscard]] std::string checked_url(std::string_view url, bool allow_network);

/// Why messages with time to live 0 may still leave this machine, or empty: the multicast route does not go to the loopback
/// interface.
[[nodiscard]] std::string route_warning(std::string_view url);

struct LcmOptions {
  std::string url{kDefaultUrl};
  bool allow_network = false;
  int hearing_priority = 0;  ///< SCHED_FIFO of the hearing thread, 0: as the constructing thread; ignored where not permitted
  Device device;
};

/// What could not be handed over.
struct LcmCounters {
  std::uint64_t feedback_dropped = 0;
  std::uint64_t status_dropped = 0;
  std::uint64_t events_dropped = 0;
  std::uint64_t publish_failed = 0;
};

/// Channels GLENOID_*. All functions but the constructor, the destructor and `tell(Figures)` are for one thread, the loop: they take no lock,
/// allocate nothing and do not throw.
class LcmPort {
 public:
  /// Starts two threads.
  /// @throws std::invalid_argument as checked_url; std::runtime_error LCM cannot be opened, the text says why.
  explicit LcmPort(const LcmOptions& options);
  ~LcmPort();
  LcmPort(const LcmPort&) = delete;
  LcmPort& operator=(const LcmPort&) = delete;

  /// See Inbox.
  std::size_t take_setpoints(std::span<bridge::Setpoint, Inbox::kNewest> into) noexcept;
  std::size_t take_commands(std::span<bridge::Command> into) noexcept;
  std::int64_t take_undecodable() noexcept;

  /// Queue a message for the telling thread; false and counted where it cannot keep up.
  bool tell(const bridge::Feedback& feedback, bridge::State state) noexcept;
  bool tell(const bridge::Status& status) noexcept;
  bool tell(const bridge::Event& event) noexcept;
  /// Wakes the telling thread if something was queued: once per cycle, after its messages.
  void flush() noexcept;

  /// For one thread other than the loop. Wakes the telling thread by itself.
  void tell(const bridge::Figures& figures) noexcept;

  [[nodiscard]] LcmCounters counters() const noexcept;
  [[nodiscard]] const Inbox& inbox() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace glenoid::lcm_port
