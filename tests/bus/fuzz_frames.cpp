// Frames that anybody sent, into a bridge of six drives: twelve bytes make a frame, four of them when it comes.

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "bridge_rig.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace glenoid::bridge;
  test::Rig rig(test::six_drives(2));
  for (std::size_t at = 0; at + 12 <= size; at += 12) {
    glenoid::can::Frame frame;
    frame.id = (bytes[at] | static_cast<std::uint32_t>(bytes[at + 1]) << 8) & 0x7FFU;
    frame.size = static_cast<std::uint8_t>(std::min(8, bytes[at + 2] & 0x0F));
    frame.extended = (bytes[at + 2] & 0x80) != 0;
    frame.remote = (bytes[at + 2] & 0x40) != 0;
    frame.error = (bytes[at + 2] & 0x20) != 0;
    std::copy_n(bytes + at + 4, frame.size, frame.data.begin());
    rig.error_frame(0, frame);
    rig.cycles(1 + bytes[at + 3] % 64);
    if (bytes[at + 3] > 250) rig.command(static_cast<Request>(bytes[at + 3] - 250));
  }
  return 0;
}
