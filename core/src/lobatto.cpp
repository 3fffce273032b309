#include "lobatto.hpp"

#include <cmath>
#include <iterator>

namespace glenoid {
namespace {

/// P_N and its derivative at x by the three-term recurrence.
struct Legendre {
  double value, derivative;
};

Legendre legendre(int n, double x) {
  double p0 = 1.0, p1 = x;
  if (n == 0) return {1.0, 0.0};
  for (int k = 2; k <= n; ++k) {
    const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
    p0 = p1;
    p1 = p2;
  }
  const double d = std::abs(x) < 1.0 ? n * (p0 - x * p1) / (1.0 - x * x)
                                     : 0.5 * n * (n + 1) * (x > 0.0 || n % 2 == 1 ? 1.0 : -1.0);
  return {p1, d};
}

/// Interior nodes are the zeros of P_N'; Newton from the Chebyshev-Lobatto points.
std::vector<double> nodes_on_minus_one_one(int n) {
  std::vector<double> x(static_cast<std::size_t>(n) + 1);
  for (int k = 0; k <= n; ++k) {
    double t = -std::cos(kPi * k / n);
    for (int it = 0; it < 50 && k != 0 && k != n; ++it) {
      const Legendre p = legendre(n, t);
      const double second = (2.0 * t * p.derivative - n * (n + 1.0) * p.value) / (1.0 - t * t);
      const double step = p.derivative / second;
      t -= step;
      if (std::abs(step) < 1e-16) break;
    }
    x[static_cast<std::size_t>(k)] = t;
  }
  return x;
}

Lobatto make_table(int n) {
  const auto count = static_cast<std::size_t>(n) + 1;
  const std::vector<double> x = nodes_on_minus_one_one(n);
  Lobatto g;
  g.order = n;
  g.node.resize(count);
  g.weight.resize(count);
  g.stiffness.assign(count * count, 0.0);
  g.to_legendre.resize(count * count);
  std::vector<double>& D = g.derivative;
  D.assign(count * count, 0.0);
  std::vector<double> p(count);
  for (std::size_t k = 0; k < count; ++k) {
    p[k] = legendre(n, x[k]).value;
    g.node[k] = 0.5 * (x[k] + 1.0);
    g.weight[k] = 1.0 / (n * (n + 1.0) * p[k] * p[k]);
  }
  for (std::size_t i = 0; i < count; ++i) {
    double row = 0.0;
    for (std::size_t j = 0; j < count; ++j) {
      if (i != j) row += D[i * count + j] = 2.0 * p[i] / (p[j] * (x[i] - x[j]));
    }
    D[i * count + i] = -row;  // constants have derivative zero, exactly
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double s = 0.0;
      for (std::size_t k = 0; k < count; ++k) s += D[k * count + i] * g.weight[k] * D[k * count + j];
      g.stiffness[i * count + j] = g.stiffness[j * count + i] = s;
    }
  }
  for (std::size_t k = 0; k < count; ++k) {
    double p0 = 0.0, p1 = 1.0;  // P_(m-1), P_m at this node
    for (int m = 0; m <= n; ++m) {
      const double norm = m < n ? 2.0 * m + 1.0 : n;  // discrete norm of P_N on this grid is 2/N
      g.to_legendre[static_cast<std::size_t>(m) * count + k] = norm * g.weight[k] * p1;
      const double p2 = ((2 * m + 1) * x[k] * p1 - m * p0) / (m + 1);
      p0 = p1;
      p1 = p2;
    }
  }
  return g;
}

}  // namespace

const Lobatto& lobatto(int order) noexcept {
  static const std::vector<Lobatto> tables = [] {
    std::vector<Lobatto> all;
    for (const int n : kOrders) all.push_back(make_table(n));
    return all;
  }();
  for (const Lobatto& table : tables) {
    if (table.order >= order) return table;
  }
  return tables.back();
}

}  // namespace glenoid
