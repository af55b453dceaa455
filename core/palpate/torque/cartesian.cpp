#include "palpate/torque/cartesian.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/pack.hpp"

namespace palpate::torque {

/// P <- X^T M^-1 X for matrices of n rows. Only the upper triangle of M is read; M and X are overwritten. Elimination
/// without fractions: each step multiplies the rest by the pivot and divides it by the pivot before, so that no step
/// waits for a division. Pivot j is the leading minor D_j+1 of M, and P the sum of x_j x_j^T / (D_j D_j+1) over the
/// rows x_j of X after their elimination. False if M is not positive definite; P is then useless.
PALPATE_AVX2_TOO bool multiply_by_inverse(int n, Lanes (&M)[kLanes], Lanes (&X)[kLanes], Lanes (&P)[kLanes]) noexcept {
  bool positive = true;
  double before = 1.0;
  alignas(64) Lanes scaled[kLanes];
  for (int j = 0; j < n; ++j) {
    const double pivot = M[j][j], inverse = 1.0 / pivot;
    const Pack row = load(M[j]), x = load(X[j]);
    for (int i = j + 1; i < n; ++i) {
      const double factor = M[j][i];
      store(before * (pivot * load(M[i]) - factor * row), M[i]);
      store(before * (pivot * load(X[i]) - factor * x), X[i]);
    }
    store((before * inverse) * x, scaled[j]);
    positive &= pivot > 0.0;
    before = inverse;
  }
  for (int r = 0; r < kLanes; ++r) {
    Pack sum = constant(0.0);
    for (int j = 0; j < n; ++j) sum = sum + scaled[j][r] * load(X[j]);
    store(sum, P[r]);
  }
  return positive;
}

namespace {

constexpr double kLever = 0.1;  // [m] lever arm that converts a rotational inertia into a mass
constexpr int kSweeps = 30;     // upper bound for the sweeps of Jacobi's method, which needs at most six

/// Diagonalises the symmetric matrix A by Jacobi rotations. On return the diagonal of A holds the eigenvalues, and the
/// columns of V hold the eigenvectors.
template <int m>
void diagonalise(double (&A)[m][m], double (&V)[m][m]) noexcept {
  for (int i = 0; i < m; ++i) {
    for (int j = 0; j < m; ++j) V[i][j] = i == j ? 1.0 : 0.0;
  }
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool rotated = false;
    for (int p = 0; p < m; ++p) {
      for (int q = p + 1; q < m; ++q) {
        if (!(std::abs(A[p][q]) > 1e-17 * (std::abs(A[p][p]) + std::abs(A[q][q])))) continue;
        rotated = true;
        const double theta = 0.5 * (A[q][q] - A[p][p]) / A[p][q];
        const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
        const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
        for (int k = 0; k < m; ++k) {
          const double a = A[k][p], b = A[k][q];
          A[k][p] = c * a - s * b;
          A[k][q] = s * a + c * b;
        }
        for (int k = 0; k < m; ++k) {
          const double a = A[p][k], b = A[q][k], v = V[k][p], w = V[k][q];
          A[p][k] = c * a - s * b;
          A[q][k] = s * a + c * b;
          V[k][p] = c * v - s * w;
          V[k][q] = s * v + c * w;
        }
      }
    }
    if (!rotated) return;
  }
}

/// Computes A^-1 with all eigenvalues reduced to at most `max_inertia`. Returns true if an eigenvalue was reduced.
template <int m>
bool bounded_inverse(const Lanes (&A)[kLanes], double max_inertia, Lanes (&inverse)[kLanes]) noexcept {
  alignas(64) Lanes M[kLanes]{}, unit[kLanes]{};
  for (int i = 0; i < m; ++i) {
    std::copy_n(A[i], m, M[i]);
    unit[i][i] = 1.0;
  }
  const bool positive = multiply_by_inverse(m, M, unit, inverse);
  double trace = 0.0;
  for (int i = 0; i < m; ++i) trace += inverse[i][i];
  if (positive && trace <= max_inertia) return false;  // the trace bounds every eigenvalue
  double D[m][m], B[m][m];
  for (int i = 0; i < m; ++i) std::copy_n(A[i], m, D[i]);
  diagonalise(D, B);
  bool cut = false;
  for (int k = 0; k < m; ++k) cut |= !(D[k][k] >= 1.0 / max_inertia);
  for (int i = 0; i < m; ++i) {
    for (int j = 0; j < m; ++j) {
      inverse[i][j] = 0.0;
      for (int k = 0; k < m; ++k) inverse[i][j] += B[i][k] * B[j][k] / std::max(D[k][k], 1.0 / max_inertia);
    }
  }
  return cut;
}

}  // namespace

// D = diag(weight) scales the task axes. With (X, c, g) = (J^T D, C v, G), one product contains
//
//   D J M^-1 J^T D = X^T M^-1 X,     D J M^-1 C v = X^T M^-1 c,     D J M^-1 G = X^T M^-1 g
template <int m>
Cartesian<m> cartesian(const arm::Dynamics& d, const JointVector& rotor, Eigen::Index joints,
                       double max_inertia) noexcept {
  static_assert(m + 2 <= kLanes);
  double weight[m];
  alignas(64) Lanes M[kLanes]{}, X[kLanes]{}, P[kLanes], inverse[kLanes];
  for (int r = 0; r < m; ++r) weight[r] = r < 3 ? 1.0 : kLever;
  const int n = static_cast<int>(joints);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) M[i][j] = d.M(i, j);
    M[i][i] += rotor[i];
    for (int r = 0; r < m; ++r) X[i][r] = weight[r] * d.J(r, i);
    X[i][m] = d.bias[i] - d.G[i];
    X[i][m + 1] = d.G[i];
  }
  multiply_by_inverse(n, M, X, P);

  Cartesian<m> c;
  c.singular = bounded_inverse<m>(P, max_inertia, inverse);
  Eigen::Matrix<double, m, 1> Cv, G;
  for (int r = 0; r < m; ++r) {
    for (int s = 0; s < m; ++s) c.Lambda(r, s) = weight[r] * inverse[r][s] * weight[s];
    Cv[r] = P[r][m] / weight[r] - d.Jdot_v[r];
    G[r] = P[r][m + 1] / weight[r];
  }
  c.Gamma_v = c.Lambda.lazyProduct(Cv);
  c.eta = c.Lambda.lazyProduct(G);
  return c;
}

template Cartesian<3> cartesian<3>(const arm::Dynamics&, const JointVector&, Eigen::Index, double) noexcept;
template Cartesian<6> cartesian<6>(const arm::Dynamics&, const JointVector&, Eigen::Index, double) noexcept;

}  // namespace palpate::torque
