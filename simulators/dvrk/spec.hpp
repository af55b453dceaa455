// What the simulated dVRK is built from. palpate/simulators/dvrk.py fills it from the arm models; defaults are the real
// one's.
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

/// One arm. Joint vectors (n,).
struct ArmSpec {
  std::string name;  ///< such as MTMR: its place on the bus
  ArmKind kind;
  arm::Arm model;

  bool dynamic = true;                ///< moved by torques (MTMs always), or servoed joints that no torque moves
  plant::LeaderOptions leader{};      ///< drives, friction, encoders of a dynamic arm
  plant::FollowerOptions follower{};  ///< joint servos of the other
  plant::HandOptions hand{};          ///< of whoever holds an MTM
  JointVector P{}, D{};               ///< position control of a dynamic arm [N m/rad, N/m], [N m s/rad, N s/m]
  JointVector tracking_error{};       ///< beyond it position control stops with a fault [rad, m]
  JointVector v_max{}, a_max{};       ///< of trajectories at ratio 1
  JointVector start{}, home{};        ///< joints at power-up and after homing
  bool has_gravity_model = true;      ///< use_gravity_compensation does something
  double platform_gain = 0.5;         ///< of joint 4 of an MTM, 0..1
  Pose base_frame{};                  ///< measured_cp = base_frame * local/measured_cp

  int cannula_link = -1;  ///< link whose origin must be past the cannula for Cartesian control; -1: no matter
  double jaw_min = 0.0, jaw_max = 0.0, jaw_v_max = 0.0, jaw_a_max = 0.0;  ///< [rad, rad/s, rad/s^2]
  double jaw_tau_max = 0.16;                                              ///< [N m]
  std::string tool_type{};                                                ///< what is mounted at first; empty: nothing

  double power_time = 0.3;  ///< from enable to powered [s]
  double bias_time = 0.5;   ///< of reading encoders from potentiometers [s]
};

/// MTM and PSM, or camera teleoperation of both MTMs and the ECM. Indices are into SystemSpec::arms.
struct TeleopSpec {
  int mtm = 0, psm = 0;
  double scale = 0.2;
  bool align_MTM = true, rotation_locked = false, translation_locked = false;
  double orientation_tolerance = 5.0 * std::numbers::pi / 180.0;  ///< to start with [rad]
  double gripper_threshold = 40.0 * std::numbers::pi / 180.0;     ///< pinch range that says: ready [rad]
  double roll_threshold = 4.0 * std::numbers::pi / 180.0;         ///< or roll range [rad]
  double jaw_rate = 4.0 * std::numbers::pi;                       ///< of the gripper's ghost [rad/s]
  double jaw_rate_after_clutch = 0.2 * std::numbers::pi;          ///< until it caught up [rad/s]
  double jaw_caught_up = 2.0 * std::numbers::pi / 180.0;          ///< [rad]
  double gripper_zero = 0.0, gripper_max = std::numbers::pi / 3;  ///< pinch of closed and of open jaws [rad]
};

struct SystemSpec {
  std::vector<ArmSpec> arms;
  std::vector<TeleopSpec> teleops;
  int camera_mtml = -1, camera_mtmr = -1, camera_ecm = -1;  ///< arms of the camera pedal's teleop; -1: none
};

}  // namespace palpate::dvrk
