#pragma once

// Messages of the wire to those of the core and back. Nothing else of the bridge knows the types of LCM.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "glenoid/command_v1_t.hpp"
#include "glenoid/device_v1_t.hpp"
#include "glenoid/event_v1_t.hpp"
#include "glenoid/feedback_v1_t.hpp"
#include "glenoid/figures_v1_t.hpp"
#include "glenoid/setpoint_v1_t.hpp"
#include "glenoid/status_v1_t.hpp"
#include "host/bridge/core/messages.hpp"

namespace glenoid::lcm_port {

/// What GLENOID_STATUS and GLENOID_DEVICE say beside what the core knows. Of names at most 31 bytes are told.
struct Device {
  std::string exoskeleton{};
  std::string config_sha256{};
  std::string device{}, device_sha256{};  ///< that the configuration was made for; empty: not said
  std::int32_t side = device_v1_t::RIGHT;
  std::vector<std::string> joint_names{};
  bridge::JointValues lower_rad{}, upper_rad{};
  std::int64_t period_ns = 0;      ///< of SYNC
  std::int32_t real_bus_mask = 0;  ///< bit b: frames of bus b may reach hardware
  bridge::JointValues velocity_limit_rad_per_s{};
  bridge::JointValues acceleration_limit_rad_per_s2{};
};

/// Every value is taken as it is, NaN and wrong counts included: judging them is the core's gate.
[[nodiscard]] bridge::Setpoint to_core(const setpoint_v1_t& message) noexcept;
/// Empty where the request is none of the constants.
[[nodiscard]] std::optional<bridge::Command> to_core(const command_v1_t& message) noexcept;

[[nodiscard]] feedback_v1_t to_wire(const bridge::Feedback& feedback, bridge::State state) noexcept;
[[nodiscard]] event_v1_t to_wire(const bridge::Event& event) noexcept;
[[nodiscard]] figures_v1_t to_wire(const bridge::Figures& figures) noexcept;
/// @param time_utc_ns  wall clock at the instant of the status
[[nodiscard]] status_v1_t to_wire(const bridge::Status& status, const Device& device, std::int64_t time_utc_ns) noexcept;

[[nodiscard]] device_v1_t to_wire(const Device& device, std::int64_t time_ns) noexcept;

}  // namespace glenoid::lcm_port
