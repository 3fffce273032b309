// What the bridge says, as it stands in its messages.

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "host/bridge/lcm/convert.hpp"

namespace glenoid::lcm_port {
namespace {

TEST(ToWire, TextIsCutBetweenCharactersAndEndsWithZero) {
  bridge::Event event;
  event.text.fill('x');
  event.text[158] = '\xC3';  // a letter of two bytes that does not fit: 159 bytes and the zero
  event.text[159] = '\xA4';
  const event_v1_t out = to_wire(event);
  EXPECT_EQ(out.text[157], 'x');
  EXPECT_EQ(out.text[158], 0);
  EXPECT_EQ(out.text[159], 0);
}

TEST(ToWire, TrackingIsBitTwelveOfDrivesThatAnswered) {
  bridge::Feedback feedback;
  feedback.valid_mask = 0b011;
  feedback.statusword = {0x1237, 0x0237, 0x1237};
  EXPECT_EQ(to_wire(feedback, bridge::State::Run).tracking_mask, 0b001);
}

TEST(ToWire, StatusRelatesTheWallClock) {
  bridge::Status status;
  status.time_ns = 5;
  status.session = 9;
  status.bus[2].state = bridge::BusState::Off;
  status.drive[15].nmt = bridge::Nmt::Operational;
  const status_v1_t out = to_wire(status, {.exoskeleton = std::string(40, 'e'), .real_bus_mask = 2}, 77);
  EXPECT_EQ(out.time_mono_ns, 5);
  EXPECT_EQ(out.time_utc_ns, 77);
  EXPECT_EQ(out.session, 9);
  EXPECT_EQ(out.bus_state[2], status_v1_t::BUS_OFF);
  EXPECT_EQ(out.nmt_state[15], 5);
  EXPECT_EQ(out.real_bus_mask, 2);
  EXPECT_EQ(out.exoskeleton[30], 'e');
  EXPECT_EQ(out.exoskeleton[31], 0);
}

TEST(ToWire, DeviceKeepsItsPlaces) {
  Device device;
  device.exoskeleton = "mine";
  device.config_sha256 = std::string(63, 'a') + "b";
  device.device = std::string(40, 'n');
  device.device_sha256 = std::string(64, 'c');
  device.side = device_v1_t::LEFT;
  device.joint_names = {"one", "two"};
  device.lower_rad[1] = -2.0;
  device.upper_rad[1] = 3.0;
  const device_v1_t out = to_wire(device, 17);
  const auto text = [](const std::int8_t* from, std::size_t most) {
    const auto* characters = reinterpret_cast<const char*>(from);
    return std::string(characters, ::strnlen(characters, most));
  };
  EXPECT_EQ(out.time_mono_ns, 17);
  EXPECT_EQ(text(out.exoskeleton, 32), "mine");
  EXPECT_EQ(text(out.config_sha256, 64), device.config_sha256);
  EXPECT_EQ(text(out.device, 32), std::string(31, 'n'));
  EXPECT_EQ(text(out.device_sha256, 64), device.device_sha256);
  EXPECT_EQ(out.side, device_v1_t::LEFT);
  EXPECT_EQ(out.joint_count, 2);
  EXPECT_EQ(text(out.joint_name[1], 32), "two");
  EXPECT_EQ(text(out.joint_name[2], 32), "");
  EXPECT_EQ(out.lower_rad[1], -2.0);
  EXPECT_EQ(out.upper_rad[1], 3.0);
}

TEST(ToWire, FiguresKeepTheirPlaces) {
  bridge::Figures figures;
  figures.cycles = 7;
  figures.cycles_left_out = 3;
  for (std::size_t k = 0; k < bridge::kFigures; ++k) {
    const auto base = static_cast<double>(10 * k);
    figures.figure[k] = {static_cast<std::int64_t>(k), base + 1, base + 2, base + 3, base + 4};
  }
  const figures_v1_t out = to_wire(figures);
  EXPECT_EQ(out.cycles, 7);
  EXPECT_EQ(out.cycles_left_out, 3);
  EXPECT_EQ(out.count, static_cast<std::int32_t>(bridge::kFigures));
  for (std::size_t k = 0; k < bridge::kFigures; ++k) {
    EXPECT_EQ(out.values[k], static_cast<std::int64_t>(k));
    const auto base = static_cast<double>(10 * k);
    EXPECT_EQ(out.p50_us[k], base + 1);
    EXPECT_EQ(out.p99_us[k], base + 2);
    EXPECT_EQ(out.p999_us[k], base + 3);
    EXPECT_EQ(out.largest_us[k], base + 4);
  }
}

}  // namespace
}  // namespace glenoid::lcm_port
