#include "palpate/types/inverse.hpp"

#include <cmath>
#include <utility>

namespace palpate {
namespace {

constexpr double kSmallestDeterminant = 1e-9;

}  // namespace

std::optional<JointMatrix> inverse(JointMatrix A) {
  const Eigen::Index n = A.rows();
  if (A.cols() != n) return std::nullopt;
  JointMatrix B = JointMatrix::Identity(n, n);
  double determinant = 1.0;
  for (Eigen::Index j = 0; j < n; ++j) {
    Eigen::Index pivot = j;
    for (Eigen::Index i = j + 1; i < n; ++i) pivot = std::abs(A(i, j)) > std::abs(A(pivot, j)) ? i : pivot;
    const double scale = A(pivot, j);
    determinant *= scale;
    for (Eigen::Index k = 0; k < n; ++k) {
      std::swap(A(j, k), A(pivot, k));
      std::swap(B(j, k), B(pivot, k));
      A(j, k) /= scale;
      B(j, k) /= scale;
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      const double factor = i == j ? 0.0 : A(i, j);
      for (Eigen::Index k = 0; k < n; ++k) {
        A(i, k) -= factor * A(j, k);
        B(i, k) -= factor * B(j, k);
      }
    }
  }
  if (!(std::abs(determinant) >= kSmallestDeterminant)) return std::nullopt;  // also where an entry is NaN
  return B;
}

}  // namespace palpate
