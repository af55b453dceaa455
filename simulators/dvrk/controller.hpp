// The controller of an arm: control space and mode, goals, trajectories, and the order to the joint servos in each
// servo period. It refuses commands while the arm is not ready; it never changes the operating state itself.
//
//   controller.cpp          control modes, readiness, the order to the servos
//   controller_apply.cpp    commands from the bus
//   controller_goals.cpp    servo commands: positions, poses, torques, wrenches
//   controller_moves.cpp    point-to-point motions of the joints and of the jaw
//   controller_effort.cpp   torque control
#pragma once

#include <array>

#include "dvrk/arm_context.hpp"
#include "dvrk/trajectory.hpp"

namespace palpate::dvrk {

/// Control space and control mode, as in the real component.
enum class Space : unsigned char { undefined, joint, cartesian };
enum class Mode : unsigned char { undefined, position, trajectory, effort };

/// Converts commands to orders for the joint servos of an arm.
class Controller {
 public:
  /// Keeps the address of the arm.
  explicit Controller(ArmContext& arm);

  /// Applies a command; false if the controller has no such verb.
  bool apply(const Command& command) noexcept;

  // Commands that a teleoperation sends as well: joints [rad, m], [rad/s, m/s]; poses, twists and orientations in the
  // base frame; body_servo_cf in tip axes, or in base axes if set to absolute [N, N m].
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

  // Calls of the state machine.
  /// Servos off and control mode undefined; an active trajectory is aborted.
  void reset() noexcept;
  /// While blocked, every command is refused.
  void block(bool blocked) noexcept { blocked_ = blocked; }
  /// Sets the control mode. Returns false if the arm refuses Cartesian control because its tool is inside the cannula.
  bool set_mode(Space space, Mode mode) noexcept;
  /// Leaves the control mode; the servos hold the last ordered position, or the measured one if they were off.
  void rest() noexcept;
  /// Orders the joint positions q at rest. clip: clips them to the joint limits.
  void order_rest(const JointVector& q, bool clip) noexcept;
  /// Starts a trajectory from the ordered position to the joint positions `goal` [rad, m].
  void start_path(const JointVector& goal) noexcept;
  [[nodiscard]] bool path_active() const noexcept { return path_.active(); }
  /// One servo period along the trajectory.
  void follow_path(double dt, bool clip) noexcept;
  /// One servo period of the active control mode. Returns the reason of a fault; empty: no fault.
  [[nodiscard]] Text control(double dt) noexcept;
  /// Reason of a fault if a joint in position control is too far from its setpoint; empty: no fault.
  [[nodiscard]] Text tracking_fault() const noexcept;
  /// Reports that the jaw has reached the goal of its move.
  void jaw_arrived() noexcept;

  [[nodiscard]] const Order& order() const noexcept { return order_; }
  [[nodiscard]] bool orientation_locked() const noexcept { return locked_; }
  [[nodiscard]] bool forces_in_base_axes() const noexcept { return absolute_; }
  [[nodiscard]] bool compensates_gravity() const noexcept {
    return gravity_compensation_ && arm_.spec.has_gravity_model;
  }

 private:
  enum class Cf : unsigned char { body, spatial, impedance };
  /// Goal of position control. The Cartesian part is in the base frame.
  struct Goal {
    bool is_new = false;
    JointVector q, v, tau;
    Pose X;
    Twist V;
    Wrench F;
    bool has_pose = false, has_twist = false, has_wrench = false;
  };
  /// Goal of torque control.
  struct Effort {
    JointVector tau;  ///< joint torques of servo_jf [N m, N]
    Cf kind = Cf::body;
    Wrench F;
    Impedance impedance;
  };
  /// State for reporting repeated refusals, at most every kReportPeriod.
  struct Refusals {
    int count = 0;              ///< refusals since the arm was last ready
    double reported_at = -1e9;  ///< time of the last report [s]
    bool cannula_reported = false;
  };

  bool apply_servo(const Command& command) noexcept;
  bool apply_move(const Command& command) noexcept;
  bool apply_option(const Command& command) noexcept;

  bool ready_for(std::string_view method, Space space) noexcept;
  [[nodiscard]] bool past_cannula() noexcept;
  void enter_mode(Mode mode) noexcept;
  [[nodiscard]] JointVector clipped(const JointVector& q) const noexcept;
  [[nodiscard]] JointVector feed_forward() const noexcept;
  void order_positions(const JointVector& q, const JointVector& v, const JointVector& tau, bool clip) noexcept;
  bool servo_pose(double dt) noexcept;

  void servo_jr(const JointVector& dq) noexcept;
  void servo_cr(const Pose& dX) noexcept;
  void servo_cs(const Command& command) noexcept;
  void servo_jf(const JointVector& tau) noexcept;
  void servo_cf(std::string_view method, Cf kind, const Wrench& F) noexcept;
  void free() noexcept;
  void set_goal(const JointVector& q, const JointVector& v) noexcept;

  void move_jp(const JointVector& q) noexcept;
  void move_jr(const JointVector& dq) noexcept;
  void start_move(const JointVector& goal) noexcept;
  void stop_move(bool reached) noexcept;
  void set_ratio(Verb verb, double ratio) noexcept;
  void jaw_move_jp(double q) noexcept;
  void jaw_servo_jf(double tau) noexcept;

  [[nodiscard]] Text run_effort(double dt) noexcept;
  [[nodiscard]] JointVector effort() const noexcept;
  [[nodiscard]] Text current_fault(const JointVector& tau, double dt) noexcept;
  void hold_orientation(double dt) noexcept;

  ArmContext& arm_;
  Eigen::Index n_;
  Space space_ = Space::undefined;
  Mode mode_ = Mode::undefined;
  bool blocked_ = false;
  Refusals refusals_;
  Goal goal_;
  Trajectory path_;
  double ratio_v_ = 1.0, ratio_a_ = 1.0;  ///< factors of the speed and acceleration limits of trajectories
  Effort effort_;
  std::array<double, kMaxJoints> over_current_{};  ///< time for which each torque has been above its limit [s]
  bool absolute_ = false;                          ///< body_servo_cf is in base axes, not in tip axes
  bool gravity_compensation_ = true;
  bool locked_ = false;
  Mat3 R_locked_ = Mat3::Identity();  ///< locked orientation in the arm's own base
  Order order_;
};

}  // namespace palpate::dvrk
