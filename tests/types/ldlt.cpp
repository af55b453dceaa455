// Solutions by types/ldlt.cpp, and by Eigen, for random matrices of any rank: prints those whose bits differ.
#include "palpate/types/ldlt.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

namespace {

template <int n>
int differences(int count) {
  using Matrix = Eigen::Matrix<double, n, n>;
  using Vector = Eigen::Matrix<double, n, 1>;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<int> any_rank(0, n + 2);
  int found = 0;
  for (int trial = 0; trial < count; ++trial) {
    Matrix A = Matrix::Zero();
    for (int r = any_rank(random); r > 0; --r) {
      const Vector v = Vector::NullaryExpr([&] { return normal(random) * std::pow(10.0, normal(random)); });
      A += v * v.transpose();
    }
    if (trial % 2 == 1) A.diagonal().array() += 1e-3;
    if (trial % 7 == 0) {
      const int zero = trial / 7 % n;
      A.row(zero).setZero();
      A.col(zero).setZero();
    }
    const Vector b = Vector::NullaryExpr([&] { return normal(random); });
    const Vector eigen = A.ldlt().solve(b), own = palpate::solve_ldlt(A, b);
    const bool both_overflow = !eigen.allFinite() && !own.allFinite();
    if (!both_overflow && !(eigen.array() == own.array()).all()) ++found;
  }
  return found;
}

}  // namespace

int main(int, char** arguments) {
  const int count = std::atoi(arguments[1]);
  std::printf("%d %d\n", differences<3>(count), differences<6>(count));
}
