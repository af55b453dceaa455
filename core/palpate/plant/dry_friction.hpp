// One implicit step of joints with dry friction and end stops: find the velocity that no sticking joint contradicts.
#pragma once

#include <array>

#include "palpate/types/spatial.hpp"

namespace palpate::plant {

/// Solves  A v = b + lambda  with, per joint,
///   v > 0 and lambda = lo,   or   v < 0 and lambda = hi,   or   v = 0 and lo <= lambda <= hi
/// (A symmetric positive definite; Coulomb friction is lo = -Fc dt, hi = +Fc dt; a lower end stop lifts hi to
/// infinity). Because friction is an unknown of the step, a resting joint rests exactly and nothing chatters. Block
/// pivoting with the last step's answer as first guess, then single pivots in order of index (Judice & Pires 1994,
/// which end for such A).
class DryFriction {
 public:
  void reset(Eigen::Index n) noexcept;
  /// v of the next step; allocation free.
  const JointVector& solve(const JointMatrix& A, const JointVector& b, const JointVector& lo,
                           const JointVector& hi) noexcept;

 private:
  enum class State : signed char { back = -1, stuck = 0, forth = 1 };
  void solve_moving(const JointMatrix& A, const JointVector& b, const JointVector& lo, const JointVector& hi) noexcept;
  bool correct(const JointMatrix& A, const JointVector& b, const JointVector& lo, const JointVector& hi,
               bool one_only) noexcept;

  std::array<State, kMaxJoints> state_{};
  JointVector v_;
};

}  // namespace palpate::plant
