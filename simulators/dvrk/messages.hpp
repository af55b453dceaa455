// What goes into the simulated dVRK and what comes out: commands, states and events as plain values. Verbs and topics
// bear the names that the real one has on its bus (`name_of`), so that a bus adapter is a loop over two tables. SI
// units.
#pragma once

#include <span>
#include <string_view>

#include "dvrk/text.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::dvrk {

/// A component, as the bus names it: `system`, `console`, `footpedals`, one of System::arms(), one of
/// System::teleops().
enum class Kind : unsigned char { system, console, footpedals, arm, teleop };
struct Address {
  Kind kind = Kind::system;
  int index = 0;  ///< which arm, which teleop
  friend bool operator==(const Address&, const Address&) = default;
};

/// What a message carries; a bus has one message type for each.
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

/// Which arms know a verb or a topic.
enum class ArmKind : unsigned char { mtm = 1, psm = 2, ecm = 4 };
inline constexpr unsigned kEveryArm = 7;

/// crtk_msgs/CartesianImpedanceHalfPlaneGains: per axis, force = p err + d vel + bias; p and d are negative.
struct HalfPlane {
  Vec3 p = Vec3::Zero(), d = Vec3::Zero(), bias = Vec3::Zero(), deadband = Vec3::Zero();
};
/// crtk_msgs/CartesianImpedance: `positive` rules where the error is above zero, along the axes of R_force and
/// R_torque.
struct Impedance {
  Mat3 R_force = Mat3::Identity();
  Vec3 p_force = Vec3::Zero();  ///< [m]
  Mat3 R_torque = Mat3::Identity();
  HalfPlane position_positive, position_negative, orientation_positive, orientation_negative;
};

enum class Verb : unsigned char {
  // an arm
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
  // what only a simulated arm has: a hand on the handle, a force on the tool, a fault
  hand_servo_cp,
  hand_servo_cf,
  hand_gripper,
  hand_free,
  tool_servo_cf,
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
  // pedals (simulated feet: the real ones only speak)
  press_clutch,
  press_camera,
  press_coag,
  press_bicoag,
  press_cam_plus,
  press_cam_minus,
  // a teleop
  teleop_state_command,
  set_scale,
  lock_rotation,
  lock_translation,
  set_align_MTM,
  following_mtm_body_servo_cf,
};

/// One message to one component. Only the fields of its payload matter. A bus puts numbers in as they came: what cannot
/// be (not finite, no rotation, too many joints) is refused by the component, in words.
struct Command {
  Address to;
  Verb verb = Verb::hold;
  bool flag = false;
  int button = 0;
  double value = 0.0;
  Text text;
  JointVector position, velocity, effort;  ///< as many as were sent (`joints`); position of `numbers`, too
  Pose X;                                  ///< pose, or its rotation alone
  Twist V;
  Wrench F;
  bool pose_is_valid = false, twist_is_valid = false, wrench_is_valid = false;  ///< of servo_cs
  Impedance impedance;
};

/// Joint numbers as they were sent. More than kMaxJoints are cut there, which no arm takes.
[[nodiscard]] JointVector joints(std::span<const double> numbers) noexcept;
/// From a quaternion; one that is no rotation gives NaN, which every component refuses.
[[nodiscard]] Mat3 rotation(double x, double y, double z, double w) noexcept;

/// A pose that a component may use: finite, a rotation, and within 100 m.
[[nodiscard]] bool is_rotation(const Mat3& R) noexcept;
[[nodiscard]] bool is_pose(const Pose& X) noexcept;

/// A verb, who understands it, what it is called on the bus (relative to the component) and what it carries.
struct VerbEntry {
  Verb verb;
  Kind kind;
  unsigned arms;  ///< ArmKind bits, for arms
  std::string_view name;
  Payload payload;
};
[[nodiscard]] std::span<const VerbEntry> verbs() noexcept;

enum class Topic : unsigned char {
  // an arm
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
  // a teleop
  teleop_desired_state,
  teleop_current_state,
  following,
  scale,
  rotation_locked,
  translation_locked,
  align_MTM,
};

/// An event as it stands in the table of topics; `latched`: late subscribers are given the last one.
struct TopicEntry {
  Topic topic;
  Kind kind;
  unsigned arms;
  std::string_view name;
  Payload payload;
  bool latched;
};
[[nodiscard]] std::span<const TopicEntry> topics() noexcept;

enum class State : unsigned char { DISABLED, ENABLED, PAUSED, FAULT };
[[nodiscard]] std::string_view name_of(State state) noexcept;

struct OperatingState {
  State state = State::DISABLED;
  bool is_homed = false;
  bool is_busy = false;
};

/// Something happened: the field of its topic's payload says what.
struct Event {
  Address from;
  Topic topic = Topic::status;
  double t = 0.0;  ///< [s]
  bool flag = false;
  int button = 0;
  double value = 0.0;
  OperatingState operating_state;
  Text text;
};

struct JointState {
  JointVector q, v, tau;  ///< [rad, m], [rad/s, m/s], [N m, N]
};

/// What an arm tells periodically, as of its last servo period. A field whose flag is false is sent with a zero stamp.
struct ArmState {
  double t = 0.0;  ///< stamp: since the simulation began [s]
  OperatingState operating_state;
  bool joints_valid = false;     ///< of measured_js, setpoint_js, gravity_compensation
  bool cartesian_valid = false;  ///< of everything Cartesian
  bool base_frame_valid = true;  ///< also needed by measured_cp, setpoint_cp
  JointState measured_js, setpoint_js;
  JointVector gravity_compensation;  ///< gravity_compensation/setpoint_js, effort [N m]
  Pose measured_cp, setpoint_cp, local_measured_cp, local_setpoint_cp;
  Twist measured_cv, setpoint_cv;              ///< in the base frame
  Twist local_measured_cv, local_setpoint_cv;  ///< in the TIP frame, as the real one has it
  Wrench body_measured_cf;                     ///< about the tip, in tip axes, or base axes when absolute
  Wrench spatial_measured_cf;                  ///< about the arm's own base, in its axes
  Wrench measured_cf;                          ///< about the tip, in base axes always (of measured_cs)
  Jacobian body_jacobian, spatial_jacobian;
  bool orientation_locked = false;
  JointState gripper;  ///< MTM: one joint, position only
  bool jaw_valid = false;
  JointState jaw_measured_js, jaw_setpoint_js;  ///< PSM: one joint
  Wrench F_hand;  ///< simulation only: what the MTM does to the hand that holds it, in base axes [N, N m]
};

/// What a teleop tells periodically.
struct TeleopState {
  double t = 0.0;
  Text current_state, desired_state;
  bool following = false;
  double scale = 0.2;
  Mat3 alignment_offset = Mat3::Identity();
};

}  // namespace palpate::dvrk
