#include "instance.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "bindings.hpp"

namespace glenoid::fmu {
namespace {

/// Communication points that differ by no more than this, relative to time and step, are the same point: importers add
/// steps up or multiply them.
constexpr double kTimeTolerance = 1e-9;

double time_tolerance(double a, double b, double step) noexcept {
  return kTimeTolerance * std::max({std::abs(a), std::abs(b), std::abs(step)});
}

/// A unit after a number; nothing for a variable without dimension.
struct Unit {
  const Variable& variable;
};

Text& operator<<(Text& text, const Unit& unit) noexcept {
  const std::string_view name = unit.variable.unit;
  if (!name.empty() && name != "1") text << " " << unit.variable.unit;
  return text;
}

}  // namespace

Outcome Instance::refuse(const char* function, const char* message) const {
  Text text;
  text << function << ": " << message;
  log_.write(Outcome::Discard, text.c_str());
  return Outcome::Discard;
}

Outcome Instance::fail(const char* function, const char* message) {
  state_.phase = Phase::Terminated;
  Text text;
  text << function << ": " << message;
  log_.write(Outcome::Error, text.c_str());
  return Outcome::Error;
}

void Instance::log_lines(Outcome outcome, const char* function, const std::string& lines) const {
  for (std::size_t begin = 0; begin < lines.size();) {
    const std::size_t end = std::min(lines.find('\n', begin), lines.size());
    if (end > begin) {
      Text text;
      text << function << ": " << lines.substr(begin, end - begin).c_str();
      log_.write(outcome, text.c_str());
    }
    begin = end + 1;
  }
}

Outcome Instance::read(const char* function, bool (*fits)(Kind), std::uint32_t reference, double& value) {
  const int index = index_of(reference);
  if (index < 0 || !fits(kVariables[static_cast<std::size_t>(index)].kind)) {
    Text text;
    text << "no variable of this type has the value reference " << reference;
    return fail(function, text.c_str());
  }
  const auto i = static_cast<std::size_t>(index);
  if (kVariables[i].causality == Causality::Output && !outputs_fresh_) {
    if (const std::string problems = build(); !problems.empty()) {
      log_lines(Outcome::Discard, function, problems);
      return Outcome::Discard;
    }
    sample_at(state_.time_s);
  }
  value = state_.values[i];
  return Outcome::Ok;
}

Outcome Instance::check(const char* function, bool (*fits)(Kind), std::uint32_t reference, double value) {
  const int index = index_of(reference);
  Text text;
  if (index < 0 || !fits(kVariables[static_cast<std::size_t>(index)].kind)) {
    text << "no variable of this type has the value reference " << reference;
    return fail(function, text.c_str());
  }
  const Variable& variable = kVariables[static_cast<std::size_t>(index)];
  if (variable.causality != Causality::Parameter && variable.causality != Causality::Input) {
    text << variable.name << ": only parameters and inputs can be set";
    return fail(function, text.c_str());
  }
  if (variable.variability == Variability::Fixed && state_.phase == Phase::Step) {
    text << variable.name << ": a fixed parameter can only be set before or in initialization";
    return fail(function, text.c_str());
  }
  text << variable.name << " = " << value << Unit{variable} << ": must ";
  if (!std::isfinite(value)) return refuse(function, (text << "be finite; nothing was set").c_str());
  if (value < variable.min || value > variable.max) {
    text << "lie in " << variable.min << " .. " << variable.max << Unit{variable} << "; nothing was set";
    return refuse(function, text.c_str());
  }
  return Outcome::Ok;
}

void Instance::assign(std::uint32_t reference, double value) {
  const auto i = static_cast<std::size_t>(index_of(reference));
  if (state_.values[i] == value) return;
  state_.values[i] = value;
  if (kVariables[i].causality == Causality::Input) {
    state_.inputs_changed = true;
  } else if (state_.phase != Phase::Step) {
    outputs_fresh_ = false;
  } else if (generator_->set_duration(value) != Status::Ok) {
    throw std::logic_error("the range of motion.duration differs from the core's");
  }
}

std::string Instance::build() {
  const bool same_duration = state_.phase == Phase::Step ||
                             built_from_[kMotionDuration] == state_.values[kMotionDuration];
  if (generator_.has_value() && same_duration && built_start_s_ == state_.start_time_s &&
      same_fixed_parameters(built_from_, state_.values)) {
    return {};
  }
  try {
    generator_.emplace(settings_from(state_.values), state_.start_time_s);
  } catch (const std::invalid_argument& problems) {
    generator_.reset();
    return problems.what();
  }
  built_from_ = state_.values;
  built_start_s_ = state_.start_time_s;
  return {};
}

void Instance::sample_at(double time_s) noexcept {
  state_.time_s = time_s;
  outputs_fresh_ = generator_->sample(time_s, sample_) == Status::Ok;
  if (outputs_fresh_) store(time_s, sample_, state_.values);
}

Outcome Instance::set_up(const char* function, double start_time_s, bool stop_defined, double stop_time_s) {
  Text text;
  if (!std::isfinite(start_time_s)) {
    text << "startTime = " << start_time_s << " s: must be finite";
    return refuse(function, text.c_str());
  }
  if (stop_defined && !(stop_time_s >= start_time_s)) {
    text << "stopTime = " << stop_time_s << " s: must not be before startTime = " << start_time_s << " s";
    return refuse(function, text.c_str());
  }
  state_.start_time_s = state_.time_s = state_.values[kTime] = start_time_s;
  state_.stop_defined = stop_defined;
  state_.stop_time_s = stop_defined ? stop_time_s : 0.0;
  outputs_fresh_ = false;
  return Outcome::Ok;
}

Outcome Instance::enter_initialization() {
  state_.phase = Phase::Initialization;
  return Outcome::Ok;
}

Outcome Instance::exit_initialization(const char* function) {
  if (const std::string problems = build(); !problems.empty()) {
    log_lines(Outcome::Error, function, problems);
    state_.phase = Phase::Terminated;
    return Outcome::Error;
  }
  sample_at(state_.start_time_s);
  state_.phase = Phase::Step;
  state_.inputs_changed = true;
  return Outcome::Ok;
}

Outcome Instance::terminate() noexcept {
  state_.phase = Phase::Terminated;
  return Outcome::Ok;
}

Outcome Instance::reset() noexcept {
  state_ = Snapshot{};
  generator_.reset();
  outputs_fresh_ = false;
  return Outcome::Ok;
}

Outcome Instance::do_step(const char* function, double time_s, double step_s) {
  Text text;
  if (!std::isfinite(time_s) || !std::isfinite(step_s) || !(step_s > 0.0)) {
    text << "communication point " << time_s << " s, step size " << step_s << " s: must be finite, the step > 0";
    return refuse(function, text.c_str());
  }
  const double tolerance = time_tolerance(time_s, state_.time_s, step_s);
  if (std::abs(time_s - state_.time_s) > tolerance) {
    text << "communication point " << time_s << " s: must be " << state_.time_s << " s, where the last step ended";
    return refuse(function, text.c_str());
  }
  const double end_s = time_s + step_s;
  if (state_.stop_defined && end_s > state_.stop_time_s + tolerance) {
    text << "the step ends at " << end_s << " s: must not pass the stop time " << state_.stop_time_s << " s";
    return fail(function, text.c_str());
  }
  if (!(end_s > time_s)) {
    text << "step size " << step_s << " s: too small to change the time " << time_s << " s";
    return refuse(function, text.c_str());
  }
  const double from_s = std::max(time_s, state_.time_s);
  if (generator_->command(from_s, command_from(state_.values)) != Status::Ok)
    return fail(function, "inputs not finite");
  if (std::exchange(state_.inputs_changed, false) && log_.on()) report_command(function, from_s);
  sample_at(end_s);
  return outputs_fresh_ ? Outcome::Ok : fail(function, "the motion cannot be evaluated");
}

void Instance::report_command(const char* function, double time_s) const {
  Text text;
  text << function << ": t = " << time_s << " s: ";
  if (generator_->message()[0] != '\0') {
    log_.write(Outcome::Warning, (text << generator_->message()).c_str());
    return;
  }
  if (generator_->state().moving == 0 || generator_->state().move_time_s != time_s) return;
  const Certificate& certificate = generator_->certificate();
  text << "movement accepted, energy " << generator_->path().energy << " kg.m2, " << certificate.iterations
       << " iterations";
  log_.write(Outcome::Ok, text.c_str());
  if (!certificate.limits.any) return;
  constexpr const char* kAngles[] = {"theta", "eta", "eta + zeta", "phi"};
  Text warning;
  warning << function << ": t = " << time_s << " s: the path leaves the "
          << (certificate.limits.worst.at_upper ? "upper" : "lower") << " limit of "
          << kAngles[certificate.limits.worst.angle] << " by " << -certificate.limits.worst.margin_rad
          << " rad at progress " << certificate.limits.lambda;
  log_.write(Outcome::Warning, warning.c_str());
}

Outcome Instance::output_derivatives(const char* function, const std::uint32_t* references, std::size_t count,
                                     const int* orders, double* values) {
  if (count > 0 && (references == nullptr || orders == nullptr || values == nullptr))
    return refuse(function, "null pointer");
  for (std::size_t i = 0; i < count; ++i) {
    double current = 0.0;  // refuses unknown references and samples in initialization
    const Outcome outcome = read(
        function, [](Kind kind) { return kind == Kind::Real; }, references[i], current);
    if (outcome != Outcome::Ok) return outcome;
    if (!output_derivative(sample_, index_of(references[i]), orders[i], values[i])) {
      Text text;
      text << kVariables[static_cast<std::size_t>(index_of(references[i]))].name << ", order " << orders[i]
           << ": only q and exo.q (orders 1, 2), dq and exo.dq (order 1) have derivatives";
      return refuse(function, text.c_str());
    }
  }
  return Outcome::Ok;
}

void Instance::save(Snapshot& out) const noexcept {
  out = state_;
  out.has_motion = generator_.has_value();
  if (out.has_motion) out.motion = generator_->state();
}

Outcome Instance::restore(const char* function, const Snapshot& snapshot) {
  const Snapshot before = state_;
  state_ = snapshot;
  const std::string problems = snapshot.has_motion ? build() : std::string();
  if (!problems.empty() || (snapshot.has_motion && generator_->restore(snapshot.motion) != Status::Ok)) {
    state_ = before;
    return fail(function, "the state does not belong to this FMU");
  }
  outputs_fresh_ = false;
  if (snapshot.has_motion)
    sample_at(snapshot.time_s);
  else
    generator_.reset();
  return Outcome::Ok;
}

}  // namespace glenoid::fmu
