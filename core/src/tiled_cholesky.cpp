#include "tiled_cholesky.hpp"

#include <cmath>

namespace glenoid {
namespace {

using V4 [[gnu::vector_size(32)]] = double;

inline const V4& lanes(const double* p) { return *reinterpret_cast<const V4*>(p); }
inline V4& lanes(double* p) { return *reinterpret_cast<V4*>(p); }

/// T -= A B^T summed over `count` consecutive tiles of two rows.
void subtract_products(Tile& T, const Tile* A, const Tile* B, int count) {
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

bool factor_diagonal(Tile& T) {
  for (int j = 0; j < 4; ++j) {
    double d = T.c[j][j];
    for (int k = 0; k < j; ++k) d -= T.c[k][j] * T.c[k][j];
    if (!(d > 1e-14)) return false;
    const double root = std::sqrt(d);
    T.c[j][j] = root;
    const double inverse = 1.0 / root;
    for (int i = j + 1; i < 4; ++i) {
      double v = T.c[j][i];
      for (int k = 0; k < j; ++k) v -= T.c[k][i] * T.c[k][j];
      T.c[j][i] = v * inverse;
    }
  }
  return true;
}

/// T <- T L^-T for the lower-triangular tile L.
void solve_right(Tile& T, const Tile& L) {
  for (int j = 0; j < 4; ++j) {
    V4 t = lanes(T.c[j]);
    for (int k = 0; k < j; ++k) t -= lanes(T.c[k]) * L.c[k][j];
    lanes(T.c[j]) = t * (1.0 / L.c[j][j]);
  }
}

}  // namespace

bool tiled_cholesky(Tile* A, int tiles) noexcept {
  for (int i = 0; i < tiles; ++i) {
    Tile* row = A + tile_index(i, 0);
    for (int j = 0; j < i; ++j) {
      const Tile* pivot = A + tile_index(j, 0);
      subtract_products(row[j], row, pivot, j);
      solve_right(row[j], pivot[j]);
    }
    subtract_products(row[i], row, row, i);
    if (!factor_diagonal(row[i])) return false;
  }
  return true;
}

void tiled_solve(const Tile* L, int tiles, double* b) noexcept {
  for (int i = 0; i < tiles; ++i) {
    const Tile* row = L + tile_index(i, 0);
    double* x = b + 4 * i;
    for (int j = 0; j < i; ++j) {
      for (int c = 0; c < 4; ++c) {
        for (int r = 0; r < 4; ++r) x[r] -= row[j].c[c][r] * b[4 * j + c];
      }
    }
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
    for (int j = 0; j < i; ++j) {
      for (int c = 0; c < 4; ++c) {
        double sum = 0.0;
        for (int r = 0; r < 4; ++r) sum += row[j].c[c][r] * x[r];
        b[4 * j + c] -= sum;
      }
    }
  }
}

}  // namespace glenoid
