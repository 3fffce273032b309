#include "problems.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace glenoid {
namespace {

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9g", value);
  return text.data();
}

std::string in(std::string_view unit) { return unit == "1" ? std::string() : std::string(" ").append(unit); }

}  // namespace

void Problems::require(bool holds, std::string_view name, double value, std::string_view unit, std::string_view rule) {
  if (holds) return;
  if (!text_.empty()) text_ += '\n';
  text_.append(name).append(" = ").append(number(value)).append(in(unit)).append(": ").append(rule);
}

void Problems::require_positive(std::string_view name, double value, std::string_view unit) {
  require(std::isfinite(value) && value > 0.0, name, value, unit, "must be finite and above 0");
}

void Problems::require_range(std::string_view name, double value, double lower, double upper, std::string_view unit) {
  const std::string rule = "must be within " + number(lower) + " to " + number(upper) + in(unit);
  require(value >= lower && value <= upper, name, value, unit, rule);
}

void Problems::throw_if_any() const {
  if (!text_.empty()) throw std::invalid_argument(text_);
}

}  // namespace glenoid
