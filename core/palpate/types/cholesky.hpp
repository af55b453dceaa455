// Equations with small positive definite matrices. The loops run over a number of rows known at compile time: they are
// faster than Eigen's factorisation for the few rows of an arm, and they compile quickly.
#pragma once

namespace palpate {

/// x <- A^-1 x for a positive definite A, of which only the upper triangle is read; all of A is overwritten. The
/// factorisation is L D L^T, which needs no square roots. False when A is not positive definite; x is then useless.
template <int n>
inline bool solve_positive(double (&A)[n][n], double (&x)[n]) noexcept {
  bool positive = true;
  double inverse[n];
#pragma GCC unroll 8
  for (int j = 0; j < n; ++j) {
    positive &= A[j][j] > 0.0;
    inverse[j] = 1.0 / A[j][j];
#pragma GCC unroll 8
    for (int i = j + 1; i < n; ++i) {
      const double factor = A[j][i] * inverse[j];
      for (int k = i / 4 * 4; k < n; ++k) A[i][k] -= factor * A[j][k];  // whole groups of four
      x[i] -= factor * x[j];
    }
  }
#pragma GCC unroll 8
  for (int i = n - 1; i >= 0; --i) {  // the newest unknown last, so that the others need not wait for it
#pragma GCC unroll 8
    for (int k = n - 1; k > i; --k) x[i] -= A[i][k] * x[k];
    x[i] *= inverse[i];
  }
  return positive;
}

}  // namespace palpate
