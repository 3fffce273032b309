// Debian's LCM as the other end: prints what it hears as it understands it, and answers.
//
//   wires_lcm_peer URL    one JSON line: versions' fingerprints; then for each setpoint a status whose fields repeat it.
//                         Ends after a command.

#include <cstdio>
#include <glenoid/command_v1_t.hpp>
#include <glenoid/event_v1_t.hpp>
#include <glenoid/feedback_v1_t.hpp>
#include <glenoid/setpoint_v1_t.hpp>
#include <glenoid/status_v1_t.hpp>
#include <lcm/lcm-cpp.hpp>

namespace {

class Peer {
 public:
  explicit Peer(const char* url) : lcm_(url) {}

  int run() {
    if (!lcm_.good()) return 3;
    lcm_.subscribe("GLENOID_SETPOINT", &Peer::on_setpoint, this);
    lcm_.subscribe("GLENOID_COMMAND", &Peer::on_command, this);
    std::printf("{\"setpoint\":%lld,\"feedback\":%lld,\"command\":%lld,\"event\":%lld,\"status\":%lld}\n",
                hash<glenoid::setpoint_v1_t>(), hash<glenoid::feedback_v1_t>(), hash<glenoid::command_v1_t>(),
                hash<glenoid::event_v1_t>(), hash<glenoid::status_v1_t>());
    std::fflush(stdout);
    while (!done_) {
      if (lcm_.handleTimeout(20000) <= 0) return 4;
    }
    return 0;
  }

 private:
  template <class Message>
  static long long hash() {
    return static_cast<long long>(Message::getHash());
  }

  void on_setpoint(const lcm::ReceiveBuffer*, const std::string&, const glenoid::setpoint_v1_t* setpoint) {
    glenoid::status_v1_t status = {};
    status.sequence = setpoint->sequence;
    status.session = setpoint->session;
    status.joint_count = setpoint->count;
    for (int k = 0; k < 16; ++k) {
      status.following_error_rad[k] = setpoint->position_rad[k];
      status.velocity_limit_rad_per_s[k] = static_cast<float>(setpoint->velocity_rad_per_s[k]);
    }
    for (int k = 0; k < 32; ++k) status.exoskeleton[k] = static_cast<std::int8_t>(-k);
    lcm_.publish("GLENOID_STATUS", &status);
  }
  void on_command(const lcm::ReceiveBuffer*, const std::string&, const glenoid::command_v1_t*) { done_ = true; }

  lcm::LCM lcm_;
  bool done_ = false;
};

}  // namespace

int main(int count, char** arguments) { return count == 2 ? Peer(arguments[1]).run() : 2; }
