// State that an arm reports to the haptic cycle, and commands that the cycle sends to an arm. Simulated and real arms
// use the same types.
#pragma once

#include <limits>

#include "palpate/types/spatial.hpp"

namespace palpate {

/// Measured state of the leader (master arm).
struct LeaderState {
  double t = 0.0;                ///< time stamp of the measurement [s]
  JointVector q;                 ///< measured joint positions (n,) [rad]
  JointVector v;                 ///< estimated joint velocities (n,) [rad/s]
  double gripper = 0.0;          ///< pinch angle of the gripper, 0 = closed [rad]
  bool valid = false;            ///< false until the first measurement, and while the source reports an invalid state
  Vec3 F_cell_L = Vec3::Zero();  ///< force of the arm on the hand in L, measured by a load cell in the handle [N]
  bool has_load_cell = false;    ///< true if the handle has a load cell
};

/// Measured state of the follower (patient-side arm).
struct FollowerState {
  double t = 0.0;      ///< time stamp of the measurement [s]
  JointVector q;       ///< measured joint positions (n,) [rad, m]
  double jaw = 0.0;    ///< measured jaw angle, 0 = closed [rad]
  bool valid = false;  ///< false until the first measurement, and while the source reports an invalid state
  JointVector v;       ///< joint velocities (n,) [rad/s, m/s]; empty when they are not measured
  JointVector tau;     ///< drive torques at the joints (n,) [N m, N]; empty when they are not measured
};

/// Torque terms for the leader. The terms stay separate so that each can be recorded and switched off.
struct LeaderCommand {
  Wrench F_H_L;              ///< wrench rendered on the operator's hand, expressed in the leader base L
  Wrench F_law_L;            ///< wrench that the control law adds to F_H_L at the handle, expressed in L
  double F_neglected = 0.0;  ///< estimated inertia and Coriolis force that the hand feels in addition [N]
  JointVector tau_force;     ///< J^T (F_H_L + F_law_L), within the drive limits [N m]
  JointVector tau_gravity;   ///< G_hat(q): torque that balances the weight and the counterbalance spring [N m]
  JointVector tau_platform;  ///< torque of the joint-4 null-space controller [N m]
  JointVector tau_friction;  ///< torque that compensates the arm's friction [N m]
  JointVector tau_limits;    ///< torque of the soft stops near the joint limits [N m]

  /// All terms are zero vectors for n joints.
  explicit LeaderCommand(Eigen::Index n = 0)
      : tau_force(JointVector::Zero(n)),
        tau_gravity(tau_force),
        tau_platform(tau_force),
        tau_friction(tau_force),
        tau_limits(tau_force) {}
  /// Torque that supports the arm at rest [N m]. It stays safe when commands stop.
  [[nodiscard]] JointVector support_torque() const { return tau_gravity + tau_platform; }
  /// Torque that responds to the present motion and contact [N m]. It must fade out when commands stop.
  [[nodiscard]] JointVector response_torque() const { return tau_force + tau_friction + tau_limits; }
};

/// Joint command for the follower.
struct FollowerCommand {
  JointVector q;      ///< desired joint positions (n,) [rad, m]
  double jaw = 0.0;   ///< desired jaw angle [rad]
  bool valid = true;  ///< false until the first follower state has arrived; an invalid command is not sent
};

/// Console inputs: pedals, and values that the operator may change at run time.
struct Controls {
  bool following = true;          ///< the follower follows the leader, and the hand receives forces
  bool clutch = false;            ///< clutch pedal pressed: the hand moves freely, the follower stays
  bool camera = false;            ///< camera pedal pressed: the hands move the endoscope, the follower stays
  bool power = true;              ///< the arms shall have power
  bool home = true;               ///< the arms shall be homed
  bool operator_present = true;   ///< an operator is at the console, with the head in the viewer
  bool hold_all = false;          ///< everything shall hold where it is
  bool recover_by_itself = true;  ///< a fault is left as soon as its cause is gone
  int recover_requests = 0;       ///< a new number leaves a fault whose cause is gone
  int take_back_requests = 0;     ///< a new number takes the shift of the tool against the hand back (Mapping)
  bool lock_rotation = false;     ///< the tool keeps its orientation while it follows
  bool lock_translation = false;  ///< the tool keeps its position while it follows, and the hand feels no force
  double scale = 0.0;             ///< tool motion per hand motion; 0: as in the options [-]
  Eigen::Vector4d quat_WL =
      Eigen::Vector4d::Zero();          ///< orientation of the leader base in W, w x y z; zero: as in the options
  bool paused = false;                  ///< simulated time stands still (simulation only)
  bool hand_paused = false;             ///< the simulated hand pauses on its path; it resumes there on release
  double stiffness_scale = 1.0;         ///< factor on the stiffness of every object [-]
  double damping_scale = 1.0;           ///< factor on the damping of every object [-]
  double guidance = 1.0;                ///< guidance pedal, 0-1: activation of the fixtures that fade with it [-]
  Vec3 p_hand_offset_W = Vec3::Zero();  ///< offset of the simulated hand from its path, set by dragging [m]
  /// Pinch angle of the simulated hand instead of its path's [rad]; NaN: as the path says.
  double hand_pinch = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace palpate
