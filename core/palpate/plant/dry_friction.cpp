#include "palpate/plant/dry_friction.hpp"

#include <cmath>
#include <cstring>

#include "palpate/types/cholesky.hpp"
#include "palpate/types/pack.hpp"

namespace palpate::plant {
namespace {

constexpr int kBlockPivots = 6;
constexpr int kPivots = 60;
constexpr double kTolerance = 1e-14;  // of velocities and impulses: rounding, not physics

}  // namespace

/// v <- the solution of A v = b + (lo or hi) over the moving joints, whose direction is not 0; v = 0 for all others.
PALPATE_AVX2_TOO void solve_moving_joints(const Lanes (&A)[kLanes], const Lanes& b, const Lanes& lo, const Lanes& hi,
                                          const Lanes& direction, Lanes& v) noexcept {
  alignas(64) Lanes moves, A_moving[kLanes];  // a joint that sticks becomes an equation of its own: 1 v = 0
  store(load(direction) * load(direction), moves);
  for (int j = 0; j < kLanes; ++j) {
    store(moves[j] * (load(moves) * load(A[j])), A_moving[j]);
    A_moving[j][j] += 1.0 - moves[j];
    v[j] = direction[j] == 0.0 ? 0.0 : b[j] + (direction[j] > 0.0 ? lo[j] : hi[j]);
  }
  solve_positive(A_moving, v);
}

void DryFriction::reset(Eigen::Index n) noexcept {
  std::memset(direction_, 0, sizeof direction_);
  v_.resize(n);
  std::memset(v_.data(), 0, sizeof(Lanes));
}

const JointVector& DryFriction::solve(const Lanes (&A)[kLanes], const Lanes& b, const Lanes& lo,
                                      const Lanes& hi) noexcept {
  for (Eigen::Index i = 0; i < v_.size(); ++i) {  // a joint that has moved into an end stop starts from rest
    if (std::isinf(direction_[i] > 0.0 ? lo[i] : hi[i])) direction_[i] = 0.0;
  }
  for (int pivot = 0; pivot < kPivots; ++pivot) {
    solve_moving_joints(A, b, lo, hi, direction_, lanes(v_));
    if (!correct(A, b, lo, hi, pivot >= kBlockPivots)) break;
  }
  return v_;
}

bool DryFriction::correct(const Lanes (&A)[kLanes], const Lanes& b, const Lanes& lo, const Lanes& hi,
                          bool one_only) noexcept {
  bool changed = false;
  for (int i = 0; i < v_.size() && !(changed && one_only); ++i) {
    double& direction = direction_[i];
    const double before = direction;
    if (lo[i] == hi[i] && direction != 0.0) continue;  // no friction: any velocity is right
    if (direction == 0.0) {
      double lambda = -b[i];  // impulse that holds the joint
      for (int k = 0; k < v_.size(); ++k) lambda += (k < i ? A[k][i] : A[i][k]) * v_[k];
      if (lambda > hi[i] + kTolerance) direction = -1.0;
      if (lambda < lo[i] - kTolerance) direction = 1.0;
    } else if (direction * v_[i] < -kTolerance) {
      direction = 0.0;
    }
    changed |= direction != before;
  }
  return changed;
}

}  // namespace palpate::plant
