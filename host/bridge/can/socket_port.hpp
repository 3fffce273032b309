#pragma once

// What all ports on sockets do alike: frames in batches out and in, and counters.

#include <cstddef>
#include <span>

#include "host/bridge/can/batch.hpp"
#include "host/bridge/can/port.hpp"

namespace glenoid::can {

/// A port that moves its frames through sockets. A kind of bus says how a frame looks on its wire and what failures mean.
class SocketPort : public Port {
 public:
  std::size_t send(std::span<const Frame> frames) noexcept final;
  std::size_t receive(std::span<Received> into) noexcept override;
  [[nodiscard]] Link link() const noexcept final { return link_; }
  [[nodiscard]] PortCounters counters() const noexcept final { return counters_; }

 protected:
  /// Makes `frame` number `k` of the next flush.
  /// @param k  0 .. SendBatch::kSlots - 1
  virtual void write(std::size_t k, const Frame& frame) noexcept = 0;
  /// Message `k` of the batch as a frame. False where it is none, or nobody wants it.
  virtual bool read(std::size_t k, Received& into) noexcept = 0;
  /// Hands frames 0 .. count - 1 to the kernel. How many it took; failures are noted.
  virtual std::size_t flush(std::size_t count) noexcept = 0;
  /// Of reception, an errno.
  virtual void note_failure(int error) noexcept = 0;

  ReceiveBatch incoming_;
  SendBatch outgoing_;
  PortCounters counters_;
  Link link_ = Link::Up;
};

}  // namespace glenoid::can
