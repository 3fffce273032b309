#pragma once

#include <string>
#include <string_view>

namespace glenoid {

/// Collects every broken rule of an input, so that a user sees all of them at once. Start-up only: it allocates.
class Problems {
 public:
  /// Notes "name = value unit: rule" unless the rule holds; the unit "1" is not written.
  void require(bool holds, std::string_view name, double value, std::string_view unit, std::string_view rule);
  /// finite and > 0, as one rule.
  void require_positive(std::string_view name, double value, std::string_view unit);
  /// lower <= value <= upper; false for NaN.
  void require_range(std::string_view name, double value, double lower, double upper, std::string_view unit);

  [[nodiscard]] const std::string& text() const noexcept { return text_; }
  /// @throws std::invalid_argument with one line per problem, if there is one.
  void throw_if_any() const;

 private:
  std::string text_;
};

}  // namespace glenoid
