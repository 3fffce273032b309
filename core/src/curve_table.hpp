#pragma once

#include <functional>
#include <vector>

#include "glenoid/types.hpp"

namespace glenoid {

/// A point of a space curve and its first two derivatives with respect to the curve's parameter.
struct CurveJet {
  Vec3 x, d1, d2;
};

/// A curve over c in [-1, 1] as piecewise polynomials: value and two derivatives of an expensive smooth curve for the price
/// of one short Horner scheme (docs/equations.md, R6). Panels shrink towards both ends, where curves over c = cos(theta)
/// are steepest.
class CurveTable {
 public:
  using Curve = std::function<CurveJet(double)>;

  /// @param scale  1 - c below which the curve is well approximated by one polynomial; 0 < scale < 1
  CurveTable(double scale, const Curve& curve);

  /// @return false, `out` unchanged, where the table does not reach: next to c = -1, and NaN. @alloc none
  bool evaluate(double c, CurveJet& out) const noexcept;

 private:
  static constexpr int kDegree = 11;
  struct alignas(32) Panel {
    double a[kDegree + 1][4];   ///< coefficients of powers of (v - middle) / half width; coordinates in lanes
    double middle, reciprocal;  ///< of v, the distance of c from its end; 1 / half width
  };
  /// Panels over the distance v from one end of [-1, 1], for v <= 1.
  struct Side {
    double end = 1.0;  ///< c = end (1 - v)
    int first = 0;     ///< key(v) of panels[0]
    std::vector<Panel> panels;
  };
  static int key(double v) noexcept;
  static Panel fit(double low, double high, double end, const Curve& curve);
  static void fill(Side& side, double least, const Curve& curve);

  Side hanging_, raised_;
  Panel tip_;  ///< from c = 1 to the first panel of hanging_
};

}  // namespace glenoid
