#include "palpate/plant/dry_friction.hpp"

#include <cstring>
#include <limits>

#include "palpate/types/pack.hpp"

namespace palpate::plant {
namespace {

constexpr int kBlockPivots = 6;
constexpr int kPivots = 60;
constexpr double kTolerance = 1e-14;  // of velocities and impulses: rounding, not physics

/// A^-1 right for a positive definite A of n rows, of which only the upper triangle is read; all of A is overwritten.
/// Elimination without fractions: each step multiplies the rest by the pivot and divides it by the pivot before, so
/// that no step waits for a division. The pivots are the leading minors of A.
PALPATE_INLINE Pack solve_in_lanes(int n, Lanes (&A)[kLanes], const Pack& right) noexcept {
  Pack b = right;
  double inverse[kLanes] = {}, y[kLanes] = {}, x[kLanes], before = 1.0;
#pragma GCC unroll 8
  for (int j = 0; j < kLanes; ++j) {
    if (j >= n) break;
    const Pack row = load(A[j]);
    const double pivot = A[j][j];
    inverse[j] = 1.0 / pivot;
    y[j] = j < 4 ? b.low[j] : b.high[j - 4];
    b = before * (pivot * b - y[j] * row);
#pragma GCC unroll 8
    for (int i = j + 1; i < kLanes; ++i) {
      Pack other = load(A[i]);
      other.high = before * (pivot * other.high - A[j][i] * row.high);
      if (i < 4) other.low = before * (pivot * other.low - A[j][i] * row.low);
      store(other, A[i]);
    }
    before = inverse[j];
  }
#pragma GCC unroll 8
  for (int i = kLanes - 1; i >= 0; --i) {  // the newest unknown last, so that the others need not wait for it
    double sum = y[i];
#pragma GCC unroll 8
    for (int k = kLanes - 1; k > i; --k) sum -= A[i][k] * x[k];
    x[i] = sum * inverse[i];
  }
  return {Four{x[0], x[1], x[2], x[3]}, Four{x[4], x[5], x[6], x[7]}};
}

/// v <- the solution of A v = b + (lo or hi) over the moving joints, whose direction is not 0; v = 0 for all others.
PALPATE_INLINE void solve_moving_joints(int n, const Lanes (&A)[kLanes], const Lanes& b, const Lanes& lo,
                                        const Lanes& hi, const Lanes& direction, Lanes& v) noexcept {
  const Pack zero = {}, way = load(direction), moves = way * way, one = constant(1.0);
  alignas(64) Lanes moving, A_moving[kLanes];
  if (dot(moves, moves) == n) {
    for (int j = 0; j < kLanes; ++j) store(load(A[j]), A_moving[j]);
  } else {  // a joint that sticks becomes an equation of its own: 1 v = 0
    store(moves, moving);
    for (int j = 0; j < kLanes; ++j) {
      store(moving[j] * (moves * load(A[j])) + load(kUnit[j]) * (one - moves), A_moving[j]);
    }
  }
  const Pack right = load(b) + where_at_most(way, zero, load(hi), load(lo));
  store(solve_in_lanes(n, A_moving, where_at_most(moves, zero, zero, right)), v);
}

/// Lets a joint that has moved into an end stop start from rest.
PALPATE_INLINE void stop_at_ends(const Lanes& lo, const Lanes& hi, Lanes& direction) noexcept {
  const Pack way = load(direction), zero = {}, most = constant(std::numeric_limits<double>::max());
  const Pack impulse = where_at_most(way, zero, load(hi), -load(lo));
  store(where_at_most(impulse, most, way, zero), direction);
}

/// Directions of n joints that suit v and the impulses better, where those are not as required. Returns false if
/// nothing changes.
PALPATE_INLINE bool next_directions(int n, const Lanes (&A)[kLanes], const Lanes& b, const Lanes& lo, const Lanes& hi,
                                    const Lanes& v, const Lanes& direction, Lanes& next) noexcept {
  const Pack way = load(direction), zero = {}, one = constant(1.0), slack = constant(kTolerance);
  const Pack least = load(lo), most = load(hi);
  // A moving joint that would turn back sticks, except without friction: then any velocity is right.
  const Pack friction = where_at_most(most, least, zero, one);
  const Pack back = where_at_most(-slack, way * load(v), zero, friction);
  // A joint that sticks needs the impulse `hold` between its bounds.
  const bool all_move = dot(way, way) == n;
  const Pack hold = all_move ? zero : product(A, v) - load(b);
  const Pack pushed = where_at_most(least - slack, hold, where_at_most(hold, most + slack, zero, -one), one);
  const Pack chosen = where_at_most(way * way, zero, pushed, way - back * way);
  store(chosen, next);
  const Pack change = chosen - way;
  return dot(change, change) > 0.0;
}

}  // namespace

PALPATE_AVX2_TOO void DryFriction::solve(int n, const Lanes (&A)[kLanes], const Lanes& b, const Lanes& lo,
                                         const Lanes& hi, Lanes& direction, Lanes& v) noexcept {
  stop_at_ends(lo, hi, direction);
  for (int pivot = 0; pivot < kPivots; ++pivot) {
    solve_moving_joints(n, A, b, lo, hi, direction, v);
    alignas(64) Lanes next;
    if (!next_directions(n, A, b, lo, hi, v, direction, next)) break;
    if (pivot >= kBlockPivots) {  // one at a time
      int k = 0;
      while (next[k] == direction[k]) ++k;
      direction[k] = next[k];
    } else {
      store(load(next), direction);
    }
  }
}

void DryFriction::reset(Eigen::Index n) noexcept {
  std::memset(direction_, 0, sizeof direction_);
  v_.resize(n);
  std::memset(v_.data(), 0, sizeof(Lanes));
}

const JointVector& DryFriction::solve(const Lanes (&A)[kLanes], const Lanes& b, const Lanes& lo,
                                      const Lanes& hi) noexcept {
  solve(static_cast<int>(v_.size()), A, b, lo, hi, direction_, lanes(v_));
  return v_;
}

}  // namespace palpate::plant
