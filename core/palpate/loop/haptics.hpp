// The haptics: from the poses of handle and tool to the wrench on the hand. They do not depend on the arms.
#pragma once

#include <array>
#include <limits>
#include <string>

#include "palpate/contact/tool.hpp"
#include "palpate/force/force.hpp"
#include "palpate/guidance/interface/stage.hpp"
#include "palpate/loop/goal_jump.hpp"
#include "palpate/loop/session_machine.hpp"
#include "palpate/loop/stage_clock.hpp"
#include "palpate/loop/tick.hpp"
#include "palpate/mapping/mapping.hpp"
#include "palpate/scene/deformable.hpp"
#include "palpate/scene/snapshot.hpp"
#include "palpate/stability/gripper_limiter.hpp"
#include "palpate/stability/ledger.hpp"
#include "palpate/stability/stability.hpp"
#include "palpate/types/arms.hpp"
#include "palpate/types/damped_wrench.hpp"
#include "palpate/types/motion.hpp"

namespace palpate::loop {

/// Options of all stages of the haptics.
struct HapticsOptions {
  double rate = 1000.0;          ///< rate of the cycle [Hz]
  std::string method = "proxy";  ///< contact method
  contact::Options contact;
  mapping::Options mapping;
  guidance::Options guidance;
  force::Source source = force::Source::contact;  ///< source of the contact force on the hand
  stability::Options stability;
  Pose X_WL;  ///< pose of the leader base in the world
};

/// The tool with its spheres.
struct ToolWithSpheres : ToolState {
  std::array<Vec3, contact::kMaxSpheres> p_WS;          ///< centres of the spheres in W; the first is the tip [m]
  std::array<Vec3, contact::kMaxSpheres> jaw_motion_W;  ///< motion of the centres per jaw angle [m/rad]

  ToolWithSpheres() noexcept {
    p_WS.fill(Vec3::Zero());
    jaw_motion_W.fill(Vec3::Zero());
  }
  /// Places sphere s, which is carried by a link with the pose X_W0.
  void place(std::size_t s, const contact::ToolSphere& sphere, const Pose& X_W0) noexcept {
    p_WS[s] = X_W0 * sphere.centre(jaw);
    jaw_motion_W[s] = X_W0.R * sphere.motion(jaw);
  }
  /// Places sphere s where it touches nothing.
  void leave_out(std::size_t s) noexcept {
    p_WS[s].setConstant(std::numeric_limits<double>::quiet_NaN());
    jaw_motion_W[s].setZero();
  }
};

/// Input of the haptics. The scene must outlive the step.
struct HapticsInput {
  double t = 0.0;  ///< time of the tick [s]
  Handle handle;
  ToolWithSpheres tool;
  Controls controls;
  bool homed = true;                   ///< both arms are homed
  bool settling = false;               ///< a fault is over, but not yet for long enough
  bool execute = false;                ///< a planned motion waits, moves or pauses
  bool moving = false;                 ///< a planned motion is not yet at rest
  const Pose* X_WT_planned = nullptr;  ///< goal of the tool by the planned motion; null: by the hand
  const scene::Snapshot* scene = nullptr;
  /// Derivative of the tool's pose with respect to its last goal, both as (displacement, rotation vector) in W; null:
  /// the identity, since the goal was within the follower's reach.
  const Mat6* J_WT = nullptr;
};

/// Output of the haptics.
struct HapticsOutput {
  ToolGoal mapped;                       ///< goal of the tool, corrected by hard fixtures
  Mat3 R_WT_mapped = Mat3::Identity();   ///< orientation of the goal before that correction
  guidance::Output guided;               ///< output of guidance
  Twist V_WT;                            ///< velocity that the hand gives the tool, after the correction, in W
  const ContactSet* contacts = nullptr;  ///< contacts of the tool
  force::ForceTerms force;               ///< force of the contacts on the tool
  double tau_jaw = 0.0;                  ///< torque of the contacts on the jaws, positive when it opens them [N m]
  double tau_gripper = 0.0;              ///< torque on the operator's fingers, positive when it opens them [N m]
  DampedWrench commanded;                ///< wrench on the hand before the stage `stability`, in L
  stability::Output rendered;            ///< wrench on the hand after it, in L
};

/// Writes the signals of the handle to a tick.
void record(const Handle& handle, Tick& tick) noexcept;

/// Runs the stages mapping, guidance, contact, force and stability at every tick.
class Haptics {
 public:
  /// Throws std::invalid_argument naming an invalid option.
  explicit Haptics(const HapticsOptions& options);

