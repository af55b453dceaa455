// The haptic cycle for devices on a network that exchange poses and wrenches: CRTK leaders and followers
// (collaborative-robotics.github.io). Messages arrive one by one; each step returns a wrench, and a goal for the
// follower if Palpate runs the teleoperation. To the haptics (haptics.hpp) it adds the checks that decide when a force
// is allowed.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "palpate/arm/arm.hpp"
#include "palpate/loop/bodies.hpp"
#include "palpate/loop/crtk_velocity.hpp"
#include "palpate/loop/crtk_watch.hpp"
#include "palpate/loop/haptics.hpp"
#include "palpate/loop/instruments.hpp"
#include "palpate/loop/reach.hpp"

namespace palpate::loop {

/// Options of the cycle. X_WL is the pose of the frame in which the leader reports measured_cp.
struct CrtkOptions : HapticsOptions {
  Pose X_WB;                      ///< pose of the frame in which the follower reports measured_cp, in the world
  bool own_teleop = false;        ///< Palpate moves the follower; otherwise another teleoperation does
  bool virtual_follower = false;  ///< no follower: the tool follows the mapped goal within the reach of the arm's model
  bool tip_frame = false;         ///< the leader takes wrenches in the frame of its tip, not in that of measured_cp
  bool needs_operator = true;     ///< own_teleop: the operator must be reported as present
  bool needs_state = true;        ///< the arms must report the operating state ENABLED
  JointVector q_follower0;        ///< initial joint positions of a virtual follower [rad, m]
  WatchOptions watch;             ///< limits for the streams of messages
  double release = 0.03;          ///< time of the linear ramp to zero force after a fault or a pedal [s]
  double settle = 0.1;            ///< time without a fault before force is allowed again [s]
  double max_lag = 0.03;          ///< largest distance of the follower from its goal [m]
  double max_period_ratio = 2.5;  ///< largest mean interval between states of the leader, in periods of the cycle [-]
};

/// States that console and arms report. Unknown states count as false.
struct CrtkGates {
  bool following = false;                                 ///< the teleoperation is switched on
  bool operator_present = false;                          ///< an operator is at the console
  bool clutch = false;                                    ///< clutch pedal is pressed
  bool camera = false;                                    ///< camera pedal is pressed
  bool leader_enabled = false, follower_enabled = false;  ///< operating state is ENABLED, and the arm is homed
  bool second_writer = false;                             ///< another node publishes wrenches to the same arm
  bool other_teleop = false;                              ///< own_teleop: another teleoperation is on as well
  bool frame_unsure = false;  ///< the arm may read wrenches in another frame, or not compensate its own weight
  bool guarded = false;       ///< the guardian has latched, or is missing
  bool two_sources = false;   ///< several nodes publish one of the inputs: their messages must not be passed on
  bool no_listener = false;   ///< nobody receives the wrenches
  bool base_moved = false;    ///< an arm reports its pose in another frame than at the start
};

/// Result of a step.
struct CrtkOutput {
  Tick tick{};
  Wrench F;                  ///< wrench to command, in the frame of the leader or of its tip [N, N m]
  bool command = false;      ///< true: send F; false: send no wrench at all
  Pose X_BT_goal;            ///< goal of the tool
  double jaw = 0.0;          ///< goal of the jaw angle [rad]
  double tau_gripper = 0.0;  ///< torque on the operator's fingers, positive when it opens them [N m]
  bool move = false;         ///< true: send the goals of tool and jaw
};

/// The wrench F is always finite and below its cap, and in real time it never grows faster than its rate cap, whatever
/// the intervals between steps. It is zero at the latest `release` after a condition forbids it. After a fault, contact
/// and map are reset.
class CrtkCycle {
 public:
  /// follower: its model, for a virtual follower and for spheres on its links. Throws std::invalid_argument naming an
  /// invalid option.
  CrtkCycle(const CrtkOptions& options, std::optional<arm::Arm> follower);

