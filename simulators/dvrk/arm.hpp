// One arm of the simulated dVRK: operating state, control modes and commands as in the real one's component
// (sawIntuitiveResearchKit 2.4), over a simulated body. A servo period is run(); the body moves in step(), more often.
//
//   arm_states.cpp    power, homing, pause, fault
//   arm_commands.cpp  what may be asked of it
//   arm_motion.cpp    when it does it
//   arm_control.cpp   what it orders from its joints in each mode
//   arm_measure.cpp   what it tells
#pragma once

#include <memory>

#include "dvrk/body.hpp"
#include "dvrk/gripper.hpp"
#include "dvrk/instrument.hpp"
#include "dvrk/outbox.hpp"
#include "dvrk/trajectory.hpp"

namespace palpate::dvrk {

inline constexpr double kGripperOpen = std::numbers::pi / 3.0;  ///< of a gripper that nobody pinches [rad]

/// No number of a client is larger than this once it is used: what it is multiplied with stays finite.
template <typename Vector>
[[nodiscard]] Vector bounded(const Vector& x) noexcept {
  static constexpr double kMost = 1e6;
  return x.unaryExpr([](double value) { return value != value ? 0.0 : std::clamp(value, -kMost, kMost); });
}

class Arm {
 public:
  /// Throws std::invalid_argument naming the arm, the option and the mend.
  Arm(ArmSpec spec, Address at, Outbox& out);

  void start() noexcept;                        ///< tells its first states
  bool apply(const Command& command) noexcept;  ///< false: not a verb of this arm
  void run(double t, double dt) noexcept;       ///< one servo period of dt, which ends at t [s]
  void step(double dt) noexcept;                ///< the body moves on

  [[nodiscard]] const ArmSpec& spec() const noexcept { return spec_; }
  [[nodiscard]] arm::Arm& model() noexcept { return model_; }
  [[nodiscard]] const ArmState& state() const noexcept { return state_; }
  [[nodiscard]] JointState truth() const noexcept { return body_->truth(); }
  [[nodiscard]] const Instrument& instrument() const noexcept { return instrument_; }
  [[nodiscard]] const Pose& base_frame() const noexcept { return base_frame_; }
  /// Enabled and homed.
  [[nodiscard]] bool ready() const noexcept;
  [[nodiscard]] int errors() const noexcept { return errors_; }  ///< so many were told
  [[nodiscard]] const Text& last_error() const noexcept { return last_error_; }

  // What a teleop asks, and a bus through apply().
  void state_command(std::string_view command) noexcept;
  void hold() noexcept;
  void servo_jp(const JointVector& q, const JointVector& v) noexcept;
  void servo_cp(const Pose& X, const Twist& V) noexcept;
  void move_cp(const Pose& X) noexcept;
  void body_servo_cf(const Wrench& F) noexcept;
  void use_gravity_compensation(bool use) noexcept { gravity_compensation_ = use; }
  void body_set_cf_orientation_absolute(bool absolute) noexcept { absolute_ = absolute; }
  void lock_orientation(const Mat3& R) noexcept;
  void unlock_orientation() noexcept;
  void jaw_servo_jp(double q) noexcept;

 private:
  enum class Phase : unsigned char { disabled, powering, enabled, calibrating, homing, homed, paused, fault, engaging };
  enum class Space : unsigned char { undefined, joint, cartesian };
  enum class Mode : unsigned char { undefined, position, trajectory, effort };
  enum class Cf : unsigned char { body, spatial, impedance };

  // arm_states.cpp
  static std::string_view name_of(Phase phase) noexcept;
  void state_events() const noexcept;
  void set_desired(Phase phase) noexcept;
  void enter(Phase phase) noexcept;
  void power(bool on) noexcept;
  void run_phase(double dt) noexcept;
  void run_homing(double dt) noexcept;
  void engage() noexcept;
  void run_engaging(double dt) noexcept;
  void check_tracking() noexcept;
  void operating(State state, bool busy) noexcept;
  void busy(bool busy) noexcept;
  void unhome() noexcept;
  void error(const Text& words) noexcept;
  void fault(const Text& words) noexcept;
  [[nodiscard]] bool is_homed() const noexcept;
  [[nodiscard]] bool is_joint_ready() const noexcept { return powered_ && biased_; }
  [[nodiscard]] bool is_cartesian_ready() const noexcept;