  /// One tick, without allocation, lock or exception. The result is valid until the next step; `in` must stay valid
  /// until finish().
  const HapticsOutput& step(const HapticsInput& in) noexcept;
  /// Books the energy and writes the signals of the tick; to be called after every step. F: the part of
  /// rendered.on_hand.F that the device renders, in L; the damping of on_hand adds to it.
  void finish(const HapticsInput& in, const Wrench& F, Tick& tick) noexcept;

  [[nodiscard]] const mapping::Mapping& mapping() const noexcept { return mapping_; }
  /// True if a state stamped `stamp` is too old to be trusted at the time `now` [s].
  [[nodiscard]] bool stale(double now, double stamp) const noexcept { return stability_.stale(now, stamp); }
  /// Replaces the fixtures; they and their stage must outlive their use.
  void take(const guidance::ActiveFixtures& active) noexcept;
  [[nodiscard]] SessionState state() const noexcept { return session_.state(); }
  /// Contact force on the tool in the last step, as the hand would feel it, in W.
  [[nodiscard]] const Wrench& tool_force() const noexcept { return tool_force_.F_T_W; }
  /// Changes the motion scale [-]; the map is anchored anew.
  void rescale(double scale) noexcept { mapping_.rescale(scale); }
  /// Resets contact to the tool's position.
  void forget_contacts() noexcept { contact_.reset(); }
  /// Measures the time of the stages from now on; the clock must outlive the haptics. Null: no measurement.
  void watch(StageClock* clock) noexcept { clock_ = clock; }
  /// The contact stage, for the owner of the loop: see contact::Method::collide.
  [[nodiscard]] contact::Tool& contact() noexcept { return contact_; }

 private:
  void mark(Stage stage) noexcept {
    if (clock_ != nullptr) clock_->mark(stage);
  }
  double elapsed(double t) noexcept;
  SessionState advance(const HapticsInput& in) noexcept;
  void take_mapping(const Controls& controls) noexcept;
  [[nodiscard]] bool feels(const HapticsInput& in) const noexcept;
  void guide(const HapticsInput& in) noexcept;
  [[nodiscard]] double torque_on_jaws(const ToolWithSpheres& tool) const noexcept;
  [[nodiscard]] ToolForce contact_force(const HapticsInput& in) const noexcept;
  [[nodiscard]] Wrench carried_to_goal(const HapticsInput& in, const Wrench& F_T_W) const noexcept;
  [[nodiscard]] double spring_energy(const HapticsInput& in, double of_fixtures) const noexcept;
  [[nodiscard]] double energy_of_lag(const HapticsInput& in) const noexcept;
  [[nodiscard]] double power_of_motion(const HapticsInput& in) const noexcept;
  [[nodiscard]] stability::Output stabilise(const HapticsInput& in) noexcept;
  stability::Energy book(const HapticsInput& in, const Wrench& F_H_L) noexcept;
  void record(const HapticsInput& in, Tick& tick) const noexcept;
  void record_guidance(Tick& tick) const noexcept;
  void record_withheld(const HapticsInput& in, const Wrench& F_H_L, Tick& tick) const noexcept;
  void record_touches(double stiffness_scale, Tick& tick) const noexcept;
  void record_stability(const HapticsInput& in, const Wrench& F_H_L, const stability::Energy& energy,
                        Tick& tick) const noexcept;

  HapticsOptions options_;
  SessionMachine session_;
  int recover_seen_ = 0;                                 ///< recover_requests when the last fault began
  int take_back_seen_ = 0;                               ///< Controls::take_back_requests of the last tick
  Mat3 R_WL0_;                                           ///< orientation of the leader base by the options
  double scale_ = 0.0;                                   ///< Controls::scale of the last tick
  double t_ = std::numeric_limits<double>::quiet_NaN();  ///< time of the last tick; NaN: none [s]
  double dt_ = 0.0;                                      ///< time since the tick before it [s]
  Eigen::Vector4d quat_WL_ = Eigen::Vector4d::Zero();    ///< Controls::quat_WL of the last tick
  mapping::Mapping mapping_;
  guidance::Stage* guidance_ = nullptr;     ///< null before the first fixture
  scene::LiveFrame* tool_frame_ = nullptr;  ///< receives the tool's pose before that; may be null
  GoalJump jump_;
  contact::Tool contact_;
  stability::Stability stability_;
  stability::Ledger ledger_;
  stability::GripperLimiter gripper_;
  StageClock* clock_ = nullptr;
  HapticsOutput out_;
  scene::DeformableState soft_;  ///< of the soft objects
  ToolForce tool_force_;         ///< contact force of the previous tick
  Wrench at_goal_;               ///< wrench of contacts and fixtures at the mapped goal in the previous tick, in W
};

}  // namespace palpate::loop
