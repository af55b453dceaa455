// The haptic cycle of devices that are known by poses and wrenches alone, over a network: CRTK leaders and followers
// (collaborative-robotics.github.io). Messages come in one by one; each step answers a wrench, and a goal for the
// follower where the teleoperation is ours. Around the haptics (haptics.hpp) it knows when not to believe.
#pragma once

#include <optional>

#include "palpate/arm/arm.hpp"
#include "palpate/loop/crtk_watch.hpp"
#include "palpate/loop/haptics.hpp"

namespace palpate::loop {

struct CrtkOptions : HapticsOptions {  // X_WL: of the frame in which the leader tells measured_cp
  Pose X_WB;                           ///< frame in which the follower does, in the world
  bool own_teleop = false;             ///< we move the follower; otherwise somebody else's teleoperation does
  bool virtual_follower = false;       ///< there is none: the tool is where the map puts it, as far as the arm reaches
  bool tip_frame = false;      ///< the leader takes wrenches in its tip's frame, in place of that of measured_cp
  bool needs_operator = true;  ///< of a teleoperation of ours: somebody must be known to be at the console
  bool needs_state = true;     ///< operating states must be told
  JointVector q_follower0;     ///< where a virtual follower starts [rad, m]
  WatchOptions watch;
  double release = 0.03;   ///< from a fault or a pedal to zero force, along a straight line [s]
  double settle = 0.1;     ///< all must be well for so long after a fault [s]
  double lag_most = 0.03;  ///< of a follower behind its goal [m]
  double slowest = 2.5;    ///< periods of the cycle between two states of the leader, in the mean [-]
};

/// What the console and the arms say about themselves; unknown is no.
struct CrtkGates {
  bool following = false;         ///< as the teleoperation says; of ours: switched on
  bool operator_present = false;  ///< somebody is at the console
  bool clutch = false;
  bool leader_enabled = false, follower_enabled = false;  ///< operating state ENABLED, homed
  bool second_writer = false;                             ///< somebody else publishes wrenches to the same arm
  bool other_teleop = false;                              ///< ours is asked for, and another one is on
  bool frame_unsure = false;  ///< the arm may read wrenches in another frame, or not carry its own weight
  bool guarded = false;       ///< the guardian has latched, or is gone
};

struct CrtkOutput {
  Tick tick{};
  Wrench F;              ///< to command, in the leader's frame or its tip's [N, N m]
  bool command = false;  ///< send F; otherwise nothing may be sent at all
  Pose X_BT_goal;
  double jaw = 0.0;   ///< [rad]
  bool move = false;  ///< send the goal
};

/// F is finite, below its cap, never grows faster than its rate cap in real time, whatever the times of its steps,
/// and is zero `release` after anything forbade it. After a fault contact and map start afresh.
class CrtkCycle {
 public:
  /// follower: for a virtual one and for spheres on its links. Throws std::invalid_argument naming what cannot be.
  CrtkCycle(const CrtkOptions& options, std::optional<arm::Arm> follower);

  // Messages, with numbers as they came and the stamps of their senders. All noexcept, no allocation, no lock.
  void leader_pose(double stamp, const Vec3& p_LH, const Eigen::Vector4d& quat_LH, Moment now) noexcept;
  void leader_twist(double stamp, const Twist& V_LH, Moment now) noexcept;
  void leader_joints(double stamp, const double* q, std::size_t n) noexcept;
  void gripper(double stamp, const double* angle, std::size_t n) noexcept;
  void follower_pose(double stamp, const Vec3& p_BT, const Eigen::Vector4d& quat_BT, Moment now) noexcept;
  void follower_joints(double stamp, const double* q, std::size_t n, Moment now) noexcept;
  void jaw(double stamp, const double* angle, std::size_t n) noexcept;
  /// Motion scale of somebody else's teleoperation.
  void set_scale(double scale) noexcept;
  void set_gates(const CrtkGates& gates) noexcept { gates_ = gates; }
  void set_controls(const Controls& controls) noexcept { in_.controls = controls; }
  /// Another scene, which outlives the steps: contact starts afresh.
  void set_scene(const scene::Snapshot& scene) noexcept;

  /// From now on these fixtures; they outlive it, or the next ones.
  void take(const guidance::Fixtures& fixtures) noexcept { haptics_.take(fixtures); }

  /// One tick. Times may come as they like; the answer lives until the next step.
  const CrtkOutput& step(Moment now) noexcept;
  /// Nothing is pushed any more, as of now: somebody else has put the force to zero.
  void drop() noexcept;

  [[nodiscard]] contact::Tool& contact() noexcept { return haptics_.contact(); }
  [[nodiscard]] const Watch& leader() const noexcept { return leader_; }
  [[nodiscard]] const Watch& follower() const noexcept { return follower_; }
  [[nodiscard]] const CrtkOptions& options() const noexcept { return options_; }

 private:
  unsigned judge(Moment now) noexcept;
  void locate() noexcept;
  void place_spheres(bool joints_known) noexcept;
  unsigned follow(const HapticsOutput& felt) noexcept;
  [[nodiscard]] Wrench last_word(const Wrench& F, bool allowed, double dt) const noexcept;

  CrtkOptions options_;
  std::optional<arm::Arm> arm_;  ///< the follower's model
  Haptics haptics_;
  Watch leader_, twist_, follower_, joints_;
  CrtkGates gates_;
  HapticsInput in_;
  Pose X_BT_;            ///< as measured
  Twist V_differenced_;  ///< of a leader that tells no twist
  bool twist_known_ = false, twist_told_ = false;
  JointVector q_follower_, q_step_, zero_;
  unsigned refused_ = 0;  ///< bits of Status since the last step
  Moment last_;           ///< step
  double fault_at_ = 0.0;
  bool stepped_ = false, afresh_ = false, pushed_ = false;  ///< pushed: the last command was not zero
  Wrench F_;                                                ///< rendered last
  CrtkOutput out_;
};

}  // namespace palpate::loop
