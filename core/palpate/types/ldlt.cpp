#include "palpate/types/ldlt.hpp"

#include "palpate/types/cholesky.hpp"

namespace palpate {
namespace {

constexpr int kRows = 6;

void solve(const Mat6& A, double (&x)[kRows]) noexcept {
  double factors[kRows][kRows];
  for (int i = 0; i < kRows; ++i) {
    for (int j = 0; j < kRows; ++j) factors[i][j] = A(i, j);
  }
  solve_positive(factors, x);
}

}  // namespace

Vec6 solve_ldlt(const Mat6& A, const Vec6& b) noexcept {
  Vec6 x = b;
  solve(A, *reinterpret_cast<double (*)[kRows]>(x.data()));
  return x;
}

void solve_ldlt(const Mat6& A, Jacobian& B) noexcept {
  for (Eigen::Index k = 0; k < B.cols(); ++k) solve(A, *reinterpret_cast<double (*)[kRows]>(B.data() + kRows * k));
}

}  // namespace palpate
