// The joints that bring an arm's tip to a goal, tick by tick.
#pragma once

#include "palpate/arm/arm.hpp"

namespace palpate::loop {

/// q (in/out) towards the joints of the goal, by q_step at most: where a goal comes back into reach they are not those
/// of where it left. q stays when there are none. Answers whether there are.
inline bool reach(arm::Arm& arm, const Pose& X_BT_goal, const JointVector& q_step, JointVector& q) noexcept {
  JointVector wanted = q;
  const bool reached = arm.ik(X_BT_goal, wanted).converged && wanted.allFinite();
  if (reached) q += (wanted - q).cwiseMax(-q_step).cwiseMin(q_step).eval();
  return reached;
}

}  // namespace palpate::loop
