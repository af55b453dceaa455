// The priorities of soft fixtures, as a map of the tool's goal: a fixture acts at the goal that those of higher
// priority leave, and its wrench is carried back by the transposed Jacobian (NOTATION.md, "Virtual work").
//
//   y = x + d        d minimises |d|^2 + sum of w_i (a_i . d - c_i)^2        over the fixtures i of higher priority
//
// a_i is the unit gradient of the gap at x, and c_i the violation, of which half of the first kDampingRamp is left. The
// weight w_i rises from zero at the border to 10^3 at kDampingRamp, and falls with the force towards the end of a
// law's range, so that the map and its Jacobian are continuous: for one plane y lies on it, and the
// wrench of a lower fixture has no part along its normal. A fixture beyond the range of its force leaves every goal.
#pragma once

#include "palpate/guidance/fixture_state.hpp"

namespace palpate::guidance {

/// The goal that the fixtures of higher priority leave to the next ones.
class Priorities {
 public:
  /// Starts at the goal X_WT, without any fixture: the map is the identity.
  void begin(const Pose& X_WT) noexcept;
  /// Adds a fixture, for all that follow in priority.
  void add(const FixtureStates& states, int i, const Input& in) noexcept;
  /// Solves for the goal and its derivatives; to be called after add().
  void solve() noexcept;

  /// The goal left to the next fixtures.
  [[nodiscard]] const Pose& X_WT() const noexcept { return X_; }
  /// Its derivative with respect to the goal of begin(); both as (displacement, rotation vector) in W.
  [[nodiscard]] const Mat6& jacobian() const noexcept { return J_; }
  /// True if the map is not the identity.
  [[nodiscard]] bool moves() const noexcept { return moves_; }
  /// True if a fixture of the map was edited, or its authority changed by itself: so does what the next ones store.
  [[nodiscard]] bool edited() const noexcept { return edited_; }
  /// Velocity of the goal at rest, by the motion of the fixtures of the map, in W.
  [[nodiscard]] const Twist& drift() const noexcept { return drift_; }

 private:
  /// A fixture's part in the program; vectors are those of (displacement, kLength * rotation), as in row().
  struct Term {
    Vec6 a = Vec6::Zero();
    double c = 0.0;                         ///< [m]
    double share = 0.0;                     ///< rises to the fixture's authority [0-1]
    bool turns = false;                     ///< the gap depends on the rotation
    double c_rate = 0.0, share_rate = 0.0;  ///< by the motion of the fixture [m/s, 1/s]
  };
  static constexpr int kTime = 6;  ///< index of the derivative with respect to time, after those of the pose
  [[nodiscard]] static Term term(const FixtureStates& states, int i, const Pose& X, const Input& in) noexcept;

  Pose X0_, X_;
  Mat6 J_ = Mat6::Identity();
  bool moves_ = false, edited_ = false;
  Twist drift_;
  Mat6 M_ = Mat6::Identity();  ///< I + sum of w a a^T
  Vec6 b_ = Vec6::Zero();      ///< sum of w c a
  std::array<Mat6, 7> dM_{};   ///< derivatives of M with respect to each component of X0, and to time
  std::array<Vec6, 7> db_{};   ///< those of b
};

}  // namespace palpate::guidance
