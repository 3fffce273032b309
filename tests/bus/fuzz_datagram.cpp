// Bytes of a UDP bus: a frame that can be, or nothing.

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "host/bridge/can/error_frame.hpp"
#include "host/bridge/can/udp_datagram.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace glenoid::can;
  static DatagramDecoder decoder;
  static DatagramEncoder encoder;
  const auto frame = decoder.decode({reinterpret_cast<const char*>(bytes), size});
  if (!frame) return 0;
  const bool possible = frame->size <= 8 && frame->id <= (frame->extended || frame->error ? 0x1FFFFFFFu : 0x7FFu) &&
                        std::all_of(frame->data.begin() + frame->size, frame->data.end(), [](auto b) { return b == 0; });
  if (!possible || decoder.decode(encoder.encode(*frame, 0.0)) != frame) std::abort();
  if (frame->error && describe_error(*frame).empty()) std::abort();
  return 0;
}
