#pragma once

#include <array>
#include <cstdint>

namespace glenoid::fmu {

enum class Kind : std::uint8_t { Real, Enumeration, Boolean };
enum class Causality : std::uint8_t { Independent, Parameter, Input, Output };
enum class Variability : std::uint8_t { Fixed, Tunable, Discrete, Continuous };

/// One row of the table that is generated from modelDescription.xml.
struct Variable {
  std::uint32_t reference;  ///< FMI value reference
  Kind kind;
  Causality causality;
  Variability variability;
  double start;  ///< 0 where the description has none
  double min;    ///< -infinity where the description has none
  double max;
  const char* name;
  const char* unit;  ///< "" for kinds without unit
};

}  // namespace glenoid::fmu

#include "variable_table.hpp"

namespace glenoid::fmu {

/// Current value of every variable, in the order of the table; enumerations and Booleans as whole numbers.
using Values = std::array<double, kVariables.size()>;

/// Index of a value reference in the table, or -1.
constexpr int index_of(std::uint32_t reference) noexcept {
  return reference < kIndexOfReference.size() ? kIndexOfReference[reference] : -1;
}

/// Start values of the description.
constexpr Values start_values() noexcept {
  Values values{};
  for (std::size_t i = 0; i < kVariables.size(); ++i) values[i] = kVariables[i].start;
  return values;
}

}  // namespace glenoid::fmu
