// glenoid-bridge: setpoints on LCM to CiA 402 drives on CAN. This file only wires.

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <memory>
#include <thread>

#include "host/bridge/can/open_port.hpp"
#include "host/bridge/config/config.hpp"
#include "host/bridge/loop/loop.hpp"
#include "host/bridge/loop/realtime.hpp"
#include "host/bridge/monitor.hpp"
#include "host/bridge/report.hpp"

namespace {

namespace can = glenoid::can;
namespace bridge = glenoid::bridge;
namespace lcm_port = glenoid::lcm_port;

struct Arguments {
  std::string config, exoskeleton, log, stats, rehearsal;
  std::string lcm_url{lcm_port::kDefaultUrl};
  bool check = false, dry_run = false, monitor = false, allow_network = false, allow_unrehearsed = false;
  bool deadman = false, no_lcm = false, quiet = false, estop_stdin = false;
  double duration_s = 0.0, awake_us = 50.0;
  int priority = 80, estop_fd = -1;
};

void define(CLI::App& app, Arguments& a) {
  app.add_option("config", a.config, "YAML file with the exoskeleton")->required()->check(CLI::ExistingFile);
  app.add_option("--exoskeleton", a.exoskeleton, "which one of the file");
  app.add_flag("--check-config", a.check, "check the file, print it and its hash, and end");
  app.add_flag("--dry-run", a.dry_run, "run, but send nothing to a bus");
  app.add_flag("--monitor", a.monitor, "listen only: print what happens on the buses");
  app.add_option("--log", a.log, "write all frames to this file, as candump -L does");
  app.add_option("--stats", a.stats, "write the figures to this JSON file, again every second");
  app.add_option("--duration", a.duration_s, "end after so many seconds")->check(CLI::PositiveNumber);
  app.add_option("--lcm-url", a.lcm_url, "LCM provider");
  app.add_flag("--no-lcm", a.no_lcm, "no messages at all");
  app.add_flag("--allow-network", a.allow_network, "let LCM messages leave this machine (ttl above 0)");
  app.add_option("--rehearsal", a.rehearsal, "folder of a passed rehearsal of this configuration");
  app.add_flag("--allow-unrehearsed", a.allow_unrehearsed, "arm on a real bus without one");
  app.add_flag("--selftest-deadman", a.deadman, "fall silent on purpose; every drive must report 8130h");
  app.add_option("--priority", a.priority, "SCHED_FIFO priority, 0: ordinary scheduling")->check(CLI::Range(0, 99));
  app.add_option("--awake-us", a.awake_us, "not slept before each SYNC (50); 0 with --priority 0")
      ->check(CLI::Range(0.0, 200.0));
  app.add_option("--estop-fd", a.estop_fd, "descriptor: '1' releases, all else and its end press");
  app.add_flag("--estop-stdin", a.estop_stdin, "the Enter key is an emergency stop");
  app.add_flag("--quiet", a.quiet, "print warnings and errors only");
}

std::atomic<bridge::Loop*> running{nullptr};

void on_signal(int signal) {
  bridge::Loop* const loop = running.load();
  if (loop == nullptr) std::_Exit(128 + signal);
  if (signal == SIGUSR1)
    loop->request_estop();
  else
    loop->request_stop();
}

void catch_signals() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1}) sigaction(signal, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

std::vector<std::unique_ptr<can::Port>> open_ports(const bridge::Config& config, bool everything) {
  std::vector<std::unique_ptr<can::Port>> ports;
  for (std::size_t b = 0; b < config.buses.size(); ++b) {
    std::vector<std::uint8_t> nodes;
    for (const bridge::JointSettings& joint : config.settings.joints)
      if (joint.bus == b) nodes.push_back(joint.node);
    can::PortOptions options;
    if (!everything) options.filters = can::master_filters(nodes, config.settings.master_id);
    ports.push_back(can::open_port(config.buses[b].url, options));
  }
  return ports;
}

bool all_virtual(const bridge::Config& config) {
  return std::all_of(config.buses.begin(), config.buses.end(),
                     [](const bridge::BusConfig& bus) { return can::is_virtual(bus.url); });
}

std::string arming_obstacle(const Arguments& a, const bridge::Config& config) {
  if (all_virtual(config) || a.dry_run) return {};
  const std::string why = bridge::rehearsal_obstacle(a.rehearsal, bridge::config_hash(config));
  if (why.empty()) return {};
  std::fprintf(stderr, "glenoid-bridge: %s%s\n", why.c_str(),
               a.allow_unrehearsed ? "; going on because of --allow-unrehearsed" : "");
  return a.allow_unrehearsed ? std::string{} : why;
}

std::unique_ptr<lcm_port::LcmPort> open_lcm(const Arguments& a, const bridge::Config& config) {
  if (a.no_lcm) return nullptr;
  lcm_port::LcmOptions options;
  options.url = a.lcm_url;
  options.allow_network = a.allow_network;
  options.hearing_priority = a.priority > 1 ? a.priority - 10 > 0 ? a.priority - 10 : 1 : 0;
  options.device.exoskeleton = config.settings.name;
  options.device.config_sha256 = bridge::config_hash(config);
  options.device.device = config.device;
  options.device.device_sha256 = config.device_sha256;
  if (config.side == "left") options.device.side = glenoid::device_v1_t::LEFT;
  options.device.period_ns = config.settings.period_ns;
  for (std::size_t b = 0; b < config.buses.size(); ++b)
    if (!can::is_virtual(config.buses[b].url)) options.device.real_bus_mask |= 1 << b;
  for (std::size_t j = 0; j < config.settings.joints.size(); ++j) {
    const bridge::JointSettings& joint = config.settings.joints[j];
    options.device.joint_names.push_back(joint.name);
    options.device.lower_rad[j] = joint.lower_rad;
    options.device.upper_rad[j] = joint.upper_rad;
    options.device.velocity_limit_rad_per_s[j] = joint.velocity_rad_per_s;
    options.device.acceleration_limit_rad_per_s2[j] = joint.acceleration_rad_per_s2;
  }
  if (const std::string warning = lcm_port::route_warning(a.lcm_url); !warning.empty() && !a.allow_network)
    std::fprintf(stderr, "glenoid-bridge: %s\n", warning.c_str());
  return std::make_unique<lcm_port::LcmPort>(options);
}

/// What goes on beside the loop: events to the terminal, figures to their file and channel.
class Watcher {
 public:
  Watcher(bridge::Loop& loop, lcm_port::LcmPort* lcm, const Arguments& a)
      : loop_(loop), lcm_(lcm), stats_(a.stats), quiet_(a.quiet) {
    if (!show_figures()) throw std::runtime_error(stats_ + ": cannot be written");
    thread_ = std::thread([this] { watch(); });
  }
  ~Watcher() {
    over_ = true;
    thread_.join();
  }
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;

 private:
  void watch() {
    for (int turn = 0; !over_.load(); ++turn) {
      print_events();
      if (turn % 20 == 19) show_figures();
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    print_events();
    show_figures();
  }
  void print_events() {
    bridge::Event event;
    while (loop_.take_event(event))
      if (!quiet_ || event.severity != bridge::Severity::Info) std::puts(bridge::describe(event).c_str());
    std::fflush(stdout);
  }
  bool show_figures() {
    const bridge::Figures figures = loop_.figures().in_short(bridge::monotonic_ns());
    if (lcm_ != nullptr) lcm_->tell(figures);
    return stats_.empty() || bridge::write_whole(stats_, bridge::to_json(figures));
  }

  bridge::Loop& loop_;
  lcm_port::LcmPort* lcm_;
  std::string stats_;
  bool quiet_;
  std::atomic<bool> over_ = false;
  std::thread thread_;
};

int run(const Arguments& a, const bridge::Config& config) {
  bridge::LoopOptions options;
  options.priority = a.priority;
  options.duration_s = a.duration_s;
  options.awake_us = a.priority > 0 ? a.awake_us : 0.0;
  options.silent = a.dry_run;
  options.deadman_test = a.deadman;
  options.estop_descriptor = a.estop_stdin ? 0 : a.estop_fd;
  options.arming_obstacle = arming_obstacle(a, config);
  std::vector<std::string> names;
  for (const bridge::BusConfig& bus : config.buses) names.push_back(bus.name);
  const auto log = a.log.empty() ? nullptr : std::make_unique<bridge::FrameLog>(a.log, names);
  const auto lcm = open_lcm(a, config);
  const auto loop = std::make_unique<bridge::Loop>(config, open_ports(config, false), lcm.get(), log.get(), options);
  auto watcher = std::make_unique<Watcher>(*loop, lcm.get(), a);
  running = loop.get();
  for (const std::string& refused : bridge::become_realtime(a.priority))
    std::fprintf(stderr, "glenoid-bridge: %s\n", refused.c_str());
  const bridge::IdleLatency idle(a.priority > 0);
  if (a.priority > 0 && !idle.granted())
    std::fprintf(stderr, "glenoid-bridge: idle states stay allowed (/dev/cpu_dma_latency): wake-ups may be late\n");
  loop->run();
  running = nullptr;
  watcher.reset();
  if (!a.quiet) std::fputs(bridge::describe(loop->figures().in_short(bridge::monotonic_ns())).c_str(), stdout);
  if (log && log->lost() > 0)
    std::fprintf(stderr, "glenoid-bridge: %llu frames are missing in the log\n",
                 static_cast<unsigned long long>(log->lost()));
  if (a.deadman) {
    std::printf("dead-man self-test: %s\n", loop->deadman_passed() ? "PASS, every drive reported 8130h" : "FAIL");
    return loop->deadman_passed() ? 0 : 1;
  }
  return loop->stopped_by_fault() ? 1 : 0;
}

}  // namespace

int main(int count, char** values) {
  Arguments a;
  CLI::App app{"Setpoints on LCM to CiA 402 drives on CAN. Research software, not a medical device."};
  define(app, a);
  try {
    app.parse(count, values);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    const bridge::Config config = bridge::load_config(a.config, a.exoskeleton);
    if (!a.quiet || a.check) std::fputs(bridge::describe(config).c_str(), stdout);
    if (a.check) return 0;
    catch_signals();
    if (a.monitor) return bridge::monitor(config, open_ports(config, true), a.duration_s);
    return run(a, config);
  } catch (const bridge::ConfigError& error) {
    std::fprintf(stderr, "glenoid-bridge: %s: %s\n", a.config.c_str(), error.what());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "glenoid-bridge: %s\n", error.what());
  }
  return 2;
}
