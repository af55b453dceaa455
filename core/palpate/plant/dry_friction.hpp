// One implicit step of joints with dry friction and end stops.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate::plant {

/// Solves  A v = b + lambda  for v and lambda, where each joint satisfies one of
///   v > 0 and lambda = lo,   v < 0 and lambda = hi,   v = 0 and lo <= lambda <= hi.
/// A is symmetric and positive definite. Coulomb friction is lo = -Fc dt and hi = +Fc dt; at a lower end stop hi is
/// infinite, at an upper one lo is minus infinity. Because friction is an unknown of the step, a joint at rest stays
/// exactly at rest and nothing chatters. The method is block pivoting, started with the directions of the last step,
/// and then single pivots in the order of the joints, which end for such A (Judice and Pires 1994).
class DryFriction {
 public:
  /// All of the n joints rest.
  void reset(Eigen::Index n) noexcept;
  /// Velocity at the end of the step (n,), zero beyond the last joint. A is full and symmetric; A, b, lo and hi are
  /// zero beyond the last joint, except that lo and hi may be infinite there.
  const JointVector& solve(const Lanes (&A)[kLanes], const Lanes& b, const Lanes& lo, const Lanes& hi) noexcept;

  /// Result of the last solve().
  [[nodiscard]] const JointVector& v() const noexcept { return v_; }

 private:
  /// The same for n joints; `direction` of the last step, then of this one.
  static void solve(int n, const Lanes (&A)[kLanes], const Lanes& b, const Lanes& lo, const Lanes& hi, Lanes& direction,
                    Lanes& v) noexcept;

  Lanes direction_{};  ///< of each joint's motion: 1, -1, or 0 while it sticks
  JointVector v_;
};

}  // namespace palpate::plant
