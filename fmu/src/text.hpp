#pragma once

#include <array>
#include <charconv>
#include <cstddef>

namespace glenoid::fmu {

/// A message under construction: fixed size, no heap, independent of the locale; what does not fit is cut off.
class Text {
 public:
  Text& operator<<(const char* text) noexcept {
    while (*text != '\0' && used_ + 1 < buffer_.size()) buffer_[used_++] = *text++;
    buffer_[used_] = '\0';
    return *this;
  }

  Text& operator<<(double value) noexcept { return number(value); }
  Text& operator<<(int value) noexcept { return number(value); }
  Text& operator<<(unsigned value) noexcept { return number(value); }
  Text& operator<<(std::size_t value) noexcept { return number(value); }

  [[nodiscard]] const char* c_str() const noexcept { return buffer_.data(); }

 private:
  template <class Number>
  Text& number(Number value) noexcept {
    std::array<char, 40> digits{};
    std::to_chars(digits.data(), digits.data() + digits.size() - 1, value);
    return *this << digits.data();
  }

  std::array<char, 640> buffer_{};
  std::size_t used_ = 0;
};

}  // namespace glenoid::fmu
