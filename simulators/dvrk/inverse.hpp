// Inverse kinematics of the dVRK's arms: a local solution for servoing, and a global one for moves.
#pragma once

#include "dvrk/messages.hpp"
#include "palpate/arm/arm.hpp"

namespace palpate::dvrk {

/// Finds joint positions near q (in/out) for the tip at X_0T, clipped to the limits. Returns the remaining position
/// error [m]. The platform of an MTM is moved so that its gimbal stays open.
double inverse_near(arm::Arm& model, ArmKind kind, const Pose& X_0T, JointVector& q) noexcept;

/// Finds joint positions within the limits for the tip at X_0T, starting at q (in/out), `home` and other guesses.
/// Returns false and leaves q unchanged if none are found.
bool inverse_anywhere(arm::Arm& model, ArmKind kind, const Pose& X_0T, const JointVector& home,
                      JointVector& q) noexcept;

}  // namespace palpate::dvrk
