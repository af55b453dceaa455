// Coupling of joints and actuators:  q_joint = A q_actuator.
#pragma once

#include "dvrk/spec.hpp"

namespace palpate::dvrk {

/// The coupling matrix A of an arm. For an MTM it is that of its drives (parallelogram). For a PSM the last four joints
/// (roll, pitch, yaw, jaw) are coupled by the disks of the tool LARGE_NEEDLE_DRIVER 400006. For an ECM it is the
/// identity.
[[nodiscard]] inline JointMatrix actuator_coupling(const ArmSpec& spec) noexcept {
  const Eigen::Index n = spec.model.n();
  if (spec.kind == ArmKind::mtm) return spec.leader.coupling;
  if (spec.kind == ArmKind::ecm) return JointMatrix::Identity(n, n);
  JointMatrix A = JointMatrix::Identity(n + 1, n + 1);
  A.bottomRightCorner<4, 4>() << -1.5632, 0.0, 0.0, 0.0,  //
      0.0, 1.0186, 0.0, 0.0,                              //
      0.0, -0.8306, 0.6089, 0.6089,                       //
      0.0, 0.0, -1.2177, 1.2177;
  return A;
}

}  // namespace palpate::dvrk
