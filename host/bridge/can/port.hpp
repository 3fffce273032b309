#pragma once

// One CAN bus as the bridge and the drives see it: non-blocking, no retries, latest wins.

#include <cstddef>
#include <cstdint>
#include <span>

#include "host/bridge/can/frame.hpp"

namespace glenoid::can {

enum class Link : std::uint8_t { Up, Down, Gone };

/// What a port counts since it was opened.
struct PortCounters {
  std::uint64_t sent = 0;      ///< frames the transport took
  std::uint64_t refused = 0;   ///< frames it did not take (queue full, link down): dropped, never sent later
  std::uint64_t echoed = 0;    ///< own frames seen again: they reached the bus
  std::uint64_t received = 0;  ///< frames of others
  std::uint64_t overruns = 0;  ///< received frames the kernel dropped because nobody read them
};

/// A bus. Implementations never block, throw or allocate after construction. Not thread-safe: one thread owns a port.
class Port {
 public:
  virtual ~Port() = default;
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;

  /// Hands all frames to the transport in order, in one call. Returns how many it took; the rest is dropped and counted.
  virtual std::size_t send(std::span<const Frame> frames) noexcept = 0;

  /// Moves what has arrived, oldest first, into `into`. Returns how many; fewer than the space means: nothing left.
  virtual std::size_t receive(std::span<Received> into) noexcept = 0;

  /// Frames sent whose echo is still missing; 0 for transports that deliver at once.
  [[nodiscard]] virtual std::size_t outstanding() const noexcept = 0;

  /// Drops everything queued and not yet on the bus. False: this transport cannot (or may not), and says so.
  virtual bool purge() noexcept = 0;

  [[nodiscard]] virtual Link link() const noexcept = 0;
  [[nodiscard]] virtual PortCounters counters() const noexcept = 0;
  /// File descriptor that turns readable when frames wait, or -1.
  [[nodiscard]] virtual int descriptor() const noexcept = 0;

 protected:
  Port() = default;
};

}  // namespace glenoid::can
