#pragma once

// What distinguishes one drive family from another: figures of its motor and the defaults of its object dictionary.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace glenoid::drives {

/// Index and sub-index of an object.
struct Address {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;

  friend auto operator<=>(const Address&, const Address&) = default;
};

/// A default that differs from the object table.
struct ObjectDefault {
  Address address;
  std::int64_t value = 0;
};

/// Motor, gear, joint and load, all seen at the joint.
struct Mechanics {
  std::uint32_t encoder_counts_per_motor_rev = 16384;
  std::uint32_t gear_ratio = 100;
  double inertia_kg_m2 = 0.15;  ///< of rotor, gear and link together
  double rated_torque_Nm = 30.0;
  double peak_torque_Nm = 60.0;  ///< the current limit
  double coulomb_friction_Nm = 1.0;
  double viscous_friction_Nm_s_per_rad = 0.5;
  double max_speed_rad_per_s = 4.0;
  double no_load_speed_ratio = 1.5;  ///< no-load speed over the greatest; the torque falls to nothing between the two
  bool brake = true;                 ///< holds the joint while the power stage is off
  double brake_torque_Nm = 40.0;     ///< while it slips
  double brake_delay_s = 0.03;       ///< to close, when power is lost in motion; a joint at rest is held before that

  /// Encoder counts of one turn of the joint.
  [[nodiscard]] double counts_per_rev() const noexcept {
    return static_cast<double>(encoder_counts_per_motor_rev) * static_cast<double>(gear_ratio);
  }
};

/// Cascade: position controller, velocity controller, torque limit.
struct Control {
  double position_bandwidth_rad_per_s = 60.0;
  double velocity_bandwidth_rad_per_s = 300.0;
  double integral_time_s = 0.05;    ///< of the velocity controller
  double velocity_filter_s = 5e-4;  ///< time constant of the velocity measured from the encoder
};

/// A drive family. A value; `Drive` copies what it needs.
struct Profile {
  std::string name = "nominal";
  std::string device_name = "Glenoid simulated drive";  ///< object 1008h
  Mechanics mechanics;
  Control control;
  double boot_s = 0.02;                ///< from power-up or reset to the boot-up message
  double enable_s = 0.01;              ///< from "enable operation" to torque
  bool dummy_mapping = true;           ///< objects 0002h..0007h may fill an RPDO
  int synchronised_bit = -1;           ///< bit of 6041h that says "in step with SYNC", -1 none
  int sync_lost_bit = -1;              ///< bit of 6041h that says "SYNC lost, interpolation stopped", -1 none
  std::vector<ObjectDefault> objects;  ///< defaults that differ
  std::vector<Address> absent;         ///< objects this family lacks; sub 0xFF means the whole index
};

/// Reads a profile file (host/drives/profiles).
/// @throws std::invalid_argument naming file, key, value and rule.
Profile load_profile(const std::filesystem::path& file);

}  // namespace glenoid::drives
