// The haptic cycle of arms whose joints are measured: joint states in, joint torques out. To the haptics (haptics.hpp)
// it adds the kinematics of the arms and the torques of the leader.
#pragma once

#include <memory>

#include "palpate/arm/arm.hpp"
#include "palpate/force/estimate.hpp"
#include "palpate/loop/execution.hpp"
#include "palpate/loop/haptics.hpp"
#include "palpate/loop/reach.hpp"
#include "palpate/torque/torque.hpp"
#include "palpate/types/arms.hpp"

namespace palpate::loop {

/// Options of the cycle.
struct CycleOptions : HapticsOptions {
  force::EstimateOptions estimate;  ///< of the force estimate, for force sources that use it
  torque::Options torque;
  Pose X_WB;  ///< pose of the follower base in the world
};

/// Input of a cycle. The scene must outlive the step.
struct CycleInput {
  double t = 0.0;  ///< time of the tick [s]
  LeaderState leader;
  FollowerState follower;
  Controls controls;
  const scene::Snapshot* scene = nullptr;
  Wrench F_others_W;           ///< wrench of other instruments on the tool about its tip, in W, to be rendered
  double K_others = 0.0;       ///< stiffness of this contact [N/m]
  double power_others = 0.0;   ///< power of the motion of other instruments on the tool [W]
  const Pose* X_WO = nullptr;  ///< pose of the object that the jaws carry; null: they carry none
  const PlannedMotion* motion = nullptr;  ///< newest motion of the follower; null: this loop executes none
  ExecutionOrder order;
};

/// Output of a cycle.
struct CycleOutput {
  Tick tick{};
  LeaderCommand leader;
  FollowerCommand follower;
};

/// The haptic cycle of a simulated or real pair of arms.
class Cycle {
 public:
  /// leader: the controller's model, which may differ from the arm itself. Throws std::invalid_argument naming an
  /// invalid option.
  Cycle(const CycleOptions& options, arm::Arm leader, arm::Arm follower);

  /// One cycle, without allocation, lock or exception for any input. The result is valid until the next step.
  CycleOutput& step(const CycleInput& in) noexcept;

  [[nodiscard]] const mapping::Mapping& mapping() const noexcept { return haptics_.mapping(); }
  /// Replaces the fixtures, which must outlive their use.
  void take(const guidance::ActiveFixtures& active) noexcept { haptics_.take(active); }
  /// Resets contact to the tool's position, for another scene.
  void forget_contacts() noexcept { haptics_.forget_contacts(); }
  /// Measures the time of the stages from now on; the clock must outlive the cycle. Null: no measurement.
  void watch(StageClock* clock) noexcept {
    clock_ = clock;
    haptics_.watch(clock);
  }
  /// True while a planned motion is not at rest.
  [[nodiscard]] bool moves() const noexcept { return execution_.moves(); }
  /// The contact stage, for the owner of the cycle: see contact::Method::collide.
  [[nodiscard]] contact::Tool& contact() noexcept { return haptics_.contact(); }

 private:
  void mark(Stage stage) noexcept {
    if (clock_ != nullptr) clock_->mark(stage);
  }
  [[nodiscard]] bool is_finite(const LeaderState& leader) const noexcept;
  [[nodiscard]] bool is_finite(const FollowerState& follower) const noexcept;
  bool accept_states(const CycleInput& in) noexcept;
  [[nodiscard]] unsigned input_status(const Controls& controls, bool finite) const noexcept;
  void compensate_gravity() noexcept;
  void locate() noexcept;
  void place_spheres() noexcept;
  [[nodiscard]] unsigned estimate() noexcept;
  bool execute(const CycleInput& in) noexcept;
  void guard(const HapticsOutput& felt, double most) noexcept;
  void record_leader() noexcept;
  void record_follower() noexcept;

  CycleOptions options_;
  arm::Arm leader_, follower_;
  Haptics haptics_;
  std::unique_ptr<force::Estimate> estimate_;  ///< null if the force source does not use it
  torque::Torque torque_;
  Execution execution_;
  Pose X_WT_planned_;

  // The last usable states.
  LeaderState leader_state_;
  FollowerState follower_state_;
  JointVector zero_;  ///< zero velocities of the follower's joints, whose kinematics need positions only
  Reach reach_;
  JointVector q_step_;  ///< largest change of the follower's joints in a cycle [rad, m]
  bool leader_known_ = false, follower_known_ = false;
  ToolJoints joints_;           ///< joints of the follower
  HapticsInput in_;             ///< poses that belong to the states above
  const Pose* X_WO_ = nullptr;  ///< pose of the object that the jaws carry in this tick
  StageClock* clock_ = nullptr;
  CycleOutput out_;
};

}  // namespace palpate::loop
