#pragma once

namespace glenoid::test {

/// Central difference of sixth order at 0. Error h^6 |f^(7)|/140 + about 1.2 eps |f|/h: below 1e-11 of f for arm
/// motions, whose shortest length is the smoothing of the rhythm (0.1 rad); f^(7) reaches 1e8 f there.
template <class Function>
auto derivative_at_zero(const Function& f, double h = 1e-3) {
  const auto difference = [&f, h](int k) { return (f(k * h) - f(-k * h)).eval(); };
  return ((45.0 * difference(1) - 9.0 * difference(2) + difference(3)) / (60.0 * h)).eval();
}

}  // namespace glenoid::test
