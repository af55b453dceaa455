// Arithmetic of vectors of three and matrices of three by three, spelt out. Eigen builds a type for each expression and
// about a hundred functions for each type, which took most of the time of compilation. These operators are exact
// matches for Vector3d and Matrix3d and return values, and the members are specialisations: the code that uses them
// looks the same. They add and multiply in Eigen's order, so that results are the same to the last bit (tests/types).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <concepts>
#include <type_traits>
#include <utility>

namespace Eigen {

template <class T>
concept PalpateVector = std::same_as<T, Vector3d>;
template <class T>
concept PalpateMatrix = std::same_as<T, Matrix3d>;
template <class T>
concept PalpateTransposed = std::same_as<T, Transpose<Matrix3d>> || std::same_as<T, Transpose<const Matrix3d>>;
template <class T>
concept PalpateNumber = std::is_arithmetic_v<T>;

#define PALPATE_ALWAYS [[gnu::always_inline]] inline

// Vectors

template <PalpateVector V>
PALPATE_ALWAYS V operator+(const V& a, const V& b) noexcept {
  const double *x = a.data(), *y = b.data();
  return {x[0] + y[0], x[1] + y[1], x[2] + y[2]};
}
template <PalpateVector V>
PALPATE_ALWAYS V operator-(const V& a, const V& b) noexcept {
  const double *x = a.data(), *y = b.data();
  return {x[0] - y[0], x[1] - y[1], x[2] - y[2]};
}
template <PalpateVector V>
PALPATE_ALWAYS V operator-(const V& a) noexcept {
  const double* x = a.data();
  return {-x[0], -x[1], -x[2]};
}
template <PalpateVector V, PalpateNumber S>
PALPATE_ALWAYS V operator*(const V& a, const S& s) noexcept {
  const double *x = a.data(), y = static_cast<double>(s);
  return {x[0] * y, x[1] * y, x[2] * y};
}
template <PalpateVector V, PalpateNumber S>
PALPATE_ALWAYS V operator*(const S& s, const V& a) noexcept {
  const double *x = a.data(), y = static_cast<double>(s);
  return {y * x[0], y * x[1], y * x[2]};
}
template <PalpateVector V, PalpateNumber S>
PALPATE_ALWAYS V operator/(const V& a, const S& s) noexcept {
  const double *x = a.data(), y = static_cast<double>(s);
  return {x[0] / y, x[1] / y, x[2] / y};
}
template <PalpateVector V>
PALPATE_ALWAYS V& operator+=(V& a, const V& b) noexcept {
  double* x = a.data();
  const double* y = b.data();
  x[0] += y[0], x[1] += y[1], x[2] += y[2];
  return a;
}
template <PalpateVector V>
PALPATE_ALWAYS V& operator-=(V& a, const V& b) noexcept {
  double* x = a.data();
  const double* y = b.data();
  x[0] -= y[0], x[1] -= y[1], x[2] -= y[2];
  return a;
}

// Matrices, stored by columns

template <PalpateMatrix M, PalpateVector V>
PALPATE_ALWAYS V operator*(const M& a, const V& b) noexcept {
  const double *A = a.data(), *x = b.data();
  return {(A[0] * x[0] + A[3] * x[1]) + A[6] * x[2], (A[1] * x[0] + A[4] * x[1]) + A[7] * x[2],
          A[2] * x[0] + (A[5] * x[1] + A[8] * x[2])};
}
template <PalpateTransposed T, PalpateVector V>
PALPATE_ALWAYS V operator*(const T& a, const V& b) noexcept {
  const double *A = a.nestedExpression().data(), *x = b.data();
  return {(A[0] * x[0] + A[1] * x[1]) + A[2] * x[2], (A[3] * x[0] + A[4] * x[1]) + A[5] * x[2],
          (A[6] * x[0] + A[7] * x[1]) + A[8] * x[2]};
}
template <PalpateMatrix M>
PALPATE_ALWAYS M operator*(const M& a, const M& b) noexcept {
  M out;
  const double *A = a.data(), *B = b.data();
  double* C = out.data();
#define PALPATE_COLUMN(c)                                       \
  C[c] = (A[0] * B[c] + A[3] * B[c + 1]) + A[6] * B[c + 2];     \
  C[c + 1] = (A[1] * B[c] + A[4] * B[c + 1]) + A[7] * B[c + 2]; \
  C[c + 2] = A[2] * B[c] + (A[5] * B[c + 1] + A[8] * B[c + 2])
  PALPATE_COLUMN(0);
  PALPATE_COLUMN(3);
  PALPATE_COLUMN(6);
#undef PALPATE_COLUMN
  return out;
}

template <PalpateTransposed T, PalpateMatrix M>
PALPATE_ALWAYS M operator*(const T& a, const M& b) noexcept {
  M out;
  const double *A = a.nestedExpression().data(), *B = b.data();
  double* C = out.data();
#define PALPATE_COLUMN(c)                                       \
  C[c] = (A[0] * B[c] + A[1] * B[c + 1]) + A[2] * B[c + 2];     \
  C[c + 1] = (A[3] * B[c] + A[4] * B[c + 1]) + A[5] * B[c + 2]; \
  C[c + 2] = (A[6] * B[c] + A[7] * B[c + 1]) + A[8] * B[c + 2]
  PALPATE_COLUMN(0);
  PALPATE_COLUMN(3);
  PALPATE_COLUMN(6);
#undef PALPATE_COLUMN
  return out;
}

// Members

template <>
PALPATE_ALWAYS Vector3d& Vector3d::operator=(const Vector3d& b) {
  m_storage = b.m_storage;
  return *this;
}
template <>
PALPATE_ALWAYS Matrix3d& Matrix3d::operator=(const Matrix3d& b) {
  m_storage = b.m_storage;
  return *this;
}
template <>
PALPATE_ALWAYS Matrix<double, 6, 1>& Matrix<double, 6, 1>::operator=(const Matrix<double, 6, 1>& b) {
  m_storage = b.m_storage;
  return *this;
}
template <>
template <>
PALPATE_ALWAYS double MatrixBase<Vector3d>::dot(const MatrixBase<Vector3d>& b) const {
  const double *x = derived().data(), *y = b.derived().data();
  return (x[0] * y[0] + x[1] * y[1]) + x[2] * y[2];
}
template <>
PALPATE_ALWAYS double MatrixBase<Vector3d>::squaredNorm() const {
  const double* x = derived().data();
  return (x[0] * x[0] + x[1] * x[1]) + x[2] * x[2];
}
template <>
PALPATE_ALWAYS double MatrixBase<Vector3d>::norm() const {
  return std::sqrt(squaredNorm());
}
template <>
PALPATE_ALWAYS const Vector3d MatrixBase<Vector3d>::normalized() const {
  const double n = squaredNorm();
  return n > 0.0 ? derived() / std::sqrt(n) : derived();
}
template <>
template <>
PALPATE_ALWAYS Vector3d MatrixBase<Vector3d>::cross(const MatrixBase<Vector3d>& b) const {
  const double *x = derived().data(), *y = b.derived().data();
  return {x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]};
}
template <>
inline bool DenseBase<Vector3d>::allFinite() const {
  const double* x = derived().data();
  return static_cast<bool>(std::isfinite(x[0]) & std::isfinite(x[1]) & std::isfinite(x[2]));
}
template <>
inline bool DenseBase<Matrix3d>::allFinite() const {
  bool finite = true;
  for (int k = 0; k < 9; ++k) finite &= std::isfinite(derived().data()[k]);
  return finite;
}
template <>
PALPATE_ALWAYS Vector3d& DenseBase<Vector3d>::operator*=(const double& s) {
  double* x = derived().data();
  const double y = s;
  x[0] *= y, x[1] *= y, x[2] *= y;
  return derived();
}
template <>
PALPATE_ALWAYS Vector3d& DenseBase<Vector3d>::operator/=(const double& s) {
  double* x = derived().data();
  const double y = s;
  x[0] /= y, x[1] /= y, x[2] /= y;
  return derived();
}

