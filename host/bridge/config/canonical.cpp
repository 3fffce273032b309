#include <cstdio>
#include <initializer_list>
#include <utility>

#include "host/bridge/config/config.hpp"
#include "host/bridge/config/digest.hpp"

namespace glenoid::bridge {

std::string canonical(const Config& config) {
  std::string text;
  const auto line = [&](const std::string& key, double value) {
    char buffer[200];
    std::snprintf(buffer, sizeof buffer, "%s=%.17g\n", key.c_str(), value);
    text += buffer;
  };
  const auto count = [&](const std::string& key, std::int64_t value) {
    text += key + "=" + std::to_string(value) + "\n";
  };
  const Settings& s = config.settings;
  text += "format=1\nname=" + s.name + "\nside=" + config.side + "\n";
  if (!config.device.empty()) text += "device=" + config.device_sha256 + "\n";
  line("rpdo_phase", config.rpdo_phase);
  for (const auto& [key, value] :
       std::initializer_list<std::pair<const char*, std::int64_t>>{{"period_ns", s.period_ns},
                                                                   {"setpoint_period_ns", s.setpoint_period_ns},
                                                                   {"delay_ns", s.delay_ns},
                                                                   {"time_base", static_cast<int>(s.time_base)},
                                                                   {"hold_after_ns", s.hold_after_ns},
                                                                   {"quick_stop_after_ns", s.quick_stop_after_ns},
                                                                   {"disarm_after_ns", s.disarm_after_ns},
                                                                   {"max_age_ns", s.max_age_ns},
                                                                   {"max_lead_ns", s.max_lead_ns},
                                                                   {"master_id", s.master_id},
                                                                   {"master_heartbeat_ns", s.master_heartbeat_ns},
                                                                   {"consumer_heartbeat_ns", s.consumer_heartbeat_ns},
                                                                   {"drive_heartbeat_ns", s.drive_heartbeat_ns},
                                                                   {"heartbeat_timeout_ns", s.heartbeat_timeout_ns},
                                                                   {"sdo_timeout_ns", s.sdo_timeout_ns},
                                                                   {"sdo_retries", s.sdo_retries},
                                                                   {"state_timeout_ns", s.state_timeout_ns},
                                                                   {"feedback_misses", s.feedback_misses},
                                                                   {"transmit_skips", s.transmit_skips}})
    count(key, value);
  if (s.second_tpdo_every > 0) count("second_tpdo_every", s.second_tpdo_every);
  for (const BusConfig& bus : config.buses) line("bus " + bus.name, bus.bit_rate_bit_per_s);
  for (const JointSettings& j : s.joints) {
    text += "joint " + j.name + "\n";
    for (const auto& [key, value] :
         std::initializer_list<std::pair<const char*, double>>{{"ratio", j.gear_ratio},
                                                               {"offset_rad", j.offset_rad},
                                                               {"counts", j.encoder_counts_per_turn},
                                                               {"rated_torque_Nm", j.rated_torque_Nm},
                                                               {"lower_rad", j.lower_rad},
                                                               {"upper_rad", j.upper_rad},
                                                               {"velocity", j.velocity_rad_per_s},
                                                               {"acceleration", j.acceleration_rad_per_s2},
                                                               {"step_rad", j.step_rad},
                                                               {"start_window_rad", j.start_window_rad},
                                                               {"blend", j.blend_rad_per_s},
                                                               {"measured_margin_rad", j.measured_margin_rad},
                                                               {"following_window_rad", j.following_window_rad}})
      line(key, value);
    for (const auto& [key, value] :
         std::initializer_list<std::pair<const char*, std::int64_t>>{{"bus", static_cast<std::int64_t>(j.bus)},
                                                                     {"node", j.node},
                                                                     {"sign", j.sign},
                                                                     {"following_time_ns", j.following_time_ns},
                                                                     {"on_limit", static_cast<int>(j.on_limit)},
                                                                     {"quick_stop_option", j.quick_stop_option},
                                                                     {"fault_reaction", j.fault_reaction},
                                                                     {"vendor", j.vendor},
                                                                     {"product", j.product}})
      count(key, value);
    if (j.may_lack_heartbeat_consumer) text += "may lack 1016h\n";
    for (const ExtraObject& o : j.objects)
      count("object " + std::to_string(o.index) + ":" + std::to_string(o.subindex) + "/" + std::to_string(o.bytes),
            o.value);
  }
  return text;
}

std::string config_hash(const Config& config) { return sha256(canonical(config)); }

}  // namespace glenoid::bridge
