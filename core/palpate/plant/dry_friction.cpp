#include "palpate/plant/dry_friction.hpp"

#include <cmath>

namespace palpate::plant {
namespace {

constexpr int kBlockPivots = 6;
constexpr int kPivots = 60;
constexpr double kTolerance = 1e-14;  // of velocities and impulses: rounding, not physics

/// x <- A^-1 x for the leading m x m part, by Cholesky in place (rows of `a` are kMaxJoints long).
void cholesky_solve(double (&a)[kMaxJoints][kMaxJoints], double (&x)[kMaxJoints], int m) noexcept {
  for (int j = 0; j < m; ++j) {
    double d = a[j][j];
    for (int k = 0; k < j; ++k) d -= a[j][k] * a[j][k];
    const double inverse = 1.0 / std::sqrt(d);
    a[j][j] = inverse;
    for (int i = j + 1; i < m; ++i) {
      double s = a[i][j];
      for (int k = 0; k < j; ++k) s -= a[i][k] * a[j][k];
      a[i][j] = s * inverse;
    }
  }
  for (int i = 0; i < m; ++i) {
    for (int k = 0; k < i; ++k) x[i] -= a[i][k] * x[k];
    x[i] *= a[i][i];
  }
  for (int i = m - 1; i >= 0; --i) {
    for (int k = i + 1; k < m; ++k) x[i] -= a[k][i] * x[k];
    x[i] *= a[i][i];
  }
}

}  // namespace

void DryFriction::reset(Eigen::Index n) noexcept {
  state_.fill(State::stuck);
  v_ = JointVector::Zero(n);
}

const JointVector& DryFriction::solve(const JointMatrix& A, const JointVector& b, const JointVector& lo,
                                      const JointVector& hi) noexcept {
  for (Eigen::Index i = 0; i < b.size(); ++i) {  // moved into an end stop: start from rest
    State& state = state_[static_cast<std::size_t>(i)];
    if (std::isinf(state == State::forth ? lo[i] : hi[i])) state = State::stuck;
  }
  for (int pivot = 0; pivot < kPivots; ++pivot) {
    solve_moving(A, b, lo, hi);
    if (!correct(A, b, lo, hi, pivot >= kBlockPivots)) break;
  }
  return v_;
}

void DryFriction::solve_moving(const JointMatrix& A, const JointVector& b, const JointVector& lo,
                               const JointVector& hi) noexcept {
  double a[kMaxJoints][kMaxJoints];
  double x[kMaxJoints];
  int moving[kMaxJoints];
  int m = 0;
  for (int i = 0; i < static_cast<int>(b.size()); ++i) {
    const auto s = static_cast<std::size_t>(i);
    v_[i] = 0.0;
    if (state_[s] == State::stuck) continue;
    for (int k = 0; k < m; ++k) a[m][k] = A(i, moving[k]);
    a[m][m] = A(i, i);
    x[m] = b[i] + (state_[s] == State::forth ? lo[i] : hi[i]);
    moving[m++] = i;
  }
  cholesky_solve(a, x, m);
  for (int k = 0; k < m; ++k) v_[moving[k]] = x[k];
}

bool DryFriction::correct(const JointMatrix& A, const JointVector& b, const JointVector& lo, const JointVector& hi,
                          bool one_only) noexcept {
  bool changed = false;
  for (Eigen::Index i = 0; i < b.size() && !(changed && one_only); ++i) {
    State& state = state_[static_cast<std::size_t>(i)];
    const State before = state;
    if (lo[i] == hi[i] && state != State::stuck) continue;  // no friction: any velocity is right
    if (state == State::stuck) {
      const double lambda = A.col(i).dot(v_) - b[i];  // what holding this joint takes
      if (lambda > hi[i] + kTolerance) state = State::back;
      if (lambda < lo[i] - kTolerance) state = State::forth;
    } else if (static_cast<double>(state) * v_[i] < -kTolerance) {
      state = State::stuck;
    }
    changed |= state != before;
  }
  return changed;
}

}  // namespace palpate::plant
