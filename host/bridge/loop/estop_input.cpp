#include "host/bridge/loop/estop_input.hpp"

#include <poll.h>
#include <unistd.h>

#include <cerrno>

namespace glenoid::bridge {

bool EStopInput::poll() noexcept {
  if (descriptor_ < 0) return pressed_;
  pollfd waiting{descriptor_, POLLIN, 0};
  if (::poll(&waiting, 1, 0) <= 0) return pressed_;
  char bytes[4096];
  const ssize_t count = ::read(descriptor_, bytes, sizeof bytes);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return pressed_;
  if (count <= 0) {
    descriptor_ = -1;
    pressed_ = true;
    return pressed_;
  }
  bool was_pressed = false;
  for (ssize_t k = 0; k < count; ++k) {
    if (!(behind_release_ && bytes[k] == '\n')) pressed_ = bytes[k] != '1';
    behind_release_ = bytes[k] == '1';
    was_pressed = was_pressed || pressed_;
  }
  return was_pressed;
}

}  // namespace glenoid::bridge
