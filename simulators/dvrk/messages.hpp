// Inputs and outputs of the simulated dVRK: commands, states and events as plain values, in SI units. Verbs and topics
// have the names of the real system (tables verbs() and topics()), so that a bus adapter is a loop over two tables.
#pragma once

#include <span>
#include <string_view>

#include "dvrk/text.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::dvrk {

/// Kinds of components.
enum class Kind : unsigned char {
  system,
  console,
  footpedals,
  arm,
  teleop,
  camera_teleop,  ///< teleoperation of the endoscope by both MTMs
  setup,          ///< setup joints of one PSM or ECM
  setup_cart,     ///< all setup joints
  focus,          ///< focus motor of the endoscope
};

/// Address of a component. Its name on the bus is `system`, `console`, `footpedals`, `endoscope_focus`, `SUJ`, SUJ/ARM,
/// the three arms of the camera's teleoperation, or an entry of System::arms() or System::teleops().
struct Address {
  Kind kind = Kind::system;
  int index = 0;  ///< index of the arm, of the arm that setup joints carry, or of the teleop
  friend bool operator==(const Address&, const Address&) = default;
};

/// Payload of a message; each has one message type on the bus.
enum class Payload : unsigned char {
  none,       ///< std_msgs/Empty
  flag,       ///< std_msgs/Bool
  value,      ///< std_msgs/Float64
  text,       ///< std_msgs/String, or crtk_msgs/StringStamped for state_command
  button,     ///< sensor_msgs/Joy, buttons[0]: 0 released, 1 pressed, 2 tapped
  numbers,    ///< std_msgs/Float64MultiArray
  joints,     ///< sensor_msgs/JointState
  pose,       ///< geometry_msgs/PoseStamped
  rotation,   ///< geometry_msgs/Quaternion
  wrench,     ///< geometry_msgs/WrenchStamped
  cartesian,  ///< crtk_msgs/CartesianState
  impedance,  ///< crtk_msgs/CartesianImpedance
  operating,  ///< crtk_msgs/OperatingState
};

/// Kinds of arms, as bits of the masks in VerbEntry and TopicEntry.
enum class ArmKind : unsigned char { mtm = 1, psm = 2, ecm = 4 };
inline constexpr unsigned kEveryArm = 7;  ///< all ArmKind bits

/// crtk_msgs/CartesianImpedanceHalfPlaneGains: per axis, force = p err + d vel + bias; p and d are negative. Units are
/// [N/m], [N s/m], [N], [m] for positions and [N m/rad], [N m s/rad], [N m], [rad] for orientations.
struct HalfPlane {
  Vec3 p = Vec3::Zero(), d = Vec3::Zero(), bias = Vec3::Zero(), deadband = Vec3::Zero();
};
/// crtk_msgs/CartesianImpedance: the `positive` gains apply where the error is positive, along the axes of R_force and
/// R_torque, the `negative` gains elsewhere.
struct Impedance {
  Mat3 R_force = Mat3::Identity();   ///< axes of the position gains
  Vec3 p_force = Vec3::Zero();       ///< equilibrium position [m]
  Mat3 R_torque = Mat3::Identity();  ///< equilibrium orientation, and axes of the orientation gains
  HalfPlane position_positive, position_negative, orientation_positive, orientation_negative;
};

