// Solves A x = b for symmetric positive definite A of six rows by a factorisation L D L^T. In plain loops, since
// Eigen's unrolled solver takes seven seconds to compile.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate {

/// x = A^-1 b. Without meaning where A is not positive definite.
[[nodiscard]] Vec6 solve_ldlt(const Mat6& A, const Vec6& b) noexcept;
/// Replaces every column of B (6, n) by A^-1 times that column.
void solve_ldlt(const Mat6& A, Jacobian& B) noexcept;

}  // namespace palpate