  // arm_commands.cpp
  bool takes(const Command& command, Payload payload) noexcept;
  bool apply_motion(const Command& command) noexcept;
  bool apply_effort(const Command& command) noexcept;
  bool apply_rest(const Command& command) noexcept;

  // arm_motion.cpp
  bool ready_for(std::string_view method, Space space) noexcept;
  bool set_mode(Space space, Mode mode) noexcept;
  [[nodiscard]] bool past_cannula() noexcept;
  void servo_jr(const JointVector& dq) noexcept;
  void servo_cr(const Pose& dX) noexcept;
  void servo_cs(const Command& command) noexcept;
  void servo_jf(const JointVector& tau) noexcept;
  void servo_cf(std::string_view method, Cf cf, const Wrench& F) noexcept;
  void move_jp(const JointVector& q) noexcept;
  void move_jr(const JointVector& dq) noexcept;
  void start_move(const JointVector& goal) noexcept;
  void stop_move(bool reached) noexcept;
  void free() noexcept;
  void set_ratio(Verb verb, double ratio) noexcept;
  void jaw(const Command& command) noexcept;
  void stop_jaw() noexcept;

  // arm_control.cpp
  void control(double dt) noexcept;
  bool servo_pose(double dt) noexcept;
  void order_positions(const JointVector& q, const JointVector& v, const JointVector& tau) noexcept;
  void run_effort(double dt) noexcept;
  [[nodiscard]] JointVector effort(double dt) noexcept;
  void watch_current(const JointVector& tau, double dt) noexcept;
  void hold_orientation(double dt) noexcept;
  [[nodiscard]] JointVector clipped(const JointVector& q) const noexcept;
  [[nodiscard]] JointVector feed_forward() const noexcept;

  // arm_measure.cpp
  void measure() noexcept;
  void measure_cartesian() noexcept;

  ArmSpec spec_;
  arm::Arm model_;
  std::unique_ptr<Body> body_;
  Voice voice_;
  Instrument instrument_;
  Gripper gripper_;
  Surroundings around_;
  double pinch_;  ///< angle of the gripper [rad]
  Eigen::Index n_;

  Phase phase_ = Phase::disabled, desired_ = Phase::disabled;
  Phase paused_phase_ = Phase::disabled, paused_desired_ = Phase::disabled;
  OperatingState operating_;
  bool powered_ = false, biased_ = false;
  double in_phase_ = 0.0;  ///< since it was entered [s]
  bool settling_ = false;  ///< homing waits for an arm that was falling
  int engaging_ = 0;       ///< motions of a tool's disks that have begun
  int errors_ = 0;
  Text last_error_;
  int refused_ = 0;             ///< commands since the arm was last ready
  double told_refusal_ = -1e9;  ///< when that was last told [s]
  bool told_cannula_ = false;

  Space space_ = Space::undefined;
  Mode mode_ = Mode::undefined;
  bool new_goal_ = false;
  JointVector goal_q_, goal_v_, goal_tau_;  ///< of position control
  Pose goal_X_;                             ///< the same in Cartesian space, in the base frame
  Twist goal_V_;
  Wrench goal_F_;
  bool goal_pose_ = false, goal_twist_ = false, goal_wrench_ = false;
  Trajectory path_;
  double ratio_v_ = 1.0, ratio_a_ = 1.0;
  JointVector servo_tau_;                          ///< of servo_jf
  std::array<double, kMaxJoints> over_current_{};  ///< so long each joint's torque has been above its limit [s]
  Cf cf_ = Cf::body;
  Wrench servo_F_;
  Impedance impedance_;
  bool absolute_ = false, gravity_compensation_ = true;
  bool locked_ = false;
  Mat3 R_locked_ = Mat3::Identity();  ///< in the arm's own base
  Pose base_frame_;

  Order order_;
  ArmState state_;
};

}  // namespace palpate::dvrk