/// Verbs, that is commands that a component understands.
enum class Verb : unsigned char {
  // arms
  state_command,
  servo_jp,
  servo_jr,
  servo_jf,
  servo_cp,
  servo_cr,
  servo_cs,
  servo_ci,
  body_servo_cf,
  spatial_servo_cf,
  move_jp,
  move_jr,
  move_cp,
  free,
  hold,
  use_gravity_compensation,
  body_set_cf_orientation_absolute,
  set_base_frame,
  set_ratio,
  set_ratio_v,
  set_ratio_a,
  lock_orientation,
  unlock_orientation,
  jaw_servo_jp,
  jaw_move_jp,
  jaw_servo_jf,
  set_tool_type,
  emulate_adapter_present,
  emulate_tool_present,
  set_endoscope_type,
  // simulated arms only: a hand on the handle, a force on the tool, the clutch button of an arm, a fault
  hand_servo_cp,
  hand_servo_cf,
  hand_gripper,
  hand_free,
  tool_servo_cf,
  emulate_arm_clutch,
  emulate_fault,
  // system
  power_on,
  power_off,
  home,
  set_volume,
  beep,
  string_to_speech,
  // console
  teleop_enable,
  teleop_select,
  teleop_unselect,
  teleop_set_scale,
  emulate_operator_present,
  emulate_clutch,
  emulate_camera,
  // Pedals. On a real console these topics are outputs; the simulation also accepts them as inputs.
  press_clutch,
  press_camera,
  press_coag,
  press_bicoag,
  press_cam_plus,
  press_cam_minus,
  // teleops
  teleop_state_command,
  set_scale,
  lock_rotation,
  lock_translation,
  set_align_MTM,
  following_mtm_body_servo_cf,
  // teleoperation of the camera
  camera_state_command,
  camera_set_scale,
  // setup joints
  setup_state_command,
  setup_servo_jp,
  setup_move_jp,
  set_reference_arm,
  // focus
  focus_lock,
  focus_in,
  focus_out,
};

/// A message to a component. Only the fields of its payload are used. A bus adapter passes numbers on unchecked; the
/// component refuses invalid ones (not finite, not a rotation, wrong number of joints) with a warning.
struct Command {
  Address to;
  Verb verb = Verb::hold;
  bool flag = false;
  int button = 0;
  double value = 0.0;
  Text text;
  JointVector position, velocity, effort;  ///< of `joints`, as many as were sent; position also of `numbers`
  Pose X;                                  ///< pose; of `rotation` the rotation alone
  Twist V;
  Wrench F;
  bool pose_is_valid = false, twist_is_valid = false, wrench_is_valid = false;  ///< flags of servo_cs
  Impedance impedance;
};

/// The numbers as a joint vector, truncated to kMaxJoints, which no arm of the dVRK has.
[[nodiscard]] JointVector joints(std::span<const double> numbers) noexcept;
/// The rotation of a quaternion; NaN, which every component refuses, if its norm is zero or not finite.
[[nodiscard]] Mat3 rotation(double x, double y, double z, double w) noexcept;

/// True if a component can use the value: finite, a rotation matrix, and a position within 100 m.
[[nodiscard]] bool is_rotation(const Mat3& R) noexcept;
[[nodiscard]] bool is_pose(const Pose& X) noexcept;

/// A row of the table of verbs.
struct VerbEntry {
  Verb verb;
  Kind kind;              ///< kind of the components that understand it
  unsigned arms;          ///< kinds of arms that understand it, as ArmKind bits
  std::string_view name;  ///< on the bus, relative to the component
  Payload payload;
};
/// The table of verbs.
[[nodiscard]] std::span<const VerbEntry> verbs() noexcept;

/// Topics of the events.
enum class Topic : unsigned char {
  // arms
  operating_state,
  desired_state,
  current_state,
  goal_reached,
  ratio,
  ratio_v,
  ratio_a,
  gripper_closed,
  gripper_pinch,
  orientation_locked,
  tool_type,
  tool_type_request,
  arm_clutch,
  endoscope_type,
  // every component
  status,
  warning,
  error,
  // system
  volume,
  // console
  teleop_enabled,
  teleop_selected,
  teleop_unselected,
  teleop_scale,
  operator_present,
  clutch,
  camera,
  // pedals
  pedal_clutch,
  pedal_camera,
  pedal_coag,
  pedal_bicoag,
  pedal_cam_plus,
  pedal_cam_minus,
  // teleops
  teleop_desired_state,
  teleop_current_state,
  following,
  scale,
  rotation_locked,
  translation_locked,
  align_MTM,
  // focus
  locked,
  focusing_in,
  focusing_out,
};

