#include "palpate/types/ldlt.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace palpate {
namespace {

/// P A P^T = L D L^T, each pivot the largest diagonal entry that is left.
template <int n>
class Ldlt {
 public:
  /// A: (n, n), column by column.
  explicit Ldlt(const double* A) noexcept {
    for (int j = 0; j < n; ++j) {
      for (int i = j; i < n; ++i) L_[i][j] = A[j * n + i];
    }
    for (int k = 0; k < n; ++k) {
      swap_[k] = largest(k);
      if (swap_[k] != k) exchange(k, swap_[k]);
      eliminate(k);
    }
  }

  /// x <- A^-1 x.
  void solve(double* x) const noexcept {
    for (int k = 0; k < n; ++k) std::swap(x[k], x[swap_[k]]);
    for (int i = 1; i < n; ++i) {
      Terms terms{};
      for (int k = 0; k < i; ++k) terms[k] = L_[i][k] * x[k];
      x[i] -= sum(terms, i);
    }
    for (int i = 0; i < n; ++i) x[i] = std::abs(L_[i][i]) > kZero ? x[i] / L_[i][i] : 0.0;
    for (int count = 1; count < n; ++count) {
      const int i = n - 1 - count;
      Terms terms{};
      for (int k = 0; k < count; ++k) terms[k] = L_[i + 1 + k][i] * x[i + 1 + k];
      x[i] -= sum_abreast(terms, count);
    }
    for (int k = n - 1; k >= 0; --k) std::swap(x[k], x[swap_[k]]);
  }

 private:
  static constexpr double kZero = std::numeric_limits<double>::min();  // a pivot up to here counts as zero

  // Products whose sum is taken. The loops over them have bounds that every compiler can follow.
  static constexpr int kTerms = 5;
  static_assert(n <= kTerms + 1);
  using Terms = double[kTerms];

  /// The sum of the first `count` terms, half by half.
  static double sum(const Terms& t, int count) noexcept {
    switch (count) {
      case 1:
        return t[0];
      case 2:
        return t[0] + t[1];
      case 3:
        return t[0] + (t[1] + t[2]);
      case 4:
        return (t[0] + t[1]) + (t[2] + t[3]);
      default:
        return (t[0] + t[1]) + (t[2] + (t[3] + t[4]));
    }
  }

  /// The same in the order of vectors of two: even terms, plus odd terms, plus the last of an odd number of terms.
  static double sum_abreast(const Terms& t, int count) noexcept {
    const int pairs = count / 2;
    if (pairs == 0) return t[0];
    Terms even{}, odd{};
    for (int i = 0; i < pairs; ++i) even[i] = t[2 * i], odd[i] = t[2 * i + 1];
    const double s = sum(even, pairs) + sum(odd, pairs);
    return count % 2 == 0 ? s : s + t[count - 1];
  }

  [[nodiscard]] int largest(int k) const noexcept {
    int best = k;
    for (int i = k + 1; i < n; ++i) {
      if (std::abs(L_[i][i]) > std::abs(L_[best][best])) best = i;
    }
    return best;
  }

  /// Exchanges rows and columns k < m of the lower triangle.
  void exchange(int k, int m) noexcept {
    std::swap_ranges(L_[k], L_[k] + k, L_[m]);
    for (int i = m + 1; i < n; ++i) std::swap(L_[i][k], L_[i][m]);
    std::swap(L_[k][k], L_[m][m]);
    for (int i = k + 1; i < m; ++i) std::swap(L_[i][k], L_[m][i]);
  }

  void eliminate(int k) noexcept {
    double scaled[n] = {};  // row k of L D
    for (int j = 0; j < k; ++j) scaled[j] = L_[j][j] * L_[k][j];
    for (int i = k; k > 0 && i < n; ++i) {
      double s = L_[i][0] * scaled[0];
      for (int j = 1; j < k; ++j) s += L_[i][j] * scaled[j];
      L_[i][k] -= s;
    }
    if (!(std::abs(L_[k][k]) > 0.0)) return;
    for (int i = k + 1; i < n; ++i) L_[i][k] /= L_[k][k];
  }

  double L_[n][n] = {};  ///< below the diagonal L, on it D
  int swap_[n] = {};     ///< row that was exchanged with row k
};

}  // namespace

Vec3 solve_ldlt(const Mat3& A, const Vec3& b) noexcept {
  Vec3 x = b;
  Ldlt<3>(A.data()).solve(x.data());
  return x;
}

Vec6 solve_ldlt(const Mat6& A, const Vec6& b) noexcept {
  Vec6 x = b;
  Ldlt<6>(A.data()).solve(x.data());
  return x;
}

void solve_ldlt(const Mat6& A, Jacobian& B) noexcept {
  const Ldlt<6> factors(A.data());
  for (Eigen::Index k = 0; k < B.cols(); ++k) factors.solve(B.data() + 6 * k);
}

}  // namespace palpate
