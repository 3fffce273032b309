#include "host/bridge/loop/realtime.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace glenoid::bridge {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::size_t kStackBytes = 256 * 1024;

std::int64_t now_of(clockid_t clock) noexcept {
  timespec time{};
  clock_gettime(clock, &time);
  return time.tv_sec * kSecond + time.tv_nsec;
}

/// Touches the pages that the loop's stack will use, so that none of them faults later.
[[gnu::noinline]] void touch_stack() noexcept {
  unsigned char pages[kStackBytes];
  volatile unsigned char* const touched = pages;
  for (std::size_t at = 0; at < kStackBytes; at += 4096) touched[at] = 1;
}

}  // namespace

std::int64_t monotonic_ns() noexcept { return now_of(CLOCK_MONOTONIC); }
std::int64_t realtime_ns() noexcept { return now_of(CLOCK_REALTIME); }
std::int64_t thread_cpu_ns() noexcept { return now_of(CLOCK_THREAD_CPUTIME_ID); }

void sleep_until(std::int64_t time_ns) noexcept {
  const timespec until{time_ns / kSecond, time_ns % kSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

std::int64_t wait_until(std::int64_t time_ns, std::int64_t awake_ns) noexcept {
  sleep_until(time_ns - awake_ns);
  const std::int64_t begin_ns = monotonic_ns();
  std::int64_t now_ns = begin_ns;
  while (awake_ns > 0 && now_ns < time_ns) now_ns = monotonic_ns();
  return now_ns - begin_ns;
}

IdleLatency::IdleLatency(bool wanted) noexcept {
  if (!wanted) return;
  constexpr std::int32_t kMost_us = 0;
  can::Descriptor file(::open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC));
  if (file.valid() && ::write(file.get(), &kMost_us, sizeof kMost_us) == sizeof kMost_us) file_ = std::move(file);
}

std::vector<std::string> become_realtime(int priority) {
  std::vector<std::string> refused;
  if (priority > 0) {
    const sched_param parameter{priority};
    if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter); error != 0)
      refused.push_back("SCHED_FIFO " + std::to_string(priority) + " is not permitted (" + std::strerror(error) +
                        "): SYNC will jitter under load; raise the limit rtprio");
  } else {
    refused.push_back("ordinary scheduling was asked for: SYNC will jitter under load");
  }
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0)
    refused.push_back(std::string("memory cannot be locked (") + std::strerror(errno) + "); raise the limit memlock");
  touch_stack();
  return refused;
}

}  // namespace glenoid::bridge
