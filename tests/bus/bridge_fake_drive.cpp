#include "bridge_rig.hpp"
#include "host/bridge/core/bytes.hpp"
#include "host/bridge/core/codec.hpp"

namespace glenoid::bridge::test {
namespace {

can::Frame frame_of(std::uint32_t id, std::initializer_list<std::uint8_t> bytes) {
  can::Frame frame;
  frame.id = id;
  frame.size = static_cast<std::uint8_t>(bytes.size());
  std::size_t k = 0;
  for (const std::uint8_t byte : bytes) frame.data[k++] = byte;
  return frame;
}

std::map<std::uint32_t, std::uint32_t> defaults() {
  std::map<std::uint32_t, std::uint32_t> objects;
  const auto set = [&](std::uint32_t index, std::uint32_t sub, std::uint32_t value) {
    objects[FakeDrive::key(index, sub)] = value;
  };
  set(0x1000, 0, 0x00020192);
  set(0x1017, 0, 0);
  for (std::uint32_t sub = 1; sub <= 4; ++sub) set(0x1018, sub, sub);
  set(0x1016, 1, 0);
  set(0x1029, 1, 0);
  for (const std::uint32_t index : {0x6007U, 0x605AU, 0x605EU, 0x6065U, 0x6066U, 0x6060U, 0x6061U}) set(index, 0, 0);
  for (const std::uint32_t sub : {1U, 2U}) {
    set(0x607D, sub, 0);
    set(0x60C2, sub, 0);
  }
  set(0x6502, 0, 0x3A5);
  for (const std::uint32_t base : {0x1400U, 0x1800U}) {
    for (std::uint32_t k = 0; k < 2; ++k) {
      for (const std::uint32_t sub : {1U, 2U, 3U, 5U}) set(base + k, sub, 0);
      for (std::uint32_t sub = 0; sub <= 8; ++sub) set(base + 0x200 + k, sub, 0);
    }
  }
  return objects;
}

}  // namespace

FakeDrive::FakeDrive(std::uint8_t id, std::int32_t at) : node(id), position(at), objects(defaults()) {}

void FakeDrive::reboot(std::vector<can::Frame>& out) {
  objects = defaults();
  nmt = 0x7F;
  statusword = 0x0240;
  controlword = 0;
  pending_ = false;
  out.push_back(frame_of(0x700U + node, {0x00}));
}

void FakeDrive::sdo(const can::Frame& frame, std::vector<can::Frame>& out) {
  const std::uint16_t index = get_u16(frame, 1);
  const std::uint8_t sub = frame.data[3];
  const std::uint32_t at = key(index, sub);
  can::Frame answer = frame;
  answer.id = 0x580U + node;
  const auto abort = aborts.find(at);
  if (frame.data[0] == 0x80) return;
  if (abort != aborts.end() || !objects.contains(at)) {
    answer.data[0] = 0x80;
    put_u32(answer, 4, abort != aborts.end() ? abort->second : 0x06020000U);
  } else if (frame.data[0] == 0x40) {
    answer.data[0] = 0x43;
    put_u32(answer, 4, read_back.contains(at) ? read_back[at] : objects[at]);
  } else {
    objects[at] = get_u32(frame, 4);
    if (index == 0x6060) objects[key(0x6061, 0)] = objects[at];
    writes.push_back(at);
    answer.data[0] = 0x60;
    put_u32(answer, 4, 0);
  }
  out.push_back(answer);
}

void FakeDrive::control(std::uint16_t word) {
  const bool edge = (word & 0x80) != 0 && (controlword & 0x80) == 0;
  controlword = word;
  const std::uint16_t state = statusword & 0x6F;
  std::uint16_t next = state;
  if (keeps_power && state == 0x27) return;
  if ((statusword & 0x4F) == 0x08) {
    next = edge ? 0x40 : 0x08;
  } else if ((word & 0x02) == 0) {
    next = 0x40;  // disable voltage
  } else if ((word & 0x06) == 0x02) {
    next = state == 0x27 || state == 0x07 ? 0x07 : 0x40;  // quick stop
  } else if ((statusword & 0x4F) == 0x40) {
    next = (word & 0x8F) == 0x06 ? 0x21 : 0x40;
  } else if ((word & 0x8F) == 0x06) {
    next = 0x21;
  } else if ((word & 0x8F) == 0x07) {
    next = 0x23;
  } else if ((word & 0x8F) == 0x0F && (state == 0x23 || state == 0x27)) {
    next = refuses_enable ? 0x23 : 0x27;
  }
  statusword = static_cast<std::uint16_t>(0x0200 | next | (next == 0x27 && follows ? 0x1000 : 0));
}

void FakeDrive::answer_sync(std::vector<can::Frame>& out) {
  // Sampled first, then the pending command becomes active: the answer shows the effect of the one before.
  if (!mute_pdo) out.push_back(encode(node, Tpdo1{statusword, position, 0}));
  if (!pending_) return;
  control(pending_control_);
  target = pending_target_;
  if ((statusword & 0x6F) == 0x27 && !stuck) position = target;
}

void FakeDrive::receive(const can::Frame& frame, std::int64_t, std::vector<can::Frame>& out) {
  if (dead || frame.error) return;
  if (frame.id == 0x000 && (frame.data[1] == 0 || frame.data[1] == node)) {
    if (frame.data[0] == 0x01) nmt = 0x05;
    if (frame.data[0] == 0x80) nmt = 0x7F;
  } else if (frame.id == 0x080 && nmt == 0x05) {
    answer_sync(out);
  } else if (frame.id == 0x600U + node && !mute_sdo) {
    sdo(frame, out);
  } else if (frame.id == 0x200U + node && nmt == 0x05) {
    if (const auto value = decode_rpdo1(frame)) {
      pending_control_ = value->controlword;
      pending_target_ = value->target_position;
      pending_ = true;
    }
  }
}

void FakeDrive::advance(std::int64_t now_ns, std::vector<can::Frame>& out) {
  const std::int64_t period_ns = kMs * objects[key(0x1017, 0)];
  if (dead || mute_heartbeat || period_ns == 0 || now_ns - heartbeat_ns_ < period_ns) return;
  heartbeat_ns_ = now_ns;
  out.push_back(frame_of(0x700U + node, {nmt}));
}

}  // namespace glenoid::bridge::test
