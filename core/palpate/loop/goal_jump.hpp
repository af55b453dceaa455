// Jumps of the corrected goal: motions of the tool that the hand has not made.
#pragma once

#include <algorithm>

#include "palpate/types/so3.hpp"
#include "palpate/types/spatial.hpp"
#include "palpate/types/virtual_work.hpp"

namespace palpate::loop {

/// Where the nearest place that hard fixtures allow changes its side, the corrected goal jumps there, and the tool
/// after it. The hand does no work by such a motion, so that a contact may not store it (contact/tool.hpp).
class GoalJump {
 public:
  /// Takes the goals of a tick. J: derivative of the corrected with respect to the mapped goal.
  void see(const Pose& X_mapped, const Pose& X_corrected, const Mat6& J) noexcept {
    if (started_) {
      const Twist hand = between(X_mapped_, X_mapped), goal = between(X_corrected_, X_corrected);
      const Twist before = carried(J_, hand), now = carried(J, hand);
      add(goal.v - 0.5 * (before.v + now.v), hand.v.norm() + kLever * hand.w.norm(), kJump, ahead_.v);
      add(goal.w - 0.5 * (before.w + now.w), hand.w.norm() + hand.v.norm() / kLever, kJump / kLever, ahead_.w);
    }
    X_mapped_ = X_mapped, X_corrected_ = X_corrected, J_ = J;
    started_ = true;
  }
  /// The part of the jumps that the tool has made since the last tick (displacement, rotation vector), in W.
  Twist made(const Pose& X_WT) noexcept {
    const Twist moved = between(X_WT_, X_WT);
    X_WT_ = X_WT;
    return {take(moved.v, ahead_.v), take(moved.w, ahead_.w)};
  }

 private:
  static constexpr double kJump = 3e-4;   // [m] a smaller motion within a tick is none: a fixture may move the tool
  static constexpr double kLever = 0.02;  // [m] length that makes rotations comparable

  static Twist between(const Pose& a, const Pose& b) noexcept {
    return {b.p - a.p, rotation_vector(b.R * a.R.transpose())};
  }
  static void add(const Vec3& beyond, double hand, double least, Vec3& ahead) noexcept {
    if (beyond.norm() > least + hand) ahead += beyond;
  }
  static Vec3 take(const Vec3& moved, Vec3& ahead) noexcept {
    const double left = ahead.norm();
    if (!(left > 0.0)) return Vec3::Zero();
    const Vec3 made = std::clamp(moved.dot(ahead) / (left * left), 0.0, 1.0) * ahead;
    ahead -= made;
    return made;
  }

  bool started_ = false;
  Pose X_mapped_, X_corrected_, X_WT_;
  Mat6 J_ = Mat6::Identity();
  Twist ahead_;  ///< jumps that the tool has not made yet
};

}  // namespace palpate::loop
