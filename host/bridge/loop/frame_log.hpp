#pragma once

// Everything on the buses in candump's log format, written by a thread of its own.

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "host/bridge/can/frame.hpp"
#include "host/bridge/lcm/ring.hpp"

namespace glenoid::bridge {

/// `add` is for the loop: it takes no lock, allocates nothing, and drops and counts what the writer cannot keep up with.
/// Stamps are CLOCK_REALTIME, from CLOCK_MONOTONIC with the offset of the moment of construction: one clock for all buses.
class FrameLog {
 public:
  /// @param names  of the buses, as they stand in the log
  /// @throws std::runtime_error  the file cannot be written
  FrameLog(const std::string& file, std::vector<std::string> names);
  ~FrameLog();
  FrameLog(const FrameLog&) = delete;
  FrameLog& operator=(const FrameLog&) = delete;

  void add(std::int64_t monotonic_ns, std::size_t bus, const can::Frame& frame) noexcept;
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

 private:
  struct Entry {
    std::int64_t time_ns = 0;
    std::uint32_t bus = 0;
    can::Frame frame;
  };
  void drain(bool all);
  void write(const Entry& entry);

  struct Close {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
  std::vector<std::string> names_;
  std::int64_t offset_ns_;
  lcm_port::Ring<Entry, 16384> ring_;
  std::uint64_t lost_ = 0;
  std::vector<Entry> waiting_;  // received frames come a cycle after those sent meanwhile: sorted before writing
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

/// "(1700000000.123456) can0 201#0F0010270000": what candump -L prints.
[[nodiscard]] std::string candump_line(std::int64_t realtime_ns, const std::string& bus, const can::Frame& frame);

}  // namespace glenoid::bridge
