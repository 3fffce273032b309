#include "host/bridge/can/socket_port.hpp"

#include <algorithm>

namespace glenoid::can {
namespace {

constexpr int kMostRounds = 32;  // of one receive(): a flood of messages that are not for us must not hold it

}  // namespace

std::size_t SocketPort::send(std::span<const Frame> frames) noexcept {
  std::size_t taken = 0;
  while (taken < frames.size()) {
    const std::size_t count = std::min(frames.size() - taken, SendBatch::kSlots);
    for (std::size_t k = 0; k < count; ++k) write(k, frames[taken + k]);
    const std::size_t done = flush(count);
    taken += done;
    if (done < count) break;
  }
  counters_.sent += taken;
  counters_.refused += frames.size() - taken;
  return taken;
}

std::size_t SocketPort::receive(std::span<Received> into) noexcept {
  std::size_t count = 0;
  for (int round = 0; round < kMostRounds && count < into.size(); ++round) {
    const std::size_t most = std::min(into.size() - count, ReceiveBatch::kSlots);
    const int arrived = incoming_.receive(descriptor(), most);
    if (arrived < 0) note_failure(-arrived);
    for (int k = 0; k < arrived; ++k) count += read(static_cast<std::size_t>(k), into[count]) ? 1u : 0u;
    if (arrived < static_cast<int>(most)) break;
  }
  counters_.overruns = incoming_.dropped();
  return count;
}

}  // namespace glenoid::can
