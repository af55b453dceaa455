// Solves A x = b for symmetric positive semidefinite A of six rows by Eigen's LDLT. Compiled once: the unrolled solver
// takes several seconds in every file that instantiates it.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate {

/// x = A^-1 b. Not finite where A is singular.
[[nodiscard]] Vec6 solve_ldlt(const Mat6& A, const Vec6& b) noexcept;
/// Replaces every column of B (6, n) by A^-1 times that column.
void solve_ldlt(const Mat6& A, Jacobian& B) noexcept;

}  // namespace palpate