namespace internal {

template <class Source>
struct PalpateOwnLoop : std::false_type {};
template <class T>
struct PalpateOwnLoop<CwiseNullaryOp<scalar_constant_op<double>, T>> : std::true_type {};
template <class A, class B, int Option>
struct PalpateOwnLoop<Product<A, B, Option>> : std::true_type {};
template <class Source, int R, int C>
concept PalpateCopied = R > 0 && C > 0 && R* C <= 9 && !PalpateOwnLoop<Source>::value;

/// Evaluates an expression into a small matrix, coefficient after coefficient.
template <int R, int C, int O, PalpateCopied<R, C> Source, class F>
  requires(!std::same_as<F, swap_assign_op<double>>)
PALPATE_ALWAYS void call_dense_assignment_loop(Matrix<double, R, C, O, R, C>& out, const Source& source, const F& f) {
  evaluator<Source> from(source);
  double* to = out.data();
  if constexpr (R == 1 || C == 1) {
    [&]<int... I>(std::integer_sequence<int, I...>) {
      (f.assignCoeff(to[I], from.coeff(R == 1 ? 0 : I, R == 1 ? I : 0)), ...);
    }(std::make_integer_sequence<int, R * C>{});
  } else {
    constexpr int rows = (O & RowMajor) ? C : R;
    [&]<int... I>(std::integer_sequence<int, I...>) {
      (f.assignCoeff(to[I], (O & RowMajor) ? from.coeff(I / rows, I % rows) : from.coeff(I % rows, I / rows)), ...);
    }(std::make_integer_sequence<int, R * C>{});
  }
}

}  // namespace internal
}  // namespace Eigen
