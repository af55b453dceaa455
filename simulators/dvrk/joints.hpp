// Joints of the dVRK's arms, and the map from wrenches to joint torques.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate::dvrk {

/// Index of joint 4: the platform of an MTM's gimbal, the first joint of a PSM's wrist.
inline constexpr Eigen::Index kPlatformJoint = 3;

/// J^T F; the Jacobian and the wrench are in the same axes.
[[nodiscard]] inline JointVector joint_torque(const Jacobian& J, const Wrench& F) noexcept {
  JointVector tau(J.cols());
  for (Eigen::Index k = 0; k < J.cols(); ++k) {
    tau[k] = J.col(k).head<3>().dot(F.f) + J.col(k).tail<3>().dot(F.t);
  }
  return tau;
}

}  // namespace palpate::dvrk
