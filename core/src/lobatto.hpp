#pragma once

#include <vector>

#include "glenoid/path.hpp"

namespace glenoid {

/// Constant tables of one Legendre-Gauss-Lobatto grid on lambda in [0, 1] (docs/equations.md, G1).
struct Lobatto {
  int order = 0;                    ///< N; N + 1 nodes
  std::vector<double> node;         ///< in [0, 1]
  std::vector<double> weight;       ///< sum 1
  std::vector<double> derivative;   ///< D, row-major (N+1)^2, d/dlambda of the interpolant at the nodes
  std::vector<double> stiffness;    ///< S = D^T W D, row-major (N+1)^2
  std::vector<double> to_legendre;  ///< nodal values -> Legendre coefficients, row-major (N+1)^2
};

/// Grids in the order of refinement.
inline constexpr int kOrders[] = {6, 8, 12, 16, 20, 24, 32, 40, 48, 64};

/// Table of one of kOrders; built once, then shared and constant.
const Lobatto& lobatto(int order) noexcept;

}  // namespace glenoid
