#include "host/drives/profile.hpp"

#include <charconv>
#include <stdexcept>
#include <string_view>

#include "host/drives/section.hpp"

namespace glenoid::drives {
namespace {

/// "6007h" or "1400h:05"; without a sub-index `whole`.
Address parse_address(const Section& section, const std::string& text, std::uint8_t whole) {
  const std::size_t h = text.find('h');
  const std::size_t colon = text.find(':');
  unsigned index = 0, sub = whole;
  const auto hex = [&](std::string_view digits, unsigned& value) {
    const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
    if (digits.empty() || result.ec != std::errc{} || result.ptr != digits.data() + digits.size()) {
      section.fail(text + ": an object is written 6007h or 1400h:05");
    }
  };
  if (h == std::string::npos) section.fail(text + ": an object is written 6007h or 1400h:05");
  const std::string_view all = text;
  hex(all.substr(0, h), index);
  if (colon != std::string::npos) hex(all.substr(colon + 1), sub);
  if (index > 0xFFFF || sub > 0xFF) section.fail(text + ": out of range");
  return {static_cast<std::uint16_t>(index), static_cast<std::uint8_t>(sub)};
}

void read_mechanics(const Section& section, Mechanics& mechanics) {
  section.allow_only({"encoder_counts_per_motor_rev", "gear_ratio", "inertia_kg_m2", "rated_torque_Nm",
                      "peak_torque_Nm", "coulomb_friction_Nm", "viscous_friction_Nm_s_per_rad", "max_speed_rad_per_s",
                      "no_load_speed_ratio", "brake", "brake_torque_Nm", "brake_delay_s"});
  section.read("encoder_counts_per_motor_rev", mechanics.encoder_counts_per_motor_rev);
  section.read("gear_ratio", mechanics.gear_ratio);
  section.read_positive("inertia_kg_m2", mechanics.inertia_kg_m2);
  section.read_positive("rated_torque_Nm", mechanics.rated_torque_Nm);
  section.read_positive("peak_torque_Nm", mechanics.peak_torque_Nm);
  section.read_not_negative("coulomb_friction_Nm", mechanics.coulomb_friction_Nm);
  section.read_not_negative("viscous_friction_Nm_s_per_rad", mechanics.viscous_friction_Nm_s_per_rad);
  section.read_positive("max_speed_rad_per_s", mechanics.max_speed_rad_per_s);
  section.read_positive("no_load_speed_ratio", mechanics.no_load_speed_ratio);
  if (mechanics.no_load_speed_ratio <= 1.0)
    section.fail("no_load_speed_ratio = " + std::to_string(mechanics.no_load_speed_ratio) + ": must be above 1");
  section.read("brake", mechanics.brake);
  section.read_positive("brake_torque_Nm", mechanics.brake_torque_Nm);
  section.read_not_negative("brake_delay_s", mechanics.brake_delay_s);
  if (mechanics.counts_per_rev() < 1.0) section.fail("encoder counts times gear ratio must be at least 1");
}

void read_control(const Section& section, Control& control) {
  section.allow_only(
      {"position_bandwidth_rad_per_s", "velocity_bandwidth_rad_per_s", "integral_time_s", "velocity_filter_s"});
  section.read_positive("position_bandwidth_rad_per_s", control.position_bandwidth_rad_per_s);
  section.read_positive("velocity_bandwidth_rad_per_s", control.velocity_bandwidth_rad_per_s);
  section.read_positive("integral_time_s", control.integral_time_s);
  section.read_not_negative("velocity_filter_s", control.velocity_filter_s);
}

void read_bit(const Section& section, const std::string& key, int& bit) {
  section.read(key, bit);
  if (bit < -1 || bit > 15) section.fail(key + " = " + std::to_string(bit) + ": a bit of 6041h, 0 to 15");
}

Profile read_profile(const Section& file) {
  file.allow_only({"name", "device_name", "description", "sources", "mechanics", "control", "timing", "communication",
                   "objects", "absent"});
  Profile profile;
  file.read("name", profile.name);
  file.read("device_name", profile.device_name);
  read_mechanics(file.section("mechanics"), profile.mechanics);
  read_control(file.section("control"), profile.control);
  const Section timing = file.section("timing");
  timing.allow_only({"boot_s", "enable_s"});
  timing.read_not_negative("boot_s", profile.boot_s);
  timing.read_not_negative("enable_s", profile.enable_s);
  const Section communication = file.section("communication");
  communication.allow_only({"dummy_mapping", "synchronised_bit", "sync_lost_bit"});
  communication.read("dummy_mapping", profile.dummy_mapping);
  read_bit(communication, "synchronised_bit", profile.synchronised_bit);
  read_bit(communication, "sync_lost_bit", profile.sync_lost_bit);
  const Section objects = file.section("objects");
  for (const auto& entry : objects.node()) {
    const auto key = entry.first.as<std::string>();
    std::int64_t value = 0;
    objects.read(key, value);
    profile.objects.push_back({parse_address(objects, key, 0), value});
  }
  const YAML::Node absent = file.get("absent");
  if (absent && !absent.IsSequence()) file.fail("absent: must be a list of objects");
  for (const auto& entry : absent) {
    profile.absent.push_back(parse_address(file, entry.as<std::string>(), 0xFF));
  }
  return profile;
}

}  // namespace

Profile load_profile(const std::filesystem::path& file) { return read_profile(read_yaml(file)); }

}  // namespace glenoid::drives
