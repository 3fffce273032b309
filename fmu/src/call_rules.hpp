#pragma once

#include <array>
#include <cstdint>

namespace glenoid::fmu {

/// States of the two standards' state machines for co-simulation that differ in what may be called.
enum class Phase : std::uint8_t { Instantiated = 0, Initialization = 1, Step = 2, Terminated = 3 };

/// Calls with a rule of their own; functions of both standards that mean the same share one.
enum class Call : std::uint8_t {
  SetDebugLogging,
  SetUp,
  EnterInitialization,
  ExitInitialization,
  Terminate,
  Reset,
  Get,
  Set,
  State,
  DoStep,
  OutputDerivatives,
  StepStatus,
  Unsupported,
};

struct CallRule {
  Call call;
  std::uint8_t phases;  ///< bit set of the phases in which the call is allowed
};

constexpr std::uint8_t phase_bit(Phase phase) noexcept {
  return static_cast<std::uint8_t>(1U << static_cast<unsigned>(phase));
}

/// FMI 2.0.5 section 4.2.4 and FMI 3.0.2 section 2.2.2, opened where importers are known to be looser and nothing can go
/// wrong: values may be set and read before initialization, and an instance may be terminated before its first step.
constexpr auto kCallRules = [] {
  constexpr std::uint8_t i = phase_bit(Phase::Instantiated), n = phase_bit(Phase::Initialization),
                         s = phase_bit(Phase::Step), t = phase_bit(Phase::Terminated);
  constexpr std::uint8_t all = i | n | s | t;
  return std::array<CallRule, 13>{{
      {Call::SetDebugLogging, all},
      {Call::SetUp, i},
      {Call::EnterInitialization, i},
      {Call::ExitInitialization, n},
      {Call::Terminate, i | n | s},
      {Call::Reset, all},
      {Call::Get, all},
      {Call::Set, i | n | s},
      {Call::State, all},
      {Call::DoStep, s},
      {Call::OutputDerivatives, n | s | t},
      {Call::StepStatus, s | t},
      {Call::Unsupported, 0},
  }};
}();

constexpr bool allowed(Call call, Phase phase) noexcept {
  return (kCallRules[static_cast<std::size_t>(call)].phases & phase_bit(phase)) != 0;
}

constexpr const char* to_string(Phase phase) noexcept {
  constexpr std::array<const char*, 4> names = {"Instantiated", "Initialization Mode", "Step Mode", "Terminated"};
  return names[static_cast<std::size_t>(phase)];
}

static_assert(
    [] {
      for (std::size_t k = 0; k < kCallRules.size(); ++k) {
        if (static_cast<std::size_t>(kCallRules[k].call) != k) return false;
      }
      return true;
    }(),
    "the rules are listed in the order of Call");

}  // namespace glenoid::fmu
