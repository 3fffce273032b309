#include "host/bridge/config/config.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>

#include "host/bridge/can/bus_load.hpp"
#include "host/bridge/core/codec.hpp"
#include "host/bridge/core/pdo_table.hpp"
#include "host/bridge/core/resampler.hpp"
#include "host/bridge/core/startup.hpp"

namespace glenoid::bridge {
namespace {

using Range = YamlReader::Range;
constexpr double kMost = std::numeric_limits<double>::max();
constexpr Range kPositive{0.0, kMost, true};
constexpr double kAngle = 100.0;  // rad: sixteen turns either way; more is a mistake in the unit

constexpr double kCoarse = 0.02;  // rad of a count: no drive is that coarse; a ratio turned upside down is

double ms(std::int64_t ns) { return 1e-6 * static_cast<double>(ns); }

void read_timing(YamlReader& exo, Config& config) {
  Settings& s = config.settings;
  YamlReader sync = exo.mapping("sync");
  s.period_ns = sync.milliseconds("period_ms", {0.5, 100.0}, 2.0);
  s.second_tpdo_every = static_cast<std::uint8_t>(sync.integer("second_tpdo_every", 0, 240, 0));
  config.rpdo_phase = sync.number("rpdo_phase", {0.1, 0.9}, 0.5);
  sync.finish();

  YamlReader set = exo.mapping("setpoints");
  s.setpoint_period_ns = set.milliseconds("period_ms", {0.5, 200.0}, ms(s.period_ns));
  const double slower_ms = ms(std::max(s.period_ns, s.setpoint_period_ns));
  s.delay_ns = set.milliseconds("delay_ms", {0.0, 1000.0}, 2.0 * slower_ms);
  s.time_base = set.choice("time_base", {"stamp", "estimated"}, 0) == 0 ? TimeBase::Stamp : TimeBase::Estimated;
  s.hold_after_ns = set.milliseconds("hold_after_ms", {0.5, 1000.0}, 3.0 * slower_ms);
  s.quick_stop_after_ns = set.milliseconds("quick_stop_after_ms", {1.0, 2000.0}, 50.0);
  s.disarm_after_ns = set.milliseconds("disarm_after_ms", {1.0, 10000.0}, 500.0);
  s.max_age_ns = set.milliseconds("max_age_ms", {1.0, 2000.0}, ms(s.quick_stop_after_ns));
  s.max_lead_ns = set.milliseconds("max_lead_ms", {0.0, 2000.0}, 100.0);
  if (s.hold_after_ns < s.setpoint_period_ns) set.fail("hold_after_ms", "must not be below setpoints.period_ms");
  if (s.quick_stop_after_ns <= s.hold_after_ns) set.fail("quick_stop_after_ms", "must be above hold_after_ms");
  if (s.disarm_after_ns < s.quick_stop_after_ns) set.fail("disarm_after_ms", "must not be below quick_stop_after_ms");
  constexpr std::int64_t kKept = Resampler::kCapacity - 2;
  if ((s.delay_ns + s.max_lead_ns) / s.setpoint_period_ns > kKept)
    set.fail("delay_ms", "with max_lead_ms it spans more than " + std::to_string(kKept) + " setpoints of period_ms");
  if (s.hold_after_ns < 2 * s.setpoint_period_ns)
    config.warnings.push_back(
        "setpoints.hold_after_ms is below two setpoint periods: one late setpoint holds the motion");
  if (s.delay_ns < s.setpoint_period_ns)
    config.warnings.push_back("setpoints.delay_ms is below the setpoint period: late setpoints are extrapolated");
  set.finish();
}

void read_supervision(YamlReader& exo, Config& config) {
  Settings& s = config.settings;
  YamlReader beat = exo.mapping("heartbeat");
  s.master_id = static_cast<std::uint8_t>(beat.integer("master_id", 1, 127, 127));
  s.master_heartbeat_ns = beat.milliseconds("master_period_ms", {1.0, 1000.0}, 20.0);
  s.consumer_heartbeat_ns = beat.milliseconds("drive_waits_ms", {2.0, 10000.0}, 60.0);
  s.drive_heartbeat_ns = beat.milliseconds("drive_period_ms", {1.0, 5000.0}, 100.0);
  s.heartbeat_timeout_ns = beat.milliseconds("drive_timeout_ms", {2.0, 20000.0}, 250.0);
  if (s.master_heartbeat_ns < s.period_ns) beat.fail("master_period_ms", "must not be below sync.period_ms");
  if (s.consumer_heartbeat_ns < 2 * s.master_heartbeat_ns)
    beat.fail("drive_waits_ms", "must be at least twice master_period_ms");
  if (s.heartbeat_timeout_ns < 2 * s.drive_heartbeat_ns)
    beat.fail("drive_timeout_ms", "must be at least twice drive_period_ms");
  beat.finish();

  YamlReader watch = exo.mapping("supervision");
  s.sdo_timeout_ns = watch.milliseconds("sdo_timeout_ms", {5.0, 10000.0}, 100.0);
  s.sdo_retries = static_cast<int>(watch.integer("sdo_retries", 0, 20, 3));
  s.state_timeout_ns = watch.milliseconds("state_timeout_ms", {10.0, 60000.0}, 1000.0);
  s.feedback_misses = static_cast<int>(watch.integer("feedback_misses", 1, 1000, 5));
  s.transmit_skips = static_cast<int>(watch.integer("transmit_skips", 1, 100, 5));
  watch.finish();
}

void read_device(YamlReader& exo, Config& config) {
  YamlReader device = exo.mapping("device");
  config.device = device.text("name", "");
  config.device_sha256 = device.text("sha256", "");
  if (config.device.empty() != config.device_sha256.empty())
    device.fail(config.device.empty() ? "name" : "sha256", "name and sha256 are needed");
  if (config.device.size() > 31) device.fail("name", "must have at most 31 bytes");
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  const std::string& hash = config.device_sha256;
  if (!hash.empty() && (hash.size() != 64 || !std::all_of(hash.begin(), hash.end(), is_digit)))
    device.fail("sha256", "must be 64 hexadecimal digits in lower case");
  device.finish();
}

void read_buses(YamlReader& exo, Config& config) {
  const YAML::Node list = exo.list("buses");
  if (!list.IsDefined() || list.size() == 0) exo.fail("buses", "at least one bus is needed");
  if (list.size() > kMaxBuses) exo.fail("buses", "at most 4 buses are possible");
  std::set<std::string> names, urls;
  for (std::size_t b = 0; b < list.size(); ++b) {
    YamlReader bus(list[b], exo.path() + ".buses[" + std::to_string(b) + "]");
    BusConfig& own = config.buses.emplace_back();
    own.name = bus.text("name");
    own.url = bus.text("url");
    own.bit_rate_bit_per_s = bus.number("rate_bit_per_s", {10e3, 1e6}, 1e6);
    if (!names.insert(own.name).second) bus.fail("name", "another bus has this name");
    if (!urls.insert(own.url).second) bus.fail("url", "another bus has this URL");
    bus.finish();
    config.settings.bit_rate_bit_per_s.push_back(own.bit_rate_bit_per_s);
  }
  config.settings.bus_count = config.buses.size();
}

void read_gear(YamlReader joint, JointSettings& own) {
  own.gear_ratio = joint.number("ratio", kPositive);
  own.sign = joint.choice("sign", {"1", "-1"}) == 0 ? 1 : -1;
  own.offset_rad = joint.number("offset_rad", {-kAngle, kAngle}, 0.0);
  own.encoder_counts_per_turn = joint.number("encoder_counts_per_turn", {1.0, 4294967296.0});
  own.rated_torque_Nm = joint.number("rated_torque_Nm", {0.0, 10000.0}, 0.0);
  if (const double count_rad = Scale(own).position_rad(1) - Scale(own).position_rad(0); std::abs(count_rad) > kCoarse)
    joint.fail("ratio", "one encoder count is more than 0.02 rad at the joint");
  joint.finish();
}

void read_limits(YamlReader limits, const Settings& s, JointSettings& own) {
  own.lower_rad = limits.number("lower_rad", {-kAngle, kAngle});
  own.upper_rad = limits.number("upper_rad", {-kAngle, kAngle});
  own.velocity_rad_per_s = limits.number("velocity_rad_per_s", {0.0, 100.0, true});
  own.acceleration_rad_per_s2 = limits.number("acceleration_rad_per_s2", {0.0, 10000.0, true});
  const double per_cycle = own.velocity_rad_per_s * 1e-9 * static_cast<double>(s.period_ns);
  own.step_rad = limits.number("step_rad", kPositive, std::max(0.02, 3.0 * per_cycle));
  own.start_window_rad = limits.number("start_window_rad", {0.0, 1.0, true}, 0.05);
  own.blend_rad_per_s = limits.number("blend_rad_per_s", {0.0, 100.0, true}, 0.1 * own.velocity_rad_per_s);
  own.measured_margin_rad = limits.number("measured_margin_rad", {0.0, 1.0}, 0.05);
  own.on_limit = limits.choice("on_limit", {"clamp", "stop"}, 0) == 0 ? OnLimit::Clamp : OnLimit::Stop;
  if (!(own.lower_rad < own.upper_rad)) limits.fail("upper_rad", "must be above lower_rad");
  if (own.step_rad < per_cycle) limits.fail("step_rad", "must not be below velocity limit times SYNC period");
  if (own.blend_rad_per_s > own.velocity_rad_per_s)
    limits.fail("blend_rad_per_s", "must not exceed the velocity limit");
  limits.finish();
}

void read_drive(YamlReader drive, JointSettings& own) {
  own.quick_stop_option = drive.choice("quick_stop_option", {"2", "6"}, 1) == 0 ? 2 : 6;
  own.fault_reaction = static_cast<std::int16_t>(drive.integer("fault_reaction", 0, 4, 2));
  own.vendor = static_cast<std::uint32_t>(drive.integer("vendor", 0, 0xFFFFFFFF, 0));
  own.product = static_cast<std::uint32_t>(drive.integer("product", 0, 0xFFFFFFFF, 0));
  own.may_lack_heartbeat_consumer = drive.choice("heartbeat_consumer", {"needed", "missing_is_accepted"}, 0) == 1;
  const YAML::Node objects = drive.list("objects");
  for (std::size_t k = 0; objects.IsDefined() && k < objects.size(); ++k) {
    YamlReader object(objects[k], drive.path() + ".objects[" + std::to_string(k) + "]");
    ExtraObject extra;
    extra.index = static_cast<std::uint16_t>(object.integer("index", 0x1001, 0xFFFF));
    extra.subindex = static_cast<std::uint8_t>(object.integer("subindex", 0, 0xFF, 0));
    extra.bytes = static_cast<std::uint8_t>(1U << object.choice("bytes", {"1", "2", "4"}));
    extra.value = object.integer("value", -(std::int64_t{1} << (8 * extra.bytes - 1)),
                                 (std::int64_t{1} << (8 * extra.bytes)) - 1);
    object.finish();
    own.objects.push_back(extra);
  }
  drive.finish();
}

void read_joint(YamlReader& joint, Config& config) {
  JointSettings own;
  own.name = joint.text("name");
  const std::string bus = joint.text("bus");
  const auto found = std::find_if(config.buses.begin(), config.buses.end(),
                                  [&](const auto& b) { return b.name == bus; });
  if (found == config.buses.end()) joint.fail("bus", "no bus has this name");
  own.bus = static_cast<std::size_t>(found - config.buses.begin());
  own.node = static_cast<std::uint8_t>(joint.integer("node", 1, 127));
  if (own.node == config.settings.master_id) joint.fail("node", "is the master's own id");
  for (const JointSettings& other : config.settings.joints) {
    if (other.name == own.name) joint.fail("name", "another joint has this name");
    if (other.bus == own.bus && other.node == own.node) joint.fail("node", "another drive of this bus has this id");
  }
  read_gear(joint.mapping("gear"), own);
  read_limits(joint.mapping("limits"), config.settings, own);
  YamlReader following = joint.mapping("following_error");
  own.following_window_rad = following.number("window_rad", {0.0, 3.0, true}, 0.1);
  own.following_time_ns = following.milliseconds("time_ms", {0.0, 5000.0}, 20.0);
  following.finish();
  read_drive(joint.mapping("drive"), own);
  if (own.may_lack_heartbeat_consumer)
    config.warnings.push_back(own.name + ": a drive that does not notice when the bridge is gone is accepted");
  try {  // whether every object has room for its value is known where they are written
    static_cast<void>(configuration_steps(config.settings, own));
  } catch (const std::invalid_argument& error) {
    throw ConfigError(joint.line(), joint.path(), own.name, error.what());
  }
  config.settings.joints.push_back(std::move(own));
  joint.finish();
}

void read_joints(YamlReader& exo, Config& config) {
  const YAML::Node defaults = exo.raw("joint_defaults");
  if (defaults.IsDefined() && !defaults.IsNull() && !defaults.IsMap()) exo.fail("joint_defaults", "must be a mapping");
  const YAML::Node list = exo.list("joints");
  if (!list.IsDefined() || list.size() == 0) exo.fail("joints", "at least one joint is needed");
  if (list.size() > kMaxJoints) exo.fail("joints", "at most 16 joints are possible");
  for (std::size_t j = 0; j < list.size(); ++j) {
    YamlReader joint(list[j], exo.path() + ".joints[" + std::to_string(j) + "]", defaults);
    read_joint(joint, config);
  }
}

void check_load(YamlReader& exo, Config& config) {
  const Settings& s = config.settings;
  for (std::size_t b = 0; b < config.buses.size(); ++b) {
    can::BusTraffic traffic;
    traffic.bit_rate = config.buses[b].bit_rate_bit_per_s;
    traffic.sync_rate_hz = 1e9 / static_cast<double>(s.period_ns);
    traffic.drives = static_cast<std::size_t>(
        std::count_if(s.joints.begin(), s.joints.end(), [&](const JointSettings& j) { return j.bus == b; }));
    traffic.rpdo_bytes = kRpdo1.bytes();
    traffic.tpdo_bytes = kTpdo1.bytes();
    if (s.second_tpdo_every > 0) traffic.second_tpdo_rate_hz = traffic.sync_rate_hz / s.second_tpdo_every;
    traffic.second_tpdo_bytes = kTpdo2.bytes();
    traffic.drive_heartbeat_rate_hz = 1e9 / static_cast<double>(s.drive_heartbeat_ns);
    traffic.master_heartbeat_rate_hz = 1e9 / static_cast<double>(s.master_heartbeat_ns);
    if (traffic.drives == 0) exo.fail("buses", "bus " + config.buses[b].name + " has no drive");
    const double load = config.buses[b].worst_case_load = can::worst_case_load(traffic);
    char text[120];
    std::snprintf(text, sizeof text, "worst-case load of bus %s is %.0f %%", config.buses[b].name.c_str(), 100.0 * load);
    if (load > can::kLoadRefused) exo.fail("buses", std::string(text) + ", above 90 %");
    if (load > can::kLoadWarned) config.warnings.push_back(std::string(text) + ", above 80 %");
  }
}

YAML::Node load_yaml(const std::string& yaml) {
  try {
    return YAML::Load(yaml);
  } catch (const YAML::Exception& error) {
    throw ConfigError(error.mark.line + 1, "the file", "YAML", error.msg);
  }
}

YamlReader open_root(const YAML::Node& root) {
  if (!root.IsMap()) throw ConfigError(1, "the file", "no mapping", "must hold the key exoskeletons");
  return YamlReader(root, "");
}

}  // namespace

std::vector<std::string> exoskeleton_names(const std::string& yaml) {
  const YAML::Node root = load_yaml(yaml);
  YamlReader reader = open_root(root);
  const YAML::Node all = reader.raw("exoskeletons");
  if (!all.IsDefined() || !all.IsMap() || all.size() == 0) reader.fail("exoskeletons", "must be a mapping of names");
  reader.finish();
  std::vector<std::string> names;
  for (const auto& entry : all) names.push_back(entry.first.as<std::string>());
  return names;
}

Config parse_config(const std::string& yaml, std::string_view name) {
  try {
    const std::vector<std::string> names = exoskeleton_names(yaml);
    std::string all;
    for (const std::string& one : names) all += (all.empty() ? "" : ", ") + one;
    if (name.empty() && names.size() > 1) throw ConfigError(1, "exoskeletons", all, "say which one is meant");
    const std::string chosen = name.empty() ? names.front() : std::string(name);
    if (std::find(names.begin(), names.end(), chosen) == names.end())
      throw ConfigError(1, "exoskeletons", all, "there is no " + chosen);
    const YAML::Node root = load_yaml(yaml);
    YamlReader exo(root["exoskeletons"][chosen], "exoskeletons." + chosen);
    Config config;
    config.settings.name = chosen;
    config.side = exo.choice("side", {"right", "left"}, 0) == 0 ? "right" : "left";
    read_device(exo, config);
    read_timing(exo, config);
    read_supervision(exo, config);
    read_buses(exo, config);
    read_joints(exo, config);
    exo.finish();
    check_load(exo, config);
    return config;
  } catch (const YAML::Exception& error) {
    throw ConfigError(error.mark.line + 1, "the file", "YAML", error.msg);
  }
}

Config load_config(const std::filesystem::path& file, std::string_view name) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error(file.string() + ": cannot be read");
  const std::string yaml((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  return parse_config(yaml, name);
}

}  // namespace glenoid::bridge
