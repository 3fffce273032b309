#include "kernels.hpp"

#include <array>
#include <cmath>

#include "glenoid/path.hpp"

namespace glenoid {
namespace {

using V4 [[gnu::vector_size(32)]] = double;

[[gnu::always_inline]] inline const V4& lanes(const double* p) { return *reinterpret_cast<const V4*>(p); }
[[gnu::always_inline]] inline V4& lanes(double* p) { return *reinterpret_cast<V4*>(p); }

/// Lanes at any address of a double.
using LooseV4 [[gnu::vector_size(32), gnu::aligned(8)]] = double;
[[gnu::always_inline]] inline const LooseV4& loose(const double* p) { return *reinterpret_cast<const LooseV4*>(p); }

/// T -= A B^T summed over `count` consecutive tiles of two rows.
[[gnu::always_inline]] inline void subtract_products(Tile& T, const Tile* A, const Tile* B, int count) {
  V4 t0 = lanes(T.c[0]), t1 = lanes(T.c[1]), t2 = lanes(T.c[2]), t3 = lanes(T.c[3]);
  for (int k = 0; k < count; ++k) {
    for (int p = 0; p < 4; ++p) {
      const V4 a = lanes(A[k].c[p]);
      const double* b = B[k].c[p];
      t0 -= a * b[0];
      t1 -= a * b[1];
      t2 -= a * b[2];
      t3 -= a * b[3];
    }
  }
  lanes(T.c[0]) = t0;
  lanes(T.c[1]) = t1;
  lanes(T.c[2]) = t2;
  lanes(T.c[3]) = t3;
}

/// Factors a diagonal tile; the reciprocals of its diagonal go to `inverse`.
[[gnu::always_inline]] inline bool factor_diagonal(Tile& T, double* inverse) {
  constexpr double kLeastPivot = 1e-14;  // kg.m2, of a matrix whose entries are of the order of the inertias
  for (int j = 0; j < 4; ++j) {
    double d = T.c[j][j];
    for (int k = 0; k < j; ++k) d -= T.c[k][j] * T.c[k][j];
    if (!(d > kLeastPivot)) return false;
    const double root = std::sqrt(d);
    T.c[j][j] = root;
    inverse[j] = 1.0 / root;
    for (int i = j + 1; i < 4; ++i) {
      double v = T.c[j][i];
      for (int k = 0; k < j; ++k) v -= T.c[k][i] * T.c[k][j];
      T.c[j][i] = v * inverse[j];
    }
  }
  return true;
}

/// T <- T L^-T for the lower-triangular tile L.
[[gnu::always_inline]] inline void solve_right(Tile& T, const Tile& L, const double* inverse) {
  for (int j = 0; j < 4; ++j) {
    V4 t = lanes(T.c[j]);
    for (int k = 0; k < j; ++k) t -= lanes(T.c[k]) * L.c[k][j];
    lanes(T.c[j]) = t * inverse[j];
  }
}

/// P_(n+1) = a x P_n - b P_(n-1)
struct Recurrence {
  double a, b;
};
constexpr auto kRecurrence = [] {
  std::array<Recurrence, kMaxPathOrder + 1> table{};
  for (int n = 0; n <= kMaxPathOrder; ++n)
    table[static_cast<std::size_t>(n)] = {(2.0 * n + 1.0) / (n + 1.0), n / (n + 1.0)};
  return table;
}();

}  // namespace

GLENOID_CPU_CLONES
void apply_mass(const double* mass, double turning, EmbeddedNode& node) noexcept {
  const auto m = [mass](int row, int col) { return mass[6 * col + row]; };
  const double m00 = m(0, 0), m03 = m(0, 3), m05 = m(0, 5), m33 = m(3, 3), m35 = m(3, 5), m55 = m(5, 5);
  const double m11 = m(1, 1), m22 = m(2, 2), m44 = m(4, 4);
  for (int r = 0; r < 3; ++r) {
    const V4 J0 = lanes(node.J[r]), J3 = lanes(node.J[9 + r]), J5 = lanes(node.J[15 + r]);
    lanes(node.MJ[r]) = J0 * m00 + J3 * m03 + J5 * m05;
    lanes(node.MJ[3 + r]) = lanes(node.J[3 + r]) * m11;
    lanes(node.MJ[6 + r]) = lanes(node.J[6 + r]) * m22;
    lanes(node.MJ[9 + r]) = J0 * m03 + J3 * m33 + J5 * m35;
    lanes(node.MJ[12 + r]) = lanes(node.J[12 + r]) * m44;
    lanes(node.MJ[15 + r]) = J0 * m05 + J3 * m35 + J5 * m55;
    const double F0 = node.F[r], F3 = node.F[9 + r], F5 = node.F[15 + r];
    node.MF[r] = F0 * m00 + F3 * m03 + F5 * m05;
    node.MF[3 + r] = node.F[3 + r] * m11;
    node.MF[6 + r] = node.F[6 + r] * m22;
    node.MF[9 + r] = F0 * m03 + F3 * m33 + F5 * m35;
    node.MF[12 + r] = node.F[12 + r] * m44;
    node.MF[15 + r] = F0 * m05 + F3 * m35 + F5 * m55;
  }
  if (turning == 0.0) return;
  for (int i = kColumns; i < kEmbedding; ++i) {
    lanes(node.MJ[i]) = lanes(node.J[i]) * turning;
    node.MF[i] = node.F[i] * turning;
  }
}

namespace {

template <int Rows>
[[gnu::always_inline]] inline void gram_row_of(const EmbeddedNode& row, const EmbeddedNode* nodes,
                                               const double* weights, int count, Tile* tiles) noexcept {
  for (int k = 0; k < count; ++k) {
    V4 t0{}, t1{}, t2{}, t3{};
    for (int i = 0; i < Rows; ++i) {
      const V4 a = lanes(row.J[i]);
      const double* b = nodes[k].MJ[i];
      t0 += a * b[0];
      t1 += a * b[1];
      t2 += a * b[2];
      t3 += a * b[3];
    }
    lanes(tiles[k].c[0]) = t0 * weights[k];
    lanes(tiles[k].c[1]) = t1 * weights[k];
    lanes(tiles[k].c[2]) = t2 * weights[k];
    lanes(tiles[k].c[3]) = t3 * weights[k];
  }
}

}  // namespace

GLENOID_CPU_CLONES
void gram_row(const EmbeddedNode& row, const EmbeddedNode* nodes, const double* weights, int count, bool turning,
              Tile* tiles) noexcept {
  if (turning) {
    gram_row_of<kEmbedding>(row, nodes, weights, count, tiles);
  } else {
    gram_row_of<kColumns>(row, nodes, weights, count, tiles);
  }
}

GLENOID_CPU_CLONES
void apply_to_nodes(const double* A, const double (*value)[kPadded], int count, double (*out)[kPadded]) noexcept {
  for (int k = 0; k < count; ++k) {
    V4 f0{}, f1{}, f2{}, f3{}, f4{};
    for (int j = 0; j < count; ++j) {
      const double w = A[k * count + j];
      const double* m = value[j];
      f0 += lanes(m) * w;
      f1 += lanes(m + 4) * w;
      f2 += lanes(m + 8) * w;
      f3 += lanes(m + 12) * w;
      f4 += lanes(m + 16) * w;
    }
    lanes(out[k]) = f0;
    lanes(out[k] + 4) = f1;
    lanes(out[k] + 8) = f2;
    lanes(out[k] + 12) = f3;
    lanes(out[k] + 16) = f4;
  }
}

GLENOID_CPU_CLONES
void legendre_series(const double* c, int order, double x, double (*out)[8]) noexcept {
  V4 v0 = loose(c), v1 = loose(c + 4), d0{}, d1{}, s0{}, s1{};
  double p = 1.0, dp = 0.0, sp = 0.0;  // P_(n-1) and derivatives
  double q = x, dq = 1.0, sq = 0.0;    // P_n
  for (int n = 1; n <= order; ++n) {
    const V4 c0 = loose(c + 8 * n), c1 = loose(c + 8 * n + 4);
    v0 += c0 * q, v1 += c1 * q;
    d0 += c0 * dq, d1 += c1 * dq;
    s0 += c0 * sq, s1 += c1 * sq;
    const Recurrence& r = kRecurrence[static_cast<std::size_t>(n)];
    const double next = r.a * x * q - r.b * p;
    const double dnext = dp + (2.0 * n + 1.0) * q;  // P'_(n+1) = P'_(n-1) + (2n+1) P_n
    const double snext = sp + (2.0 * n + 1.0) * dq;
    p = q, dp = dq, sp = sq;
    q = next, dq = dnext, sq = snext;
  }
  lanes(out[0]) = v0, lanes(out[0] + 4) = v1;
  lanes(out[1]) = d0, lanes(out[1] + 4) = d1;
  lanes(out[2]) = s0, lanes(out[2] + 4) = s1;
}

GLENOID_CPU_CLONES
void power_series(const double (*c)[4], int degree, double x, double (*out)[4]) noexcept {
  V4 value = lanes(c[degree]), d1{}, half_d2{};
  for (int k = degree - 1; k >= 0; --k) {
    half_d2 = half_d2 * x + d1;
    d1 = d1 * x + value;
    value = value * x + lanes(c[k]);
  }
  lanes(out[0]) = value;
  lanes(out[1]) = d1;
  lanes(out[2]) = half_d2 + half_d2;
}

GLENOID_CPU_CLONES
bool tiled_cholesky(Tile* A, int tiles) noexcept {
  double inverse[4 * 64];
  for (int i = 0; i < tiles; ++i) {
    Tile* row = A + tile_index(i, 0);
    for (int j = 0; j < i; ++j) {
      const Tile* pivot = A + tile_index(j, 0);
      subtract_products(row[j], row, pivot, j);
      solve_right(row[j], pivot[j], inverse + 4 * j);
    }
    subtract_products(row[i], row, row, i);
    if (!factor_diagonal(row[i], inverse + 4 * i)) return false;
  }
  return true;
}

GLENOID_CPU_CLONES
void tiled_solve(const Tile* L, int tiles, double* b) noexcept {
  for (int i = 0; i < tiles; ++i) {
    const Tile* row = L + tile_index(i, 0);
    double* x = b + 4 * i;
    V4 sum = lanes(x);
    for (int j = 0; j < i; ++j) {
      for (int c = 0; c < 4; ++c) sum -= lanes(row[j].c[c]) * b[4 * j + c];
    }
    lanes(x) = sum;
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < r; ++c) x[r] -= row[i].c[c][r] * x[c];
      x[r] /= row[i].c[r][r];
    }
  }
  for (int i = tiles - 1; i >= 0; --i) {
    const Tile* row = L + tile_index(i, 0);
    double* x = b + 4 * i;
    for (int r = 3; r >= 0; --r) {
      for (int c = r + 1; c < 4; ++c) x[r] -= row[i].c[r][c] * x[c];
      x[r] /= row[i].c[r][r];
    }
    const V4 solved = lanes(x);
    for (int j = 0; j < i; ++j) {
      for (int c = 0; c < 4; ++c) {
        const V4 p = lanes(row[j].c[c]) * solved;
        b[4 * j + c] -= (p[0] + p[1]) + (p[2] + p[3]);
      }
    }
  }
}

}  // namespace glenoid
