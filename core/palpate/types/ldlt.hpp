// Solves A x = b for symmetric positive semidefinite A of three or six rows by the factorisation L D L^T with pivots.
// The loops give Eigen's LDLT bit by bit and compile in a fraction of its time.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate {

/// x = A^-1 b, of which only the lower triangle of A is read. Zero along pivots of zero.
[[nodiscard]] Vec3 solve_ldlt(const Mat3& A, const Vec3& b) noexcept;
[[nodiscard]] Vec6 solve_ldlt(const Mat6& A, const Vec6& b) noexcept;
/// Replaces every column of B (6, n) by A^-1 times that column.
void solve_ldlt(const Mat6& A, Jacobian& B) noexcept;

}  // namespace palpate
