#include "host/bridge/monitor.hpp"

#include <array>
#include <cstdio>
#include <map>
#include <string>
#include <utility>

#include "host/bridge/can/error_frame.hpp"
#include "host/bridge/core/bytes.hpp"
#include "host/bridge/core/canopen.hpp"
#include "host/bridge/core/cia402.hpp"
#include "host/bridge/core/codec.hpp"
#include "host/bridge/core/pdo_table.hpp"
#include "host/bridge/loop/realtime.hpp"

namespace glenoid::bridge {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

std::string hex(std::uint32_t value, int digits) {
  char text[16];
  std::snprintf(text, sizeof text, "%0*Xh", digits, value);
  return text;
}

std::string sdo_words(const can::Frame& frame) {
  const std::string object = hex(get_u16(frame, 1), 4) + ":" + hex(frame.data[3], 2);
  const auto answer = canopen::sdo_answer(frame);
  if (!answer) return "SDO of another length";
  switch (answer->kind) {
    case canopen::SdoAnswer::Kind::Aborted:
      return "SDO " + object + " aborted: " + std::string(canopen::abort_words(answer->value));
    case canopen::SdoAnswer::Kind::Uploaded:
      return "SDO " + object + " reads " + std::to_string(answer->value);
    case canopen::SdoAnswer::Kind::Downloaded:
      return "SDO " + object + " written";
    case canopen::SdoAnswer::Kind::Other:
      break;
  }
  return "SDO " + object;
}

/// Words for what is not process data; empty for process data and SYNC.
std::string words_of(const can::Frame& frame) {
  if (frame.error) return can::describe_error(frame);
  if (frame.extended) return "29-bit frame " + hex(frame.id, 8);
  const std::uint32_t function = frame.id & 0x780U;
  const std::uint32_t node = frame.id & 0x7FU;
  const std::string who = "node " + std::to_string(node) + ": ";
  if (frame.id == canopen::kNmtId && frame.size == 2)
    return "NMT command " + hex(frame.data[0], 2) + " to " + std::to_string(frame.data[1]);
  if (function == canopen::kEmergencyId && node != 0 && frame.size == 8)
    return who + "EMCY " + hex(get_u16(frame, 0), 4) + " " + std::string(canopen::emergency_words(get_u16(frame, 0)));
  if (function == canopen::kSdoResponseId) return who + sdo_words(frame);
  return {};
}

struct Seen {
  std::map<std::uint32_t, std::uint64_t> counts;  // by identifier
  std::map<std::uint32_t, std::uint8_t> nmt;
  std::map<std::uint32_t, Tpdo1> feedback;
};

void take(const Config& config, std::size_t bus, const can::Received& received, Seen& seen) {
  const can::Frame& frame = received.frame;
  const double at_s = 1e-9 * static_cast<double>(received.time_ns);
  if (const std::string text = words_of(frame); !text.empty())
    std::printf("%12.3f s  %s  %s\n", at_s, config.buses[bus].name.c_str(), text.c_str());
  if (frame.error || frame.extended) return;
  ++seen.counts[frame.id];
  const std::uint32_t node = frame.id & 0x7FU;
  if ((frame.id & 0x780U) == canopen::kHeartbeatId && frame.size == 1 && seen.nmt[node] != frame.data[0]) {
    seen.nmt[node] = frame.data[0];
    std::printf("%12.3f s  %s  node %u: %s\n", at_s, config.buses[bus].name.c_str(), node,
                canopen::words(static_cast<Nmt>(frame.data[0])).data());
  }
  if ((frame.id & 0x780U) == kTpdo1.cob_id)
    if (const auto value = decode_tpdo1(frame)) seen.feedback[node] = *value;
}

void print_second(const Config& config, std::size_t bus, Seen& seen) {
  std::printf("  %s: SYNC %llu/s", config.buses[bus].name.c_str(),
              static_cast<unsigned long long>(seen.counts[canopen::kSyncId]));
  for (const JointSettings& joint : config.settings.joints) {
    if (joint.bus != bus || !seen.feedback.contains(joint.node)) continue;
    const Tpdo1& value = seen.feedback[joint.node];
    std::printf("  [%u] %s %.4f rad", unsigned{joint.node}, cia402::words(cia402::decode(value.statusword)).data(),
                Scale(joint).position_rad(value.position_actual));
  }
  std::printf("\n");
  seen.counts.clear();
}

}  // namespace

int monitor(const Config& config, std::vector<std::unique_ptr<can::Port>> ports, double duration_s) {
  std::vector<Seen> seen(ports.size());
  std::array<can::Received, 256> received{};
  const std::int64_t begin_ns = monotonic_ns();
  std::int64_t second_ns = begin_ns + kSecond;
  for (std::int64_t now_ns = begin_ns;
       duration_s <= 0.0 || 1e-9 * static_cast<double>(now_ns - begin_ns) < duration_s;) {
    sleep_until(now_ns + 5'000'000);
    now_ns = monotonic_ns();
    for (std::size_t b = 0; b < ports.size(); ++b) {
      const std::size_t count = ports[b]->receive(received);
      for (std::size_t k = 0; k < count; ++k) take(config, b, received[k], seen[b]);
    }
    if (now_ns < second_ns) continue;
    second_ns += kSecond;
    for (std::size_t b = 0; b < ports.size(); ++b) print_second(config, b, seen[b]);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace glenoid::bridge
