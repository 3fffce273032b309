#include "bus/drives_bench.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace glenoid::test {
namespace {

constexpr std::int64_t kStep_ns = 500'000;
constexpr std::int64_t kPeriod_ns = 2 * kMs;

std::int64_t number(const can::Frame& frame, std::size_t from, std::size_t bytes) {
  std::int64_t value = 0;
  for (std::size_t k = 0; k < bytes; ++k) value |= std::int64_t{frame.data[from + k]} << (8 * k);
  const std::int64_t sign = std::int64_t{1} << (8 * bytes - 1);
  return (value ^ sign) - sign;
}

}  // namespace

DriveBench::DriveBench(const drives::Profile& profile, const drives::Placement& placement) : drive(profile, placement) {
  drive.advance(now_ns, out_);
  collect();
}

void DriveBench::collect() {
  for (const can::Frame& frame : out_.frames()) frames_.push_back(frame);
  out_.clear();
}

std::vector<can::Frame> DriveBench::take() { return std::exchange(frames_, {}); }

std::vector<can::Frame> DriveBench::take(std::uint32_t id) {
  std::vector<can::Frame> all = take();
  std::erase_if(all, [id](const can::Frame& frame) { return frame.id != id; });
  return all;
}

void DriveBench::give(std::uint32_t id, std::initializer_list<unsigned> bytes) {
  can::Frame frame;
  frame.id = id;
  frame.size = static_cast<std::uint8_t>(bytes.size());
  std::transform(bytes.begin(), bytes.end(), frame.data.begin(),
                 [](unsigned b) { return static_cast<std::uint8_t>(b); });
  drive.receive(frame, now_ns, out_);
  collect();
}

void DriveBench::wait(std::int64_t ns) {
  const std::int64_t end_ns = now_ns + ns;
  while (now_ns < end_ns) {
    now_ns = std::min(now_ns + kStep_ns, end_ns);
    drive.advance(now_ns, out_);
    collect();
  }
}

SdoAnswer DriveBench::upload(std::uint16_t index, std::uint8_t sub) {
  const std::vector<can::Frame> before = take();
  give(0x600U + drive.node(), {0x40, index & 0xFFU, unsigned{index} >> 8U, sub, 0, 0, 0, 0});
  const std::vector<can::Frame> answers = take(0x580U + drive.node());
  frames_ = before;
  if (answers.size() != 1) return {0xFFFFFFFF, 0};
  const can::Frame& answer = answers.front();
  const std::int64_t data = number(answer, 4, 4) & 0xFFFFFFFF;
  if (answer.data[0] == 0x80) return {static_cast<std::uint32_t>(data), 0};
  return {0, data};
}

std::uint32_t DriveBench::download(std::uint16_t index, std::uint8_t sub, std::int64_t value, int bytes) {
  const std::vector<can::Frame> before = take();
  const auto v = static_cast<std::uint64_t>(value);
  const auto byte = [v](unsigned k) { return static_cast<unsigned>(v >> (8U * k) & 0xFFU); };
  const auto unused = static_cast<unsigned>(4 - bytes);
  give(0x600U + drive.node(),
       {0x23U | unused << 2U, index & 0xFFU, unsigned{index} >> 8U, sub, byte(0), byte(1), byte(2), byte(3)});
  std::vector<can::Frame> after = take();
  frames_ = before;
  std::uint32_t abort = 0xFFFFFFFF;
  for (const can::Frame& frame : after) {
    if (frame.id != 0x580U + drive.node()) {
      frames_.push_back(frame);
    } else {
      abort = frame.data[0] == 0x60 ? 0 : static_cast<std::uint32_t>(number(frame, 4, 4));
    }
  }
  return abort;
}

bool DriveBench::map(std::uint16_t communication, std::int64_t cob_id, unsigned type,
                     std::initializer_list<std::uint32_t> objects) {
  const auto mapping = static_cast<std::uint16_t>(communication + 0x200);
  if (communication >= 0x1800) cob_id |= 0x40000000;  // the drive answers no remote frames
  bool good = download(communication, 1, cob_id | 0x80000000, 4) == 0 && download(mapping, 0, 0, 1) == 0;
  std::uint8_t sub = 0;
  for (const std::uint32_t object : objects) good = download(mapping, ++sub, object, 4) == 0 && good;
  good = download(mapping, 0, sub, 1) == 0 && good;
  good = download(communication, 2, type, 1) == 0 && good;
  return download(communication, 1, cob_id, 4) == 0 && good;
}

void DriveBench::prepare() {
  wait(25 * kMs);
  const std::int64_t node = drive.node();
  map(0x1400, 0x200 + node, 1, {0x60400010, 0x607A0020});
  map(0x1800, 0x180 + node, 1, {0x60410010, 0x60640020, 0x60770010});
  download(0x60C2, 1, 2, 1);
  download(0x6060, 0, 8, 1);
  give(0x000, {0x01, drive.node()});
}

void DriveBench::enable() {
  const std::int64_t here = counts(drive.view().position_rad);
  for (const unsigned word : {0x06U, 0x07U, 0x0FU}) cycle(word, here);
  for (int k = 0; k < 10; ++k) cycle(0x0F, here);
}

void DriveBench::sync() { give(0x080, {}); }

void DriveBench::setpoint(unsigned controlword, std::int64_t target) {
  const auto t = static_cast<std::uint64_t>(target);
  const auto byte = [t](unsigned k) { return static_cast<unsigned>(t >> (8U * k) & 0xFFU); };
  give(0x200U + drive.node(), {controlword & 0xFFU, controlword >> 8U, byte(0), byte(1), byte(2), byte(3)});
}

void DriveBench::cycle(unsigned controlword, std::int64_t target) {
  sync();
  setpoint(controlword, target);
  wait(kPeriod_ns);
}

std::optional<DriveBench::Feedback> DriveBench::feedback() {
  const std::vector<can::Frame> answers = take(0x180U + drive.node());
  if (answers.empty()) return std::nullopt;
  const can::Frame& last = answers.back();
  return Feedback{static_cast<unsigned>(number(last, 0, 2) & 0xFFFF), number(last, 2, 4),
                  static_cast<int>(number(last, 6, 2))};
}

std::int64_t DriveBench::counts(double rad) const { return std::llround(rad * drive.counts_per_rad()); }

unsigned DriveBench::state() const { return drive.view().statusword & 0x6FU; }

}  // namespace glenoid::test
