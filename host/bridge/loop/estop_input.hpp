#pragma once

#include <cstddef>

namespace glenoid::bridge {

/// A file descriptor as an emergency stop: a pipe, a terminal, a GPIO character device.
///
/// '1' releases, anything else presses; the end of the file and errors press (a cut wire). A line end right behind '1' is
/// part of it. Starts released.
class EStopInput {
 public:
  /// @param descriptor  not owned; -1: none, never pressed
  explicit EStopInput(int descriptor) noexcept : descriptor_(descriptor) {}

  /// Reads what is there without waiting. Returns whether it is pressed, or was since the last call: a short press counts.
  bool poll() noexcept;

 private:
  int descriptor_;
  bool pressed_ = false;
  bool behind_release_ = false;
};

}  // namespace glenoid::bridge
