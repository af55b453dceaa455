// Inverse kinematics as the arms of the dVRK need it: near where the joints are for servoing, from anywhere for a move.
#pragma once

#include "dvrk/messages.hpp"
#include "palpate/arm/arm.hpp"

namespace palpate::dvrk {

/// Joints near q (in/out) for the tip at X_0T, clipped to the limits. How far the tip then is from it [m]. An MTM's
/// platform is led so that its gimbal stays open.
double inverse_near(arm::Arm& model, ArmKind kind, const Pose& X_0T, JointVector& q) noexcept;

/// Joints for the tip at X_0T, wherever q (in/out) is. False, and q as it was: there are none within the limits.
bool inverse_anywhere(arm::Arm& model, ArmKind kind, const Pose& X_0T, const JointVector& home,
                      JointVector& q) noexcept;

}  // namespace palpate::dvrk
