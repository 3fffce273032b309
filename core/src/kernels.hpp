#pragma once

#include "embedding.hpp"

/// Marks a function that is compiled twice, for AVX2 and for the baseline, and chosen when the library is loaded. Both give
/// the same bits: the operations and their order are those of the source, and nothing is contracted (-ffp-contract=off).
#if defined(__x86_64__) && defined(__linux__)
#define GLENOID_CPU_CLONES [[gnu::target_clones("avx2", "default")]]
#else
#define GLENOID_CPU_CLONES
#endif

namespace glenoid {

/// Symmetric matrix in 4x4 tiles, lower triangle only; tile (i, j), i >= j, at tile_index(i, j), column-major inside.
inline constexpr int tile_index(int i, int j) { return i * (i + 1) / 2 + j; }

struct alignas(32) Tile {
  double c[4][4];  ///< c[column][row]
};

inline constexpr int kPadded = 20;  ///< kEmbedding in whole lanes

/// MF and MJ of a node from F and J, with the 6x6 mass matrix of ArmModel, only its entries that can be non-zero, and the weight
/// of the turning feature.
void apply_mass(const double* mass, double turning, EmbeddedNode& node) noexcept;

/// tiles[k] = weights[k] * row.J^T * nodes[k].MJ for k < count: one row of the Gauss-Newton matrix.
void gram_row(const EmbeddedNode& row, const EmbeddedNode* nodes, const double* weights, int count, bool turning,
              Tile* tiles) noexcept;

/// out[k] = sum_j A[k, j] value[j] for k, j < count: stiffness or derivative of nodal values.
void apply_to_nodes(const double* A, const double (*value)[kPadded], int count, double (*out)[kPadded]) noexcept;

/// Value, first and second derivative with respect to x of eight Legendre series of degree `order` at x in [-1, 1];
/// coefficients of degree n at [8 n]; out[0..2] 32-byte aligned.
void legendre_series(const double* coefficients, int order, double x, double (*out)[8]) noexcept;

/// Value, first and second derivative with respect to x of four power series of degree `degree`; all 32-byte aligned.
void power_series(const double (*coefficients)[4], int degree, double x, double (*out)[4]) noexcept;

/// Factors A = L L^T in place. @return false if A is not positive definite (the content is then undefined).
bool tiled_cholesky(Tile* A, int tiles) noexcept;

/// Solves L L^T x = b in place for b of 4 * tiles numbers, 32-byte aligned.
void tiled_solve(const Tile* L, int tiles, double* b) noexcept;

}  // namespace glenoid
