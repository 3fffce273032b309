// The configuration: what is right is read, what is wrong is refused with line, key, value and rule.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "host/bridge/config/config.hpp"
#include "host/bridge/config/digest.hpp"
#include "host/bridge/core/bridge.hpp"

namespace glenoid::bridge::test {
namespace {

const std::filesystem::path kExamples = GLENOID_BRIDGE_EXAMPLES;

std::string example(const char* name) {
  std::ifstream stream(kExamples / name);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// What is wrong with a configuration; empty: nothing.
std::string complaint(const std::string& yaml, std::string_view name = {}) {
  try {
    static_cast<void>(parse_config(yaml, name));
    return {};
  } catch (const ConfigError& error) {
    return error.what();
  }
}

TEST(BridgeConfig, ExamplesAreReadAndMakeABridge) {
  for (const auto& entry : std::filesystem::directory_iterator(kExamples)) {
    const Config config = load_config(entry.path());
    EXPECT_NO_THROW(Bridge{config.settings}) << entry.path();
    EXPECT_EQ(config.settings.joints.size(), 6U);
    for (const BusConfig& bus : config.buses) EXPECT_LE(bus.worst_case_load, 0.9);
  }
}

TEST(BridgeConfig, OwnKeysWinOverDefaults) {
  const Config config = load_config(kExamples / "two_buses.yaml");
  EXPECT_EQ(config.settings.joints[0].sign, -1);
  EXPECT_EQ(config.settings.joints[5].sign, 1);
  EXPECT_EQ(config.settings.joints[5].offset_rad, 0.35);
  EXPECT_EQ(config.settings.joints[5].gear_ratio, 100.0);
  EXPECT_EQ(config.settings.joints[5].on_limit, OnLimit::Stop);
  ASSERT_EQ(config.settings.joints[5].objects.size(), 1U);
  EXPECT_EQ(config.settings.joints[5].objects[0].index, 0x6085);
  EXPECT_EQ(config.warnings.size(), 2U);  // 81 % of each bus
}

struct Mistake {
  const char* name;
  const char* from;
  const char* to;
  std::vector<const char*> words;  ///< all of them must be said
};

class Mistakes : public ::testing::TestWithParam<Mistake> {};

TEST_P(Mistakes, AreRefusedInWords) {
  const std::string yaml = replaced(example("six_drives.yaml"), GetParam().from, GetParam().to);
  const std::string said = complaint(yaml);
  EXPECT_TRUE(said.starts_with("line ")) << said;
  for (const char* word : GetParam().words) EXPECT_NE(said.find(word), std::string::npos) << said << " / " << word;
}

INSTANTIATE_TEST_SUITE_P(
    Config, Mistakes,
    ::testing::Values(
        Mistake{"unknown_key", "side: right", "sidee: right", {"line 4", "sidee", "right", "not known"}},
        Mistake{"wrong_unit",
                "velocity_rad_per_s: 2.5",
                "velocity_deg_per_s: 140",
                {"line 20", "velocity_deg_per_s", "140", "wrong unit", "velocity_rad_per_s"}},
        Mistake{"period_in_seconds", "sync: {period_ms: 2,", "sync: {period_s: 0.002,", {"period_s", "write period_ms"}},
        Mistake{"number_with_unit", "lower_rad: -0.8", "lower_rad: -30deg", {"lower_rad", "-30deg", "finite number"}},
        Mistake{"not_a_number", "upper_rad: 0.8", "upper_rad: .nan", {"upper_rad", "finite number"}},
        Mistake{"limits_swapped", "lower_rad: -0.8", "lower_rad: 0.9", {"upper_rad", "above lower_rad"}},
        Mistake{"degrees_in_the_file", "upper_rad: 0.8", "upper_rad: 145", {"upper_rad", "145", "between"}},
        Mistake{"node_twice", "node: 2", "node: 1", {"node", "another drive of this bus"}},
        Mistake{"node_out_of_range", "node: 2", "node: 200", {"node", "200", "between 1 and 127"}},
        Mistake{"node_of_the_master", "node: 2", "node: 127", {"node", "master"}},
        Mistake{"name_twice", "name: elbow", "name: shoulder_3", {"name", "another joint"}},
        Mistake{"unknown_bus", "bus: arm", "bus: leg", {"bus", "leg", "no bus"}},
        Mistake{"ratio_zero", "ratio: 100", "ratio: 0", {"ratio", "above 0"}},
        Mistake{"ratio_upside_down", "ratio: 100", "ratio: 0.01", {"ratio", "0.01", "encoder count"}},
        Mistake{"ratio_next_to_zero", "ratio: 100", "ratio: 1e-320", {"ratio", "encoder count"}},
        Mistake{"delay_beyond_what_is_kept", "delay_ms: 4 ", "delay_ms: 500 ", {"delay_ms", "500", "254 setpoints"}},
        Mistake{"device_without_name", "{name: harmony, sha", "{sha", {"device.name", "needed"}},
        Mistake{"device_without_hash", "harmony, sha256:", "harmony, sha:", {"device.sha256", "needed"}},
        Mistake{"device_hash_with_capitals", "sha256: 30ba", "sha256: 30BA", {"device.sha256", "64 hexadecimal"}},
        Mistake{"device_hash_cut", "sha256: 30ba", "sha256: ", {"device.sha256", "64 hexadecimal"}},
        Mistake{"sign", "sign: 1,", "sign: 0,", {"sign", "one of 1, -1"}},
        Mistake{"duplicate_key", "side: right", "side: right\n    side: left", {"side", "twice"}},
        Mistake{"overload", "period_ms: 2, rpdo", "period_ms: 1, rpdo", {"buses", "above 90 %"}},
        Mistake{"slow_bus", "rate_bit_per_s: 1000000", "rate_bit_per_s: 500000", {"buses", "above 90 %"}},
        Mistake{"hold_after_stop", "hold_after_ms: 6 ", "hold_after_ms: 60 ", {"quick_stop_after_ms", "hold_after_ms"}},
        Mistake{"deaf_consumer", "drive_waits_ms: 60", "drive_waits_ms: 30", {"drive_waits_ms", "twice"}},
        Mistake{"odd_period", "period_ms: 2, rpdo", "period_ms: 2.0001, rpdo", {"60C2h"}},
        Mistake{"too_many_counts", "encoder_counts_per_turn: 16384", "encoder_counts_per_turn: 100000000", {"counts"}},
        Mistake{"no_mapping", "side: right", "- right", {"YAML"}}),
    [](const auto& tested) { return tested.param.name; });

TEST(BridgeConfig, SecondTpdoCountsInTheBusLoad) {
  const std::string with = replaced(example("six_drives.yaml"), "rpdo_phase: 0.5}",
                                    "rpdo_phase: 0.5, second_tpdo_every: 10}");
  const Config plain = parse_config(example("six_drives.yaml")), second = parse_config(with);
  EXPECT_EQ(second.settings.second_tpdo_every, 10);
  // Six frames of 6 bytes, 115 bits at worst, 50 times a second, on 1 Mbit/s.
  EXPECT_NEAR(second.buses[0].worst_case_load - plain.buses[0].worst_case_load, 6 * 115 * 50 / 1e6, 1e-12);
  EXPECT_NE(config_hash(plain), config_hash(second));
}

TEST(BridgeConfig, DriveThatCannotWatchTheMasterNeedsAWordInTheFile) {
  const std::string with = replaced(example("six_drives.yaml"), "name: elbow,",
                                    "name: elbow, drive: {heartbeat_consumer: missing_is_accepted},");
  const Config plain = parse_config(example("six_drives.yaml")), accepted = parse_config(with);
  EXPECT_FALSE(plain.settings.joints[5].may_lack_heartbeat_consumer);
  EXPECT_TRUE(accepted.settings.joints[5].may_lack_heartbeat_consumer);
  EXPECT_FALSE(accepted.settings.joints[4].may_lack_heartbeat_consumer);
  EXPECT_EQ(accepted.warnings.size(), plain.warnings.size() + 1);
  EXPECT_NE(config_hash(plain), config_hash(accepted));
}

TEST(BridgeConfig, FilesThatAreNoneAreRefused) {
  for (const char* yaml : {"", "[]", "a: b", "exoskeletons:", "exoskeletons: {}", "exoskeletons: [1]", "{{{", "\t",
                           "exoskeletons: {a: }", "exoskeletons: {a: {buses: 3}}", "&a [*a]"})
    EXPECT_FALSE(complaint(yaml).empty()) << yaml;
}

TEST(BridgeConfig, ExoskeletonsAreChosenByName) {
  const std::string yaml = example("six_drives.yaml");
  const std::string other = example("six_drives_udp.yaml");
  const std::string both = yaml + other.substr(other.find("  six_drives_udp:"));
  EXPECT_NE(complaint(both).find("say which one"), std::string::npos);
  EXPECT_EQ(parse_config(both, "six_drives_udp").buses[0].url, "udp:239.74.163.2");
  EXPECT_NE(complaint(both, "seven").find("there is no seven"), std::string::npos);
}

TEST(BridgeConfig, HashIsOfWhatMovesTheDrivesAndNotOfTheBus) {
  const std::string yaml = example("six_drives.yaml");
  const std::string hash = config_hash(parse_config(yaml));
  EXPECT_EQ(hash.size(), 64U);
  EXPECT_EQ(config_hash(parse_config(replaced(yaml, "socketcan:vcan0", "socketcan:can0"))), hash);
  EXPECT_EQ(config_hash(parse_config("# a comment\n" + yaml)), hash);
  for (const auto& [from, to] : std::vector<std::pair<const char*, const char*>>{{"upper_rad: 0.8", "upper_rad: 0.81"},
                                                                                 {"sign: 1,", "sign: -1,"},
                                                                                 {"node: 2", "node: 7"},
                                                                                 {"delay_ms: 4", "delay_ms: 5"},
                                                                                 {"side: right", "side: left"},
                                                                                 {"sha256: 30ba", "sha256: 30bb"},
                                                                                 {"time_ms: 30", "time_ms: 31"}})
    EXPECT_NE(config_hash(parse_config(replaced(yaml, from, to))), hash) << to;
}

TEST(BridgeConfig, Sha256IsTheStandards) {
  // FIPS 180-4, examples of NIST.
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

}  // namespace
}  // namespace glenoid::bridge::test
