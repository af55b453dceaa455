// Measured and commanded motion of handle and tool, as the stages of the cycle share it.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate {

/// When a state was measured, and whether it may be used.
struct Sample {
  double t = 0.0;     ///< stamp [s]
  bool good = false;  ///< finite, valid and fresh; otherwise the state is the last one that was
};

/// The operator's handle, however its pose is known.
struct Handle : Sample {
  Pose X_LH;                   ///< measured
  Twist V_LH;                  ///< measured or estimated
  double gripper = 0.0;        ///< pinch [rad]
  JointVector q;               ///< measured joints of the device, for its friction; may be empty [rad, m]
  bool takes_damping = false;  ///< the device renders the damping of a DampedWrench by itself
  double F_hand = -1.0;        ///< operator's force, measured by a load cell; below zero: no load cell [N]
};

/// Joints of the tool's arm, where they are known.
struct ToolJoints {
  Jacobian J_WT;                ///< 6 x n, at the tool tip, in W
  JointVector q, q_min, q_max;  ///< measured; limits [rad, m]
  JointVector step;             ///< largest change of each joint in one period [rad, m]
};

/// The tool, however its pose is known.
struct ToolState : Sample {
  bool reached = true;                 ///< the follower could take the last goal
  Pose X_WT;                           ///< measured
  double jaw = 0.0;                    ///< measured [rad]
  Vec3 F_estimate_W = Vec3::Zero();    ///< environment on the tool, estimated where the force's source needs it [N]
  const ToolJoints* joints = nullptr;  ///< for hard fixtures, which respect the joints' limits; may be null
};

/// Commanded motion of the tool.
struct ToolGoal {
  Pose X_WT_goal;
  double jaw = 0.0;      ///< [rad]
  Twist V_WT;            ///< the handle's velocity mapped to the tool, for damping terms
  bool engaged = false;  ///< the tool follows the hand in this tick
};

/// What the tool touches.
struct Touch {
  Wrench F_T_W;            ///< environment on the tool
  double stiffness = 0.0;  ///< of the environment along that force, on the tool's side; 0 when unknown [N/m]
};

}  // namespace palpate
