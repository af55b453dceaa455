#include "palpate/types/ldlt.hpp"

#include <Eigen/Cholesky>

namespace palpate {

Vec6 solve_ldlt(const Mat6& A, const Vec6& b) noexcept { return A.ldlt().solve(b); }

void solve_ldlt(const Mat6& A, Jacobian& B) noexcept {
  const Eigen::LDLT<Mat6> factors(A);
  for (Eigen::Index k = 0; k < B.cols(); ++k) B.col(k) = factors.solve(Vec6(B.col(k)));
}

}  // namespace palpate
