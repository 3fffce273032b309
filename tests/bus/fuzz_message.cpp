// Bytes of the channels GLENOID_SETPOINT and GLENOID_COMMAND, and of what a publisher hears.

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "host/bridge/lcm/inbox.hpp"

namespace {

/// What is decoded is encoded to the same bytes.
template <class Message>
void check(const std::uint8_t* bytes, std::size_t size) {
  using namespace glenoid::lcm_port;
  Message message;
  if (decode(bytes, size, message) != Decoded::Ok) return;
  std::vector<std::uint8_t> again(size);
  const int length = static_cast<int>(size);
  if (message.encode(again.data(), 0, length) != length || std::memcmp(again.data(), bytes, size) != 0) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace glenoid;
  static lcm_port::Inbox inbox;
  std::array<bridge::Setpoint, lcm_port::Inbox::kNewest> setpoints;
  std::array<bridge::Command, 2> commands;
  const bool setpoint = inbox.hear_setpoint(bytes, size, 0) == lcm_port::Decoded::Ok;
  const bool command = inbox.hear_command(bytes, size) == lcm_port::Decoded::Ok;
  if (inbox.take_setpoints(setpoints) != (setpoint ? 1u : 0u)) std::abort();
  if (inbox.take_commands(commands) != (command ? 1u : 0u)) std::abort();
  if (inbox.take_undecodable() != (setpoint ? 0 : 1)) std::abort();
  check<status_v1_t>(bytes, size);
  check<feedback_v1_t>(bytes, size);
  check<event_v1_t>(bytes, size);
  return 0;
}
