#pragma once

namespace glenoid {

/// Symmetric matrix in 4x4 tiles, lower triangle only; tile (i, j), i >= j, at tile_index(i, j), column-major inside.
inline constexpr int tile_index(int i, int j) { return i * (i + 1) / 2 + j; }

struct alignas(32) Tile {
  double c[4][4];  ///< c[column][row]
};

/// Factors A = L L^T in place. @return false if A is not positive definite (the content is then undefined).
bool tiled_cholesky(Tile* A, int tiles) noexcept;

/// Solves L L^T x = b in place for b of 4 * tiles numbers.
void tiled_solve(const Tile* L, int tiles, double* b) noexcept;

}  // namespace glenoid
