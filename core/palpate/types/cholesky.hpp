// Cholesky factorisation of small matrices as plain loops over a number of rows that the compiler knows: faster than
// Eigen's for the few rows of an arm, and cheap to compile.
#pragma once

#include <cmath>

namespace palpate {

/// A <- its lower factor L, with 1 / L_jj on the diagonal; the upper triangle is neither read nor written. False when
/// A is not positive definite; L is then useless.
template <int n>
bool cholesky(double (&A)[n][n]) noexcept {
  bool positive = true;
  for (int j = 0; j < n; ++j) {
    double d = A[j][j];
    for (int k = 0; k < j; ++k) d -= A[j][k] * A[j][k];
    positive &= d > 0.0;
    const double inverse = 1.0 / std::sqrt(d);
    A[j][j] = inverse;
    for (int i = j + 1; i < n; ++i) {
      double s = A[i][j];
      for (int k = 0; k < j; ++k) s -= A[i][k] * A[j][k];
      A[i][j] = s * inverse;
    }
  }
  return positive;
}

/// B <- L^-1 B, a row of B for each row of L.
template <int n, int columns>
void solve_lower(const double (&L)[n][n], double (&B)[n][columns]) noexcept {
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < i; ++k) {
      for (int c = 0; c < columns; ++c) B[i][c] -= L[i][k] * B[k][c];
    }
    for (int c = 0; c < columns; ++c) B[i][c] *= L[i][i];
  }
}

/// x <- A^-1 x, where L is A's factor.
template <int n>
void cholesky_solve(const double (&L)[n][n], double (&x)[n]) noexcept {
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < i; ++k) x[i] -= L[i][k] * x[k];
    x[i] *= L[i][i];
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int k = i + 1; k < n; ++k) x[i] -= L[k][i] * x[k];
    x[i] *= L[i][i];
  }
}

}  // namespace palpate
