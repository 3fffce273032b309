#include "host/bridge/loop/frame_log.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "host/bridge/loop/realtime.hpp"

namespace glenoid::bridge {
namespace {

constexpr std::int64_t kSettleNs = 50'000'000;  // what was received is here by then

}  // namespace

std::string candump_line(std::int64_t realtime, const std::string& bus, const can::Frame& frame) {
  char text[120];
  int length = std::snprintf(text, sizeof text, "(%lld.%06lld) %s ", static_cast<long long>(realtime / 1'000'000'000),
                             static_cast<long long>(realtime / 1000 % 1'000'000), bus.substr(0, 40).c_str());
  const auto left = [&] { return sizeof text - static_cast<std::size_t>(length); };
  const std::uint32_t id = frame.id | (frame.error ? 0x2000'0000U : 0U);  // CAN_ERR_FLAG
  length += std::snprintf(text + length, left(), frame.extended || frame.error ? "%08X#" : "%03X#", id);
  if (frame.remote) length += std::snprintf(text + length, left(), "R");
  for (std::size_t k = 0; k < frame.size && !frame.remote; ++k)
    length += std::snprintf(text + length, left(), "%02X", static_cast<unsigned>(frame.data[k]));
  return std::string(text, static_cast<std::size_t>(length));
}

FrameLog::FrameLog(const std::string& file, std::vector<std::string> names)
    : file_(std::fopen(file.c_str(), "w")), names_(std::move(names)), offset_ns_(realtime_ns() - monotonic_ns()) {
  if (!file_) throw std::runtime_error(file + ": cannot be written");
  thread_ = std::thread([this] {
    while (!stop_.load(std::memory_order_acquire)) {
      drain(false);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    drain(true);
  });
}

FrameLog::~FrameLog() {
  stop_.store(true, std::memory_order_release);
  thread_.join();
}

void FrameLog::add(std::int64_t monotonic, std::size_t bus, const can::Frame& frame) noexcept {
  if (!ring_.push({monotonic, static_cast<std::uint32_t>(bus), frame})) ++lost_;
}

void FrameLog::drain(bool all) {
  Entry entry;
  while (ring_.pop(entry)) waiting_.push_back(entry);
  std::stable_sort(waiting_.begin(), waiting_.end(),
                   [](const Entry& a, const Entry& b) { return a.time_ns < b.time_ns; });
  const std::int64_t until_ns = all || waiting_.empty() ? INT64_MAX : waiting_.back().time_ns - kSettleNs;
  const auto ripe = std::find_if(waiting_.begin(), waiting_.end(), [&](const Entry& e) { return e.time_ns > until_ns; });
  std::for_each(waiting_.begin(), ripe, [this](const Entry& e) { write(e); });
  waiting_.erase(waiting_.begin(), ripe);
  std::fflush(file_.get());
}

void FrameLog::write(const Entry& entry) {
  std::fputs((candump_line(entry.time_ns + offset_ns_, names_[entry.bus], entry.frame) + "\n").c_str(), file_.get());
}

}  // namespace glenoid::bridge
