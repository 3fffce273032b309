// What the Python tests drive: frames of the codec, and a bus as C++ sees it. One JSON object a line.
//
//   wires_probe golden SEED COUNT      process data of random values, encoded
//   wires_probe exchange URL SEED N    sends N random frames, then prints N frames of others

#include <poll.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <limits>
#include <random>
#include <string_view>

#include "host/bridge/can/open_port.hpp"
#include "host/bridge/core/codec.hpp"

namespace {

using namespace glenoid;
using Engine = std::mt19937_64;

void print(const can::Frame& frame) {
  std::printf("\"id\":%u,\"extended\":%s,\"remote\":%s,\"size\":%u,\"data\":\"", frame.id,
              frame.extended ? "true" : "false", frame.remote ? "true" : "false", unsigned{frame.size});
  for (std::size_t k = 0; !frame.remote && k < frame.size; ++k) std::printf("%02x", unsigned{frame.data[k]});
  std::printf("\"");
}

int golden(std::uint64_t seed, int count) {
  Engine engine(seed);
  for (int n = 0; n < count; ++n) {
    const auto node = static_cast<std::uint8_t>(1 + engine() % 6);
    // Every other value is an end of its range.
    const auto value = [&](auto example) {
      using Number = decltype(example);
      const std::uint64_t bits = engine();
      if (n % 4 == 1) return std::numeric_limits<Number>::max();
      if (n % 4 == 3) return std::numeric_limits<Number>::min();
      return static_cast<Number>(bits);
    };
    const bridge::Rpdo1 out = {value(std::uint16_t{}), value(std::int32_t{})};
    const bridge::Tpdo1 in = {value(std::uint16_t{}), value(std::int32_t{}), value(std::int16_t{})};
    std::printf("{\"node\":%u,\"values\":{\"controlword\":%u,\"target_position\":%d},", unsigned{node},
                unsigned{out.controlword}, out.target_position);
    print(bridge::encode(node, out));
    std::printf("}\n{\"node\":%u,\"values\":{\"statusword\":%u,\"position_actual\":%d,\"torque_actual\":%d},",
                unsigned{node}, unsigned{in.statusword}, in.position_actual, in.torque_actual);
    print(bridge::encode(node, in));
    std::printf("}\n");
  }
  return 0;
}

can::Frame random_frame(Engine& engine) {
  can::Frame frame;
  frame.extended = engine() % 2 == 0;
  frame.id = static_cast<std::uint32_t>(engine() % (frame.extended ? 0x20000000u : 0x800u));
  frame.size = static_cast<std::uint8_t>(engine() % 9);
  frame.remote = engine() % 8 == 0;
  for (std::size_t k = 0; !frame.remote && k < frame.size; ++k) frame.data[k] = static_cast<std::uint8_t>(engine());
  return frame;
}

int exchange(const char* url, std::uint64_t seed, std::size_t count) {
  const auto port = can::open_port(url, {.echo = false});
  std::puts("{\"ready\":true}");
  std::fflush(stdout);
  if (std::getchar() == EOF) return 1;  // the peer listens
  Engine engine(seed);
  for (std::size_t n = 0; n < count; ++n) {
    const can::Frame frame = random_frame(engine);
    if (port->send({&frame, 1}) != 1) return 1;
    std::printf("{");
    print(frame);
    std::printf("}\n");
  }
  std::fflush(stdout);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  for (std::size_t got = 0; got < count && std::chrono::steady_clock::now() < end;) {
    pollfd wait = {port->descriptor(), POLLIN, 0};
    ::poll(&wait, 1, 100);
    std::array<can::Received, 16> room;
    const std::size_t arrived = port->receive(room);
    for (std::size_t k = 0; k < arrived; ++k) {
      std::printf("{");
      print(room[k].frame);
      std::printf("}\n");
    }
    got += arrived;
  }
  return 0;
}

}  // namespace

int main(int count, char** arguments) try {
  const std::string_view what = count > 1 ? arguments[1] : "";
  if (what == "golden" && count == 4) return golden(std::strtoull(arguments[2], nullptr, 10), std::atoi(arguments[3]));
  if (what == "exchange" && count == 5) {
    return exchange(arguments[2], std::strtoull(arguments[3], nullptr, 10), std::strtoull(arguments[4], nullptr, 10));
  }
  return 2;
} catch (const std::exception& error) {
  std::fprintf(stderr, "wires_probe: %s\n", error.what());
  return 3;
}
