// What the kernel alone takes for the datagrams of a bridge with six drives over UDP multicast: nothing is packed, checked or
// decided here. One cycle: SYNC out, six answers in, six orders out; two sleeps. Prints one line per case.
//
// Usage: glenoid-bench-floor [CYCLES]

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <vector>

#include "host/bridge/can/batch.hpp"
#include "host/bridge/can/descriptor.hpp"
#include "host/bridge/loop/realtime.hpp"

namespace {

using glenoid::bridge::monotonic_ns;
using glenoid::bridge::sleep_until;
using glenoid::bridge::thread_cpu_ns;
using glenoid::can::Descriptor;

constexpr std::size_t kDrives = 6;
constexpr std::size_t kDatagram = 172;  // bytes of one frame in python-can's format
constexpr std::int64_t kPeriod_ns = 2'000'000;

/// A port of the group that hears everybody else, and a socket that sends to it.
struct Endpoint {
  explicit Endpoint(std::uint16_t port)
      : hears(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0)),
        says(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
    sockaddr_in group{};
    group.sin_family = AF_INET;
    group.sin_port = htons(port);
    ::inet_pton(AF_INET, "239.74.163.2", &group.sin_addr);
    const ip_mreq membership{group.sin_addr, {INADDR_ANY}};
    glenoid::can::set_option(hears.get(), SOL_SOCKET, SO_REUSEADDR, 1);
    glenoid::can::prepare_reception(hears.get(), 1 << 20);
    glenoid::can::set_option(says.get(), IPPROTO_IP, IP_MULTICAST_TTL, 0);
    if (::bind(hears.get(), reinterpret_cast<const sockaddr*>(&group), sizeof group) != 0 ||
        ::setsockopt(hears.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) != 0 ||
        ::connect(says.get(), reinterpret_cast<const sockaddr*>(&group), sizeof group) != 0)
      throw std::runtime_error("no multicast");
    sockaddr_in own{};
    socklen_t size = sizeof own;
    ::getsockname(says.get(), reinterpret_cast<sockaddr*>(&own), &size);
    glenoid::can::drop_from(hears.get(), ntohs(own.sin_port));
  }
  /// `count` equal datagrams by one call, cut by the kernel.
  void say(std::size_t count) {
    out.set(0, {bytes, count * kDatagram}, count > 1 ? std::uint16_t{kDatagram} : std::uint16_t{0});
    out.send(says.get(), 1);
  }
  int hear() { return in.receive(hears.get(), glenoid::can::ReceiveBatch::kSlots); }

  Descriptor hears, says;
  glenoid::can::ReceiveBatch in;
  glenoid::can::SendBatch out;
  char bytes[kDrives * kDatagram] = {};
};

void become_fifo(int priority) {
  const sched_param parameter{priority};
  if (priority > 0 && ::sched_setscheduler(0, SCHED_FIFO, &parameter) != 0) std::puts("SCHED_FIFO is not permitted");
}

/// A process that answers each SYNC with six datagrams, or only listens; until it is killed.
pid_t listener(std::uint16_t port, bool answers, int priority) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  become_fifo(priority);
  const auto endpoint = std::make_unique<Endpoint>(port);
  pollfd waiting{endpoint->hears.get(), POLLIN, 0};
  for (;;) {
    ::poll(&waiting, 1, -1);
    if (endpoint->hear() == 1 && answers) endpoint->say(kDrives);
  }
}

double median_us(std::vector<std::int64_t>& values_ns) {
  std::sort(values_ns.begin(), values_ns.end());
  return values_ns.empty() ? 0.0 : 1e-3 * static_cast<double>(values_ns[values_ns.size() / 2]);
}

void run(const char* name, int cycles, int listeners, bool sends, int priority) {
  const auto port = static_cast<std::uint16_t>(45000 + ::getpid() % 2000 + 2000 * listeners);
  std::vector<pid_t> children;
  for (int k = 0; k < listeners; ++k) children.push_back(listener(port, k == 0, priority > 0 ? priority - 10 : 0));
  const auto endpoint = std::make_unique<Endpoint>(port);
  sleep_until(monotonic_ns() + 300'000'000);
  become_fifo(priority);
  std::vector<std::int64_t> cycle, out, in;
  const std::int64_t start_ns = monotonic_ns() + kPeriod_ns;
  std::int64_t cpu_ns = thread_cpu_ns();
  for (int k = 0; k < cycles; ++k) {
    sleep_until(start_ns + k * kPeriod_ns);
    const std::int64_t sync_ns = monotonic_ns();
    if (sends) endpoint->say(1);
    const std::int64_t synced_ns = monotonic_ns();
    sleep_until(start_ns + k * kPeriod_ns + kPeriod_ns / 2);
    const std::int64_t heard_ns = monotonic_ns();
    endpoint->hear();
    const std::int64_t orders_ns = monotonic_ns();
    if (sends) endpoint->say(kDrives);
    out.push_back(synced_ns - sync_ns + monotonic_ns() - orders_ns);
    in.push_back(orders_ns - heard_ns);
    cycle.push_back(thread_cpu_ns() - cpu_ns);
    cpu_ns += cycle.back();
  }
  for (const pid_t child : children) ::kill(child, SIGKILL);
  for (const pid_t child : children) ::waitpid(child, nullptr, 0);
  become_fifo(0);
  std::printf("%-44s processor time of a cycle %6.1f us, of it sending %5.1f, receiving %5.1f\n", name,
              median_us(cycle), median_us(out), median_us(in));
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** values) {
  const int cycles = count > 1 ? std::atoi(values[1]) : 5000;
  if (cycles <= 0) {
    std::fprintf(stderr, "usage: glenoid-bench-floor [CYCLES]\n");
    return 2;
  }
  run("two sleeps, nothing sent", cycles, 0, false, 80);
  run("sent, heard by nobody else", cycles, 0, true, 80);
  run("sent to six drives in one process", cycles, 1, true, 80);
  run("the same, and an observer", cycles, 2, true, 80);
}
