#include "host/bridge/core/startup.hpp"

#include <algorithm>
#include <stdexcept>

#include "host/bridge/core/canopen.hpp"
#include "host/bridge/core/cia402.hpp"
#include "host/bridge/core/codec.hpp"
#include "host/bridge/core/pdo_table.hpp"

namespace glenoid::bridge {
namespace {

using Kind = StartupStep::Kind;

std::uint32_t ms(std::int64_t ns) { return static_cast<std::uint32_t>(ns / 1'000'000); }

std::uint32_t bits_of(std::int64_t value) { return static_cast<std::uint32_t>(value); }

StartupStep write(std::uint16_t index, std::uint8_t subindex, std::uint8_t bytes, std::uint32_t value,
                  std::string_view name, Kind kind = Kind::Write) {
  const std::uint32_t mask = bytes == 4 ? 0xFFFF'FFFFU : (1U << (8 * bytes)) - 1U;
  return {kind, index, subindex, bytes, value & mask, mask, name};
}

/// 60C2h: value times ten to the exponent, exactly the SYNC period.
struct InterpolationPeriod {
  std::uint8_t value;
  std::int8_t exponent;
};

InterpolationPeriod interpolation_period(std::int64_t period_ns) {
  std::int64_t value = period_ns;
  int exponent = -9;
  while (value % 10 == 0 && exponent < -3) {
    value /= 10;
    ++exponent;
  }
  if (value > 255) throw std::invalid_argument("SYNC period: does not fit 60C2h (at most 255 times a power of ten)");
  return {static_cast<std::uint8_t>(value), static_cast<std::int8_t>(exponent)};
}

void add_limits(std::vector<StartupStep>& steps, const JointSettings& joint) {
  const Scale scale(joint);
  const auto lower = scale.counts(joint.lower_rad - joint.measured_margin_rad);
  const auto upper = scale.counts(joint.upper_rad + joint.measured_margin_rad);
  const auto window = scale.window_counts(joint.following_window_rad);
  if (!lower || !upper || !window)
    throw std::invalid_argument(joint.name + ": limits or following window do not fit 32-bit counts");
  const auto [low, high] = std::minmax(*lower, *upper);  // a negative sign swaps them
  steps.push_back(write(0x6065, 0, 4, *window, "following error window"));
  steps.push_back(write(0x6066, 0, 2, ms(joint.following_time_ns), "following error time"));
  steps.push_back(write(0x607D, 1, 4, bits_of(low), "software position limit, lower"));
  steps.push_back(write(0x607D, 2, 4, bits_of(high), "software position limit, upper"));
}

/// A strict drive without remote frames refuses a TPDO whose bit 30 is clear, whether it is switched on or off.
std::uint32_t cob_id(const Pdo& pdo, std::uint8_t node) {
  return (pdo.cob_id + node) | (pdo.receive ? 0U : canopen::kCobNoRemote);
}

void add_pdo(std::vector<StartupStep>& steps, const Pdo& pdo, std::uint8_t node, std::uint8_t transmission) {
  const std::uint32_t own_id = cob_id(pdo, node);
  const std::uint8_t count = static_cast<std::uint8_t>(pdo.entries.size());
  // The order is CiA 301's: switch off, clear the mapping, fill it, count, type, switch on.
  steps.push_back(write(pdo.communication, 1, 4, own_id | canopen::kCobInvalid, "PDO off", Kind::WriteOnly));
  steps.push_back(write(pdo.mapping, 0, 1, 0, "PDO mapping cleared", Kind::WriteOnly));
  for (std::uint8_t k = 0; k < count; ++k)
    steps.push_back(write(pdo.mapping, static_cast<std::uint8_t>(k + 1), 4, pdo.entries[k].mapping(), "PDO mapping"));
  steps.push_back(write(pdo.mapping, 0, 1, count, "PDO mapping count"));
  steps.push_back(write(pdo.communication, 2, 1, transmission, "PDO transmission type"));
  if (!pdo.receive) {
    steps.push_back(write(pdo.communication, 3, 2, 0, "PDO inhibit time", Kind::WriteIfPresent));
    steps.push_back(write(pdo.communication, 5, 2, 0, "PDO event timer", Kind::WriteIfPresent));
  }
  StartupStep on = write(pdo.communication, 1, 4, own_id, "PDO on");
  on.mask = canopen::kCobInvalid | 0x7FFU;  // bit 30 is the drive's to report as it likes
  steps.push_back(on);
}

/// PDOs that the bridge does not use would only load the bus.
void add_unused_pdos(std::vector<StartupStep>& steps, std::uint8_t node, bool second_tpdo) {
  for (std::uint16_t k = 1; k < 4; ++k) {
    for (const Pdo& pdo : {kRpdo1, kTpdo1}) {
      if (second_tpdo && pdo.communication + k == kTpdo2.communication) continue;
      StartupStep off = write(static_cast<std::uint16_t>(pdo.communication + k), 1, 4,
                              (cob_id(pdo, node) + 0x100U * k) | canopen::kCobInvalid, "unused PDO off",
                              Kind::WriteIfPresent);
      off.mask = canopen::kCobInvalid;
      steps.push_back(off);
    }
  }
}

}  // namespace

std::vector<StartupStep> identity_steps(const JointSettings& joint) {
  std::vector<StartupStep> steps;
  steps.push_back({Kind::Check, 0x1000, 0, 4, cia402::kDeviceProfile, 0xFFFF, "device profile"});
  steps.push_back({Kind::Check, 0x1018, 1, 4, joint.vendor, joint.vendor != 0 ? 0xFFFF'FFFF : 0, "vendor"});
  steps.push_back({Kind::Check, 0x1018, 2, 4, joint.product, joint.product != 0 ? 0xFFFF'FFFF : 0, "product"});
  steps.push_back(
      {Kind::Check, 0x6502, 0, 4, cia402::kSupportsCsp, cia402::kSupportsCsp, "supported modes: cyclic position"});
  return steps;
}

std::vector<StartupStep> configuration_steps(const Settings& settings, const JointSettings& joint) {
  std::vector<StartupStep> steps;
  const std::uint32_t consumer = (static_cast<std::uint32_t>(settings.master_id) << 16) |
                                 ms(settings.consumer_heartbeat_ns);
  steps.push_back(write(0x1017, 0, 2, ms(settings.drive_heartbeat_ns), "heartbeat of the drive"));
  steps.push_back(write(kHeartbeatConsumer, 1, 4, consumer, "heartbeat of the master",
                        joint.may_lack_heartbeat_consumer ? Kind::WriteIfPresent : Kind::Write));
  steps.push_back(write(0x1029, 1, 1, 0, "on communication error: pre-operational"));
  steps.push_back(write(0x6007, 0, 2, 3, "on connection loss: quick stop"));
  steps.push_back(write(0x605A, 0, 2, bits_of(joint.quick_stop_option), "quick stop option"));
  steps.push_back(write(0x605E, 0, 2, bits_of(joint.fault_reaction), "fault reaction option"));
  add_limits(steps, joint);
  const InterpolationPeriod period = interpolation_period(settings.period_ns);
  steps.push_back(write(0x60C2, 1, 1, period.value, "interpolation period"));
  steps.push_back(write(0x60C2, 2, 1, bits_of(period.exponent), "interpolation period exponent"));
  steps.push_back(
      write(0x1006, 0, 4, static_cast<std::uint32_t>(settings.period_ns / 1000), "SYNC period", Kind::WriteIfPresent));
  for (const ExtraObject& object : joint.objects)
    steps.push_back(
        write(object.index, object.subindex, object.bytes, bits_of(object.value), "object of the configuration"));
  for (const Pdo& pdo : {kRpdo1, kTpdo1}) add_pdo(steps, pdo, joint.node, pdo.transmission);
  const bool second_tpdo = settings.second_tpdo_every > 0;
  if (second_tpdo) add_pdo(steps, kTpdo2, joint.node, settings.second_tpdo_every);
  add_unused_pdos(steps, joint.node, second_tpdo);
  steps.push_back(write(0x6060, 0, 1, cia402::kModeCsp, "mode of operation: cyclic position"));
  return steps;
}

}  // namespace glenoid::bridge
