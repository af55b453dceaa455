// Measured and commanded motion of the handle and the tool, as the stages of the cycle exchange it.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate {

/// Time stamp and validity of a measured state.
struct Sample {
  double t = 0.0;      ///< time stamp of the measurement [s]
  bool valid = false;  ///< true if the state is finite, valid and fresh; otherwise it is the last good state
};

/// State of the operator's handle, from any kind of leader device.
struct Handle : Sample {
  Pose X_LH;                     ///< measured pose of the handle in the leader base
  Twist V_LH;                    ///< measured or estimated velocity of the handle
  double gripper = 0.0;          ///< pinch angle, 0 = closed [rad]
  JointVector q;                 ///< measured joint positions, for the device's friction model; may be empty [rad, m]
  bool renders_damping = false;  ///< true if the device itself renders the damping of a DampedWrench
  double F_hand = -1.0;          ///< magnitude of the operator's force from a load cell; negative: no load cell [N]
};

/// Joint state of the tool's arm, if it is known.
struct ToolJoints {
  Jacobian J_WT;                ///< Jacobian at the tool tip, 6 x n, in W
  JointVector q, q_min, q_max;  ///< measured joint positions and their limits (n,) [rad, m]
  JointVector max_step;         ///< largest change of each joint position in one period (n,) [rad, m]
};

/// State of the tool, from any kind of follower.
struct ToolState : Sample {
  bool reached = true;                 ///< true if the follower could reach the last goal
  Pose X_WT;                           ///< measured pose of the tool in W
  double jaw = 0.0;                    ///< measured jaw angle [rad]
  Wrench F_others_W;                   ///< wrench of other instruments on the tool, rendered in addition [N, N m]
  double K_others = 0.0;               ///< stiffness of this contact [N/m]
  double power_others = 0.0;           ///< power of the motion of other instruments on the tool [W]
  Vec3 F_estimate_W = Vec3::Zero();    ///< estimated force of the environment on the tool, if in use [N]
  const ToolJoints* joints = nullptr;  ///< joint state, for hard fixtures that respect the joint limits; may be null
};

/// Commanded motion of the tool.
struct ToolGoal {
  Pose X_WT_goal;        ///< commanded pose of the tool in W
  double jaw = 0.0;      ///< commanded jaw angle [rad]
  Twist V_WT;            ///< velocity of the handle mapped to the tool, for damping terms
  bool engaged = false;  ///< true if the tool follows the hand in this tick
};

/// Force of the environment on the tool, and its stiffness.
struct ToolForce {
  Wrench F_T_W;            ///< wrench of the environment on the tool [N, N m]
  double stiffness = 0.0;  ///< stiffness of the environment along the force, at the tool; 0 when unknown [N/m]
};

}  // namespace palpate
