// Joint goals that move the tip of an arm to a pose, tick by tick.
#pragma once

#include "palpate/arm/arm.hpp"

namespace palpate::loop {

/// Moves q towards the solution of the inverse kinematics for X_BT_goal, each joint by at most q_step [rad, m]: the
/// solution may jump when a goal comes back into reach. Returns false, and leaves q unchanged, if there is no solution.
inline bool reach(arm::Arm& arm, const Pose& X_BT_goal, const JointVector& q_step, JointVector& q) noexcept {
  JointVector wanted = q;
  const bool reached = arm.ik(X_BT_goal, wanted).converged && wanted.allFinite();
  if (reached) q += (wanted - q).cwiseMax(-q_step).cwiseMin(q_step).eval();
  return reached;
}

}  // namespace palpate::loop
