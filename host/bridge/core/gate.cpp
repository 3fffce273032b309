#include "host/bridge/core/gate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace glenoid::bridge {
namespace {

constexpr std::int64_t kLatestStamp = std::int64_t{1} << 61;  // ns, 73 years
constexpr double kFastest = 1000.0;  // rad/s, ten times the highest limit: what is read between setpoints stays finite

}  // namespace

Gate::Gate(const Settings& settings) noexcept
    : joints_(settings.joints), max_age_ns_(settings.max_age_ns), max_lead_ns_(settings.max_lead_ns) {}

void Gate::open(std::int64_t session) noexcept {
  session_ = session;
  last_sequence_ = -1;
  conflicts_ = 0;
  history_.fill({});
}

Rejection Gate::refuse(Rejection reason, std::size_t joint, double value, double limit) noexcept {
  detail_ = {static_cast<std::int32_t>(joint), value, limit};
  return reason;
}

Rejection Gate::form(const Setpoint& setpoint) noexcept {
  const auto count = static_cast<std::int32_t>(joints_.size());
  if (setpoint.count != count) return Rejection::Count;
  if (setpoint.valid_mask != static_cast<std::int32_t>((1U << joints_.size()) - 1U)) return Rejection::Mask;
  // A stamp may be anything: differences of those that pass do not overflow.
  if (setpoint.time_ns > kLatestStamp) return Rejection::Future;
  if (setpoint.time_ns < 0) return Rejection::Age;
  if (setpoint.sequence < 0) return Rejection::Sequence;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const double v = setpoint.velocity_rad_per_s[j];
    for (const double value : {setpoint.position_rad[j], v, setpoint.effort_feedforward_Nm[j]})
      if (!std::isfinite(value)) return refuse(Rejection::NotFinite, j, value, 0.0);
    if (std::abs(v) > kFastest) return refuse(Rejection::Velocity, j, v, kFastest);
  }
  return Rejection::None;
}

Rejection Gate::order(const Setpoint& setpoint) noexcept {
  const auto* same = std::find_if(history_.begin(), history_.end(),
                                  [&](const Seen& seen) { return seen.sequence == setpoint.sequence; });
  const bool repeated = same != history_.end() && same->time_ns == setpoint.time_ns;
  if (setpoint.sequence <= last_sequence_) {
    // A repetition is harmless; another stamp under a used number, or a newer stamp under an older one, is another source.
    if (!repeated && (same != history_.end() || setpoint.time_ns > last_time_ns_)) ++conflicts_;
    return Rejection::Sequence;
  }
  return Rejection::None;
}

Rejection Gate::timing(const Setpoint& setpoint, std::int64_t now_ns, const ProducerClock& clock) noexcept {
  if (last_sequence_ >= 0 && setpoint.time_ns <= last_time_ns_) return Rejection::Age;
  const std::int64_t age_ns = now_ns - clock.local(setpoint.time_ns);
  if (age_ns > max_age_ns_) return Rejection::Age;
  if (-age_ns > max_lead_ns_) return Rejection::Future;
  return Rejection::None;
}

Rejection Gate::reach(const Setpoint& setpoint, const Command& command) noexcept {
  const double ahead_s = 1e-9 * static_cast<double>(std::max<std::int64_t>(0, setpoint.time_ns - command.stamp_ns));
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const JointSettings& joint = joints_[j];
    const double q = setpoint.position_rad[j];
    const double v = setpoint.velocity_rad_per_s[j];
    const double from = command.position_rad[j];
    const double step = std::abs(q - from);
    if (!command.moving && step > joint.start_window_rad)
      return refuse(Rejection::StartDistance, j, step, joint.start_window_rad);
    const double apart = command.joining ? std::max(joint.step_rad, joint.start_window_rad) : joint.step_rad;
    const double reachable = apart + ahead_s * joint.velocity_rad_per_s;
    if (command.moving && step > reachable) return refuse(Rejection::Step, j, step, reachable);
    if (joint.on_limit == OnLimit::Clamp) continue;  // the limiter brings it inside and counts
    if (q < std::min(joint.lower_rad, from)) return refuse(Rejection::Position, j, q, joint.lower_rad);
    if (q > std::max(joint.upper_rad, from)) return refuse(Rejection::Position, j, q, joint.upper_rad);
    if (std::abs(v) > joint.velocity_rad_per_s) return refuse(Rejection::Velocity, j, v, joint.velocity_rad_per_s);
  }
  return Rejection::None;
}

Rejection Gate::check(const Setpoint& setpoint, std::int64_t now_ns, const Command& command,
                      ProducerClock& clock) noexcept {
  detail_ = {};
  if (session_ == 0) return Rejection::NotArmed;
  if (const Rejection reason = form(setpoint); reason != Rejection::None) return reason;
  if (setpoint.session != session_) return Rejection::Session;
  if (const Rejection reason = order(setpoint); reason != Rejection::None) return reason;
  if (!any()) clock.observe(setpoint.time_ns, setpoint.arrival_ns != 0 ? setpoint.arrival_ns : now_ns);
  if (const Rejection reason = timing(setpoint, now_ns, clock); reason != Rejection::None) return reason;
  if (const Rejection reason = reach(setpoint, command); reason != Rejection::None) return reason;
  if (any()) clock.observe(setpoint.time_ns, setpoint.arrival_ns != 0 ? setpoint.arrival_ns : now_ns);
  last_sequence_ = setpoint.sequence;
  last_time_ns_ = setpoint.time_ns;
  history_[next_] = {setpoint.sequence, setpoint.time_ns};
  next_ = (next_ + 1) % kHistory;
  return Rejection::None;
}

}  // namespace glenoid::bridge
