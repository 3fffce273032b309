#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/drives/parts.hpp"

namespace glenoid::drives {
namespace {

constexpr std::int64_t kCyclicPosition = 8;
constexpr std::uint16_t kHalt = 1U << 8U;
constexpr std::uint16_t kVoltage = 1U << 4U, kWarning = 1U << 7U, kTargetReached = 1U << 10U,
                        kInternalLimit = 1U << 11U, kFollows = 1U << 12U, kFollowingError = 1U << 13U;
constexpr std::int64_t kWindowOff = 0xFFFFFFFF;
constexpr std::uint16_t kFollowingErrorCode = 0x8611;
constexpr double kNs = 1e-9;

StopOptions stop_options(const Dictionary& objects) noexcept {
  return {objects.get(row_of(0x605A)), objects.get(row_of(0x605B)), objects.get(row_of(0x605C)),
          objects.get(row_of(0x605E))};
}

std::int64_t rounded(double value, Type type) noexcept {
  const auto low = static_cast<double>(lowest(type)), high = static_cast<double>(highest(type));
  return std::llround(std::clamp(value, low, high));  // first cut: what is beyond 64 bits cannot be rounded
}

}  // namespace

Motion::Motion(const Profile& profile, double position_rad) noexcept
    : mechanics_(profile.mechanics),
      enable_ns_(std::llround(profile.enable_s / kNs)),
      counts_per_rad_(profile.mechanics.counts_per_rev() / (2.0 * std::numbers::pi)),
      servo_(profile, position_rad) {}

void Motion::restart(Dictionary& objects) noexcept {
  power_.restart();
  power_.ready();
  servo_.disable();
  reference_.hold(servo_.measured());
  halted_ = fresh_ = limited_ = following_error_ = false;
  enable_at_ns_ = 0;
  mode_ = 0;
  publish(objects);
}

void Motion::advance(Dictionary& objects, std::int64_t now_ns, bool exactly) noexcept {
  if (servo_ns_ < 0) servo_ns_ = now_ns;
  while (now_ns - servo_ns_ >= kServoStep_ns) {
    step(objects, kServoStep_s);
    servo_ns_ += kServoStep_ns;
    if (enable_at_ns_ != 0 && servo_ns_ >= enable_at_ns_) {
      enable_at_ns_ = 0;
      apply(power_.enabled(), objects);
    }
  }
  if (exactly && now_ns > servo_ns_) {
    step(objects, static_cast<double>(now_ns - servo_ns_) * kNs);
    servo_ns_ = now_ns;
  }
}

void Motion::step(Dictionary& objects, double step_s) noexcept {
  reference_.advance(step_s);
  const double rated = mechanics_.rated_torque_Nm;
  const double per_mille = static_cast<double>(objects.get(row_of(0x6072)));
  servo_.limit_torque(std::min(mechanics_.peak_torque_Nm, per_mille * rated / 1000.0));
  const bool in_csp = follows();
  const double velocity_offset = in_csp ? static_cast<double>(objects.get(row_of(0x60B1))) / counts_per_rad_ : 0.0;
  const double torque_offset = in_csp ? static_cast<double>(objects.get(row_of(0x60B2))) * rated / 1000.0 : 0.0;
  servo_.step(reference_.position(), reference_.velocity() + velocity_offset, torque_offset, step_s);
  if (!power_.powered()) reference_.hold(servo_.measured());
  watch_following_error(objects, step_s);
  if (power_.powered() && reference_.at_rest()) apply(power_.settled(), objects);
}

void Motion::watch_following_error(Dictionary& objects, double step_s) noexcept {
  if (power_.state() != PowerState::OperationEnabled && power_.state() != PowerState::QuickStopActive) {
    error_time_s_ = 0.0;
    following_error_ = following_error_ && power_.faulty();
    return;
  }
  const double error = std::abs(following_error_rad());
  worst_error_rad_ = std::max(worst_error_rad_, error);
  const std::int64_t window = objects.get(row_of(0x6065));
  following_error_ = window != kWindowOff && error * counts_per_rad_ > static_cast<double>(window);
  error_time_s_ = following_error_ ? error_time_s_ + step_s : 0.0;
  if (error_time_s_ * 1000.0 > static_cast<double>(objects.get(row_of(0x6066)))) fail(objects, kFollowingErrorCode);
}

bool Motion::follows() const noexcept {
  return power_.state() == PowerState::OperationEnabled && mode_ == kCyclicPosition && !halted_ && !sync_lost_ && fresh_;
}

void Motion::control(Dictionary& objects, std::int64_t now_ns) noexcept {
  const auto word = static_cast<std::uint16_t>(objects.get(row_of(0x6040)));
  const bool was_fault = power_.state() == PowerState::Fault;
  const std::int64_t wanted = objects.get(row_of(0x6060));
  if (wanted == 0 || wanted == kCyclicPosition)
    mode_ = wanted;  // a PDO may ask for others: 6061h tells that they are not
  apply(power_.command(word, stop_options(objects)), objects);
  if (was_fault && power_.state() != PowerState::Fault) {
    was_reset_ = true;
    following_error_ = false;
    objects.set(row_of(0x603F), 0);
  }
  if (!power_.enabling()) {
    enable_at_ns_ = 0;
  } else if (enable_at_ns_ == 0) {
    enable_at_ns_ = now_ns + enable_ns_;
  }
  const bool halt = (word & kHalt) != 0;
  if (halt && !halted_ && power_.state() == PowerState::OperationEnabled) {
    const bool quick = objects.get(row_of(0x605D)) == 2;
    const std::int64_t deceleration = objects.get(quick ? row_of(0x6085) : row_of(0x6084));
    reference_.slow_down(static_cast<double>(std::max<std::int64_t>(deceleration, 1)) / counts_per_rad_);
  }
  halted_ = halt;
}

void Motion::apply(PowerEffect effect, const Dictionary& objects) noexcept {
  switch (effect) {
    case PowerEffect::None:
      return;
    case PowerEffect::Enable:
      if (power_.state() != PowerState::OperationEnabled) return;
      servo_.enable();
      reference_.hold(servo_.measured());
      fresh_ = false;
      return;
    case PowerEffect::Disable:
      servo_.disable();
      reference_.hold(servo_.measured());
      return;
    case PowerEffect::Stop:
      break;
  }
  double deceleration = mechanics_.peak_torque_Nm / mechanics_.inertia_kg_m2;
  if (power_.ramp() != StopRamp::CurrentLimit) {
    const std::int64_t counts = objects.get(power_.ramp() == StopRamp::QuickStop ? row_of(0x6085) : row_of(0x6084));
    deceleration = static_cast<double>(std::max<std::int64_t>(counts, 1)) / counts_per_rad_;
  }
  if (power_.state() == PowerState::FaultReaction) reference_.begin_at(servo_.measured(), servo_.measured_velocity());
  reference_.slow_down(deceleration);
}

void Motion::follow(Dictionary& objects) noexcept {
  if (power_.state() != PowerState::OperationEnabled || mode_ != kCyclicPosition || halted_) return;
  if (power_.stopping()) return;
  fresh_ = true;
  const std::int64_t target = objects.get(row_of(0x607A)) + objects.get(row_of(0x60B0));
  const std::int64_t low = objects.get(row_of(0x607D, 1)), high = objects.get(row_of(0x607D, 2));
  const std::int64_t inside = low <= high ? std::clamp(target, low, high) : target;
  const double counts_per_s = static_cast<double>(objects.get(row_of(0x607F)));
  const double most = std::min(mechanics_.max_speed_rad_per_s, counts_per_s / counts_per_rad_);
  const bool whole = reference_.go_to(static_cast<double>(inside) / counts_per_rad_, interpolation_period_s(objects),
                                      most);
  limited_ = inside != target || !whole;
}

void Motion::quick_stop(const Dictionary& objects) noexcept {
  apply(power_.quick_stop(stop_options(objects)), objects);
}

void Motion::disable_voltage(const Dictionary& objects) noexcept { apply(power_.disable_voltage(), objects); }

void Motion::fail(Dictionary& objects, std::uint16_t code) noexcept {
  if (power_.faulty()) return;
  objects.set(row_of(0x603F), code);
  fault_ = code;
  apply(power_.fault(stop_options(objects)), objects);
}

void Motion::set_link_bits(std::uint16_t bits, bool lost) noexcept {
  link_bits_ = bits;
  sync_lost_ = lost;
}

std::uint16_t Motion::take_fault() noexcept {
  const std::uint16_t code = fault_;
  fault_ = 0;
  return code;
}

bool Motion::take_reset() noexcept {
  const bool was = was_reset_;
  was_reset_ = false;
  return was;
}

std::uint16_t Motion::statusword(const Dictionary& objects) const noexcept {
  unsigned word = power_.status_bits() | link_bits_ | kVoltage;
  if (objects.get(row_of(0x1001)) != 0 && !power_.faulty()) word |= kWarning;
  const bool stops = power_.state() == PowerState::QuickStopActive || halted_;
  if (stops && power_.powered() && reference_.at_rest()) word |= kTargetReached;
  if (limited_ || servo_.saturated()) word |= kInternalLimit;
  if (follows()) word |= kFollows;
  if (following_error_) word |= kFollowingError;
  return static_cast<std::uint16_t>(word);
}

void Motion::publish(Dictionary& objects) const noexcept {
  const auto put = [&objects](std::size_t row, double value) {
    objects.set(row, rounded(value, kObjectTable[row].type));
  };
  objects.set(row_of(0x6041), statusword(objects));
  objects.set(row_of(0x6061), mode_);
  put(row_of(0x6062), reference_.position() * counts_per_rad_);
  put(row_of(0x6064), servo_.counts());
  put(row_of(0x606C), servo_.measured_velocity() * counts_per_rad_);
  put(row_of(0x6077), servo_.torque() * 1000.0 / mechanics_.rated_torque_Nm);
  put(row_of(0x60F4), following_error_rad() * counts_per_rad_);
}

double interpolation_period_s(const Dictionary& objects) noexcept {
  const std::int64_t value = objects.get(row_of(0x60C2, 1));
  if (value == 0) return kServoStep_s;  // no interpolation
  return static_cast<double>(value) * std::pow(10.0, static_cast<double>(objects.get(row_of(0x60C2, 2))));
}

}  // namespace glenoid::drives
