// glenoid-drives: simulated joint drives on a CAN bus, in real time.

#include <poll.h>
#include <sched.h>
#include <sys/mman.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <exception>
#include <fstream>
#include <iostream>
#include <stdexcept>

#include "host/bridge/can/open_port.hpp"
#include "host/drives/eds.hpp"
#include "host/drives/options.hpp"
#include "host/drives/report.hpp"
#include "host/load/load_file.hpp"

namespace glenoid::drives {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000;
constexpr std::int64_t kTick_ns = 500'000;  // between two looks at the timers when no frame comes
constexpr int kPriority = 70;               // below a bridge's 80: the master may be on the same machine

volatile std::sig_atomic_t g_stop = 0;  // set by a signal handler, which can reach nothing else

void on_signal(int) { g_stop = 1; }

std::int64_t monotonic_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kNsPerS + now.tv_nsec;
}

void become_realtime() {
  sched_param parameter{};
  parameter.sched_priority = kPriority;
  if (sched_setscheduler(0, SCHED_FIFO, &parameter) != 0 || mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    throw std::runtime_error(std::string("--realtime: ") + std::strerror(errno));
  }
}

std::vector<Drive> make_drives(const Options& options) {
  std::vector<Drive> drives;
  for (std::size_t k = 0; k < options.nodes.size(); ++k) {
    drives.emplace_back(options.profiles[k], Placement{options.nodes[k], options.start_rad[k], options.seed});
  }
  return drives;
}

/// Frames are answered when they come; timers are looked after in between.
void run(DriveGroup& group, const can::Port& port, double duration_s) {
  const std::int64_t begin_ns = monotonic_ns();
  const auto duration_ns = static_cast<std::int64_t>(duration_s * static_cast<double>(kNsPerS));
  pollfd wait{port.descriptor(), POLLIN, 0};
  const timespec tick{0, kTick_ns};
  while (g_stop == 0) {
    ppoll(&wait, wait.fd >= 0 ? 1 : 0, &tick, nullptr);
    const std::int64_t now_ns = monotonic_ns();
    group.step(now_ns);
    if (duration_ns > 0 && now_ns - begin_ns >= duration_ns) return;
  }
}

void write_text(const std::string& file, const std::string& text) {
  if (file.empty() || file == "-") {
    std::cout << text << std::flush;
    return;
  }
  std::ofstream stream(file);
  stream << text;
  if (!stream.flush()) throw std::runtime_error(file + ": cannot be written");
}

int main_of(int argc, char** argv) {
  Options options;
  if (const auto status = parse(argc, argv, options); status) return *status;
  if (!options.eds.empty()) {
    write_text(options.eds, electronic_data_sheet(options.profiles.front()));
    return 0;
  }
  std::unique_ptr<Load> load;
  if (!options.load.empty()) load = load::make_load(load::read_load_file(options.load), options.nodes);
  if (!options.report.empty() && options.report != "-") write_text(options.report, "");  // better now than at the end
  can::PortOptions port_options;
  port_options.echo = false;
  const auto port = can::open_port(options.bus, port_options);
  DriveGroup group(*port, make_drives(options), options.faults);
  if (load) group.carry(std::move(load));
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  if (options.realtime) become_realtime();
  std::cerr << "glenoid-drives: " << options.nodes.size() << " drives on " << options.bus << "; ready\n" << std::flush;
  run(group, *port, options.duration_s);
  std::vector<std::string> names;
  for (const Profile& profile : options.profiles) names.push_back(profile.name);
  write_text(options.report, json_report(group, names, options.bus));
  return 0;
}

}  // namespace
}  // namespace glenoid::drives

int main(int argc, char** argv) {
  try {
    return glenoid::drives::main_of(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "glenoid-drives: " << error.what() << "\n";
    return 2;
  }
}