  // Messages: stamps [s] and numbers as received, `now` the time of arrival. Quaternions are x y z w, twists are in L,
  // gripper and jaw angles [rad]. All functions are noexcept, without allocation or lock.
  void leader_pose(double stamp, const Vec3& p_LH, const Eigen::Vector4d& quat_LH, ClockTime now) noexcept;
  void leader_twist(double stamp, const Twist& V_LH, ClockTime now) noexcept;
  void leader_joints(double stamp, const double* q, std::size_t n) noexcept;
  void gripper(double stamp, const double* angle, std::size_t n) noexcept;
  void follower_pose(double stamp, const Vec3& p_BT, const Eigen::Vector4d& quat_BT, ClockTime now) noexcept;
  void follower_joints(double stamp, const double* q, std::size_t n, ClockTime now) noexcept;
  void jaw(double stamp, const double* angle, std::size_t n) noexcept;
  /// Motion scale that another teleoperation reports [-].
  void set_scale(double scale) noexcept;
  void set_gates(const CrtkGates& gates) noexcept { gates_ = gates; }
  void set_controls(const Controls& controls) noexcept { in_.controls = controls; }
  /// Replaces the scene, which must outlive its use. Contact goes on: see forget_contacts().
  void set_scene(const scene::Snapshot& scene) noexcept { in_.scene = &scene; }
  /// Resets contact to the tool's position, for a scene with other objects.
  void forget_contacts() noexcept { haptics_.forget_contacts(); }
  /// An additional force on the tool from the next step on, in W [N].
  void push(const Vec3& F_W) noexcept { F_pushed_W_ = F_W; }
  /// Replaces the fixtures, which must outlive their use.
  void take(const guidance::ActiveFixtures& active) noexcept { haptics_.take(active); }

  /// Puts the tool among the instruments of other cycles, which push it from the next step on. Not to be called while
  /// the cycle runs. Throws std::invalid_argument without a model of the follower, or naming an invalid value.
  void join(std::shared_ptr<Board> board, int index, std::vector<ToolCapsule> capsules, contact::InstrumentLaw law);
  /// Puts the tool among rigid bodies, from the next step on; the owner of the engine advances it. Not to be called
  /// while the cycle runs. Throws std::invalid_argument without a model of the follower.
  void join_bodies(std::shared_ptr<Bodies> bodies, int tool);

  /// Reports a fault of the device, as a bit of Status: it counts at the next step, like a damaged message.
  void report(std::uint64_t fault) noexcept { refuse(fault); }

  /// One tick, at any interval from the last one. The result is valid until the next step.
  const CrtkOutput& step(ClockTime now) noexcept;
  /// Resets the wrench to zero, because another process has set the device's force to zero.
  void reset_wrench() noexcept;

  [[nodiscard]] contact::Tool& contact() noexcept { return haptics_.contact(); }
  [[nodiscard]] const Watch& leader() const noexcept { return leader_; }
  [[nodiscard]] const Watch& follower() const noexcept { return follower_; }
  [[nodiscard]] const CrtkOptions& options() const noexcept { return options_; }
  [[nodiscard]] const mapping::Mapping& mapping() const noexcept { return haptics_.mapping(); }

 private:
  std::uint64_t check_conditions(ClockTime now) noexcept;
  std::uint64_t take_message_faults(ClockTime now) noexcept;
  std::uint64_t motion_faults(ClockTime now) noexcept;
  [[nodiscard]] std::uint64_t gate_faults() const noexcept;
  [[nodiscard]] std::uint64_t closed_gates() const noexcept;
  void refuse(std::uint64_t bit, double value = 0.0, double other = 0.0) noexcept;
  void add(const Faults& more) noexcept;
  void locate() noexcept;
  void place_spheres(bool joints_known) noexcept;
  void meet(bool trusted) noexcept;
  [[nodiscard]] bool joints_known() const noexcept;
  [[nodiscard]] Pose model_base(const arm::Arm& arm) const noexcept;
  [[nodiscard]] bool is_at_goal(bool settled) const noexcept;
  unsigned follow(const HapticsOutput& felt) noexcept;
  [[nodiscard]] Wrench released(const Wrench& F, bool allowed, double dt) const noexcept;

  CrtkOptions options_;
  std::optional<arm::Arm> arm_;  ///< the follower's model
  Haptics haptics_;
  Watch leader_, follower_, joints_;
  HandVelocity velocity_;
  CrtkGates gates_;
  HapticsInput in_;
  Pose X_BT_;    ///< measured pose of the tool
  Reach reach_;  ///< of a virtual follower
  JointVector q_follower_, q_step_, zero_;
  Faults faults_;   ///< of messages and motions since the last step
  ClockTime last_;  ///< time of the last step
  double fault_at_ = 0.0;
  bool stepped_ = false, needs_reset_ = false, last_nonzero_ = false;  ///< last_nonzero_: the last command was not zero
  Wrench F_;                                                           ///< last rendered wrench on the hand, in L
  std::unique_ptr<InWorld> in_world_;                                  ///< null without other instruments
  std::unique_ptr<BodyPort> body_port_;                                ///< null without rigid bodies
  OnTool on_tool_;                                                     ///< forces of the others and the bodies
  Vec3 F_pushed_W_ = Vec3::Zero();                                     ///< by push() [N]
  double engaged_at_ = 0.0;  ///< time of the last step in which the tool followed [s]
  bool moved_ = false;       ///< somebody else has moved the follower since it last followed
  double met_at_ = 0.0;      ///< time at which the instrument was last shown to the others; 0: never [s]
  CrtkOutput out_;
};

}  // namespace palpate::loop
