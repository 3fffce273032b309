#pragma once

// A bus inside one thread, for tests and virtual time.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "host/bridge/can/open_port.hpp"
#include "host/bridge/can/port.hpp"

namespace glenoid::can {

/// Any number of ports that hear each other. What a port sends is with all others before `send` returns, stamped with the
/// time of `set_time`, unless the bus is stalled: then it waits in the port's bounded queue, as on a real bus that nobody
/// acknowledges, and comes out when the stall ends or is dropped by `purge`. Not thread-safe.
class MemoryBus {
 public:
  struct Settings {
    std::size_t transmit_queue = 32;   ///< frames per port that a stalled bus holds; more are refused
    std::size_t receive_queue = 1024;  ///< frames per port that wait to be read; more are lost and counted
    bool can_purge = true;             ///< false: `purge` fails, as without the right to switch the interface off
  };

  MemoryBus() : MemoryBus(Settings{}) {}
  explicit MemoryBus(const Settings& settings);
  ~MemoryBus();
  MemoryBus(const MemoryBus&) = delete;
  MemoryBus& operator=(const MemoryBus&) = delete;

  /// A new port. It must not outlive the bus.
  std::unique_ptr<Port> connect(const PortOptions& options = {});

  /// Stamp of what is delivered from now on, ns.
  void set_time(std::int64_t time_ns) noexcept { time_ns_ = time_ns; }
  /// Nothing leaves the transmit queues while true; false lets out what waits, oldest port first.
  void stall(bool on) noexcept;
  /// Down or Gone: sent frames are refused and waiting ones dropped.
  void set_link(Link link) noexcept;

 private:
  class Endpoint;
  void deliver(const Frame& frame, const Endpoint& from) noexcept;

  Settings settings_;
  std::vector<Endpoint*> endpoints_;
  std::int64_t time_ns_ = 0;
  bool stalled_ = false;
  Link link_ = Link::Up;
};

}  // namespace glenoid::can
