// Cholesky factorisation of small matrices. The loops run over a number of rows known at compile time: they are faster
// than Eigen's factorisation for the few rows of an arm, and they compile quickly.
#pragma once

#include <cmath>

namespace palpate {

/// Replaces A (n, n) by its lower Cholesky factor L. The diagonal stores 1 / L_jj; the upper triangle is neither read
/// nor written. Returns false when A is not positive definite; L is then invalid.
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

/// Replaces B (n, columns) by L^-1 B. L is the factor computed by cholesky().
template <int n, int columns>
void solve_lower(const double (&L)[n][n], double (&B)[n][columns]) noexcept {
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < i; ++k) {
      for (int c = 0; c < columns; ++c) B[i][c] -= L[i][k] * B[k][c];
    }
    for (int c = 0; c < columns; ++c) B[i][c] *= L[i][i];
  }
}

/// Replaces x (n,) by A^-1 x. L is the factor of A computed by cholesky().
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
