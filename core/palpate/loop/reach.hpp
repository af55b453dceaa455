// Joint goals that move the tip of an arm to a pose, tick by tick.
#pragma once

#include "palpate/arm/arm.hpp"

namespace palpate::loop {

/// The joints of a follower whose goal may lie beyond its reach.
///
/// Within reach the tip goes to the goal. Beyond it the tip goes to the nearest pose that the joints' limits allow, so
/// that the tip follows the hand along the border of the reach. The derivative J of the tip's pose with respect to
/// the goal carries the forces on the tool back to the hand (NOTATION.md, "Virtual work"): at the end of a shaft in its
/// remote centre the hand feels the part of a force across the shaft and not the part along it.
class Reach {
 public:
  /// Moves q towards the joints for X_BT_goal, each by at most q_step [rad, m], since the solution may jump. Returns
  /// true if the goal is within reach. Where nothing nearer to the goal is found, q stays. R_WB: orientation of the
  /// arm's base in W.
  bool step(arm::Arm& arm, const Pose& X_BT_goal, const Mat3& R_WB, const JointVector& q_step, JointVector& q) noexcept;
  /// The goal of the joints is no longer this one's: they count as within reach.
  void reset() noexcept { reached_ = true; }
  /// J in W, both sides as (displacement, rotation vector); null within reach, where it is the identity.
  [[nodiscard]] const Mat6* J_WT() const noexcept { return reached_ ? nullptr : &J_WT_; }

 private:
  bool reached_ = true;
  Mat6 J_WT_ = Mat6::Zero();
};

}  // namespace palpate::loop