/// A row of the table of topics, with the fields of VerbEntry; latched: late subscribers receive the last event.
struct TopicEntry {
  Topic topic;
  Kind kind;
  unsigned arms;
  std::string_view name;
  Payload payload;
  bool latched;
};
/// The table of topics.
[[nodiscard]] std::span<const TopicEntry> topics() noexcept;

/// Operating states of an arm (crtk_msgs/OperatingState).
enum class State : unsigned char { DISABLED, ENABLED, PAUSED, FAULT };
/// Name of a state on the bus.
[[nodiscard]] std::string_view name_of(State state) noexcept;

/// crtk_msgs/OperatingState.
struct OperatingState {
  State state = State::DISABLED;
  bool is_homed = false;
  bool is_busy = false;
};

/// An event; the field that belongs to the payload of its topic holds the value.
struct Event {
  Address from;
  Topic topic = Topic::status;
  double t = 0.0;  ///< time since the simulation began [s]
  bool flag = false;
  int button = 0;
  double value = 0.0;
  OperatingState operating_state;
  Text text;
};

/// Positions, velocities and torques of joints.
struct JointState {
  JointVector q, v, tau;  ///< [rad, m], [rad/s, m/s], [N m, N]
};

/// Periodically published state of an arm, as of its last servo period. A field whose flag is false is sent with a zero
/// stamp.
struct ArmState {
  double t = 0.0;  ///< stamp: time since the simulation began [s]
  OperatingState operating_state;
  bool joints_valid = false;     ///< flag of measured_js, setpoint_js, gravity_compensation
  bool cartesian_valid = false;  ///< flag of all Cartesian fields
  bool base_frame_valid = true;  ///< additional flag of measured_cp and setpoint_cp
  JointState measured_js, setpoint_js;
  JointVector gravity_compensation;  ///< gravity_compensation/setpoint_js, effort [N m]
  Pose measured_cp, setpoint_cp, local_measured_cp, local_setpoint_cp;  ///< of the tip; local: in the arm's own base
  Twist measured_cv, setpoint_cv;                                       ///< in the base frame
  Twist local_measured_cv, local_setpoint_cv;                           ///< in the TIP frame, as in the real component
  Wrench body_measured_cf;     ///< about the tip, in tip axes, or in base axes if set to absolute
  Wrench spatial_measured_cf;  ///< about the origin of the arm's own base, in its axes
  Wrench measured_cf;          ///< about the tip, always in base axes (part of measured_cs)
  Jacobian body_jacobian,
      spatial_jacobian;  ///< body: of the tip, in tip axes; spatial: of the point at the base's origin, in base axes
  bool orientation_locked = false;
  JointState gripper;  ///< MTM: one joint, position only
  bool jaw_valid = false;
  JointState jaw_measured_js, jaw_setpoint_js;  ///< PSM: one joint
  Pose base_frame;                              ///< of the arm's own base, in the frame of measured_cp
  std::string_view reference;     ///< name of the arm in whose tip frame measured_cp is told; empty: the cart's frame
  JointState setup_js;            ///< of the setup joints of a PSM or an ECM [m, rad]
  Pose setup_cp, local_setup_cp;  ///< of the arm's base, in the frame of measured_cp and in the cart's
  Wrench F_hand;  ///< simulation only: wrench of the MTM on the hand that holds it, in base axes [N, N m]
};

/// Periodically published state of a teleop.
struct TeleopState {
  double t = 0.0;  ///< stamp: time since the simulation began [s]
  Text current_state, desired_state;
  bool following = false;
  double scale = 0.2;
  Mat3 alignment_offset = Mat3::Identity();  ///< R_MTM^T R_PSM
};

}  // namespace palpate::dvrk
