// Specification of a simulated dVRK. palpate/simulators/dvrk.py fills it from the arm models. The defaults are those of
// the real system.
#pragma once

#include <numbers>
#include <string>
#include <vector>

#include "dvrk/messages.hpp"
#include "palpate/arm/arm.hpp"
#include "palpate/plant/follower.hpp"
#include "palpate/plant/hand.hpp"
#include "palpate/plant/leader.hpp"

namespace palpate::dvrk {

/// Specification of an arm with n joints; joint vectors have n entries.
struct ArmSpec {
  std::string name;  ///< name on the bus, such as MTMR
  ArmKind kind;
  arm::Arm model;

  bool dynamic = true;                ///< true: moved by torques (MTMs always); false: ideal joint servos
  plant::LeaderOptions leader{};      ///< drives, friction and encoders of a dynamic arm
  plant::FollowerOptions follower{};  ///< joint servos of any other arm
  plant::HandOptions hand{};          ///< hand that holds an MTM
  JointVector P{}, D{};               ///< PD gains of a dynamic arm [N m/rad, N/m], [N m s/rad, N s/m]
  JointVector tracking_error{};       ///< largest tracking error of position control before a fault [rad, m]
  JointVector v_max{}, a_max{};       ///< limits of trajectories at ratio 1 [rad/s, m/s], [rad/s^2, m/s^2]
  JointVector start{}, home{};        ///< joint positions at power-up and after homing [rad, m]
  bool has_gravity_model = true;      ///< false: use_gravity_compensation has no effect
  double platform_gain = 0.5;         ///< gain of the null-space controller of an MTM's joint 4 [0-1]
  Pose base_frame{};                  ///< measured_cp = base_frame * local/measured_cp

  int cannula_link = -1;  ///< link whose origin must be past the cannula for Cartesian control; -1: no such check
  double jaw_min = 0.0, jaw_max = 0.0, jaw_v_max = 0.0, jaw_a_max = 0.0;  ///< [rad], [rad/s], [rad/s^2]
  double jaw_tau_max = 0.16;                                              ///< [N m]
  std::string tool_type{};                                                ///< tool mounted at the start; empty: no tool

  double power_time = 0.3;  ///< time from enabling to powered [s]
  double bias_time = 0.5;   ///< time for setting the encoders from the potentiometers [s]
};

/// Teleoperation of a PSM by an MTM. The indices refer to SystemSpec::arms.
struct TeleopSpec {
  int mtm = 0, psm = 0;
  double scale = 0.2;  ///< tool motion per hand motion [-]
  bool align_MTM = true, rotation_locked = false, translation_locked = false;
  double orientation_tolerance = 5.0 * std::numbers::pi / 180.0;  ///< largest misalignment to start with [rad]
  double gripper_threshold = 40.0 * std::numbers::pi / 180.0;     ///< change of pinch that shows readiness [rad]
  double roll_threshold = 4.0 * std::numbers::pi / 180.0;         ///< change of roll that shows readiness [rad]
  double jaw_rate = 4.0 * std::numbers::pi;                       ///< rate limit of the jaw's gripper angle [rad/s]
  double jaw_rate_after_clutch = 0.2 * std::numbers::pi;          ///< the same until the jaw has caught up [rad/s]
  double jaw_caught_up = 2.0 * std::numbers::pi / 180.0;          ///< difference that counts as caught up [rad]
  double gripper_zero = 0.0, gripper_max = std::numbers::pi / 3;  ///< pinch of closed and of open jaws [rad]
};

/// Specification of a system.
struct SystemSpec {
  std::vector<ArmSpec> arms;
  std::vector<TeleopSpec> teleops;
  int camera_mtml = -1, camera_mtmr = -1,
      camera_ecm = -1;       ///< arms of the camera teleoperation; -1: no such teleoperation
  bool head_sensor = false;  ///< the operator's presence comes from a head sensor, not from the coag pedal
};

}  // namespace palpate::dvrk
