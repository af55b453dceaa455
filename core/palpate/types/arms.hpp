// What an arm tells the cycle and what the cycle tells an arm, simulated or real alike.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate {

/// Leader (master arm) as its encoders report it.
struct LeaderState {
  double t = 0.0;                ///< stamp of the measurement [s]
  JointVector q;                 ///< measured joint positions [rad]
  JointVector v;                 ///< estimated joint velocities [rad/s]
  double gripper = 0.0;          ///< pinch angle, 0 = closed [rad]
  bool valid = false;            ///< false until the first measurement, or when the source says so
  Vec3 F_cell_L = Vec3::Zero();  ///< of the arm on the hand, by a load cell in the handle [N]
  bool has_load_cell = false;    ///< there is one
};

/// Follower (patient-side arm) as its encoders report it.
struct FollowerState {
  double t = 0.0;    ///< stamp [s]
  JointVector q;     ///< measured joint positions [rad, m]
  double jaw = 0.0;  ///< [rad]
  bool valid = false;
  JointVector v;    ///< joint velocities [rad/s, m/s]; empty when they are not measured
  JointVector tau;  ///< torques of its drives, at the joints [N m, N]; empty when they are not measured
};

/// Torque terms for the leader, kept apart so that each is recorded and can be switched off.
struct LeaderCommand {
  Wrench F_H_L;              ///< wrench rendered on the operator's hand, in the leader base L
  Wrench F_law_L;            ///< what the control law adds to it, at the handle
  double F_neglected = 0.0;  ///< inertia and Coriolis force that the hand feels beside it, estimated [N]
  JointVector tau_force;     ///< J^T (F_H_L + F_law_L) [N m]
  JointVector tau_gravity;   ///< G_hat(q), counterbalance included [N m]
  JointVector tau_platform;  ///< joint-4 null-space controller [N m]
  JointVector tau_friction;  ///< compensates the arm's friction [N m]
  JointVector tau_limits;    ///< soft stops before the joint limits [N m]

  /// All terms zero, for n joints.
  explicit LeaderCommand(Eigen::Index n = 0)
      : tau_force(JointVector::Zero(n)),
        tau_gravity(tau_force),
        tau_platform(tau_force),
        tau_friction(tau_force),
        tau_limits(tau_force) {}
  /// What holds the arm still; may be held for long.
  [[nodiscard]] JointVector hold() const { return tau_gravity + tau_platform; }
  /// What answers to the motion of now; must fade when nobody commands.
  [[nodiscard]] JointVector act() const { return tau_force + tau_friction + tau_limits; }
};

struct FollowerCommand {
  JointVector q;      ///< desired joint positions [rad, m]
  double jaw = 0.0;   ///< [rad]
  bool valid = true;  ///< false until the follower has been heard: send nothing
};

/// What the console says: pedals, and values that a person may change while it runs.
struct Controls {
  bool following = true;         ///< the follower follows the leader and the hand is given forces
  bool clutch = false;           ///< pedal pressed: the hand moves freely, the follower stays
  bool paused = false;           ///< simulated time stands still (simulation only)
  bool hold = false;             ///< the simulated hand leaves its path where it is; released, it goes on from there
  double stiffness_scale = 1.0;  ///< multiplies every object's stiffness
  double damping_scale = 1.0;    ///< multiplies every object's damping
  double guidance = 1.0;         ///< pedal of guidance, 0-1, for fixtures that fade with it
  Vec3 p_hand_offset_W = Vec3::Zero();  ///< added to the hand's intended position [m] (drag handle)
};

}  // namespace palpate
