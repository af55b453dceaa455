// The haptic cycle of arms that are known by their joints: states in, torques out. Around the haptics (haptics.hpp) it
// knows the arms' kinematics and the leader's torques.
#pragma once

#include <memory>

#include "palpate/arm/arm.hpp"
#include "palpate/force/estimate.hpp"
#include "palpate/loop/haptics.hpp"
#include "palpate/torque/torque.hpp"
#include "palpate/types/arms.hpp"

namespace palpate::loop {

struct CycleOptions : HapticsOptions {
  force::EstimateOptions estimate;  ///< of the force, where the source asks for it
  torque::Options torque;
  Pose X_WB;  ///< follower base in the world
};

/// All that a cycle is told. The scene outlives the step.
struct CycleInput {
  double t = 0.0;  ///< now [s]
  LeaderState leader;
  FollowerState follower;
  Controls controls;
  const scene::Snapshot* scene = nullptr;
};

/// All that a cycle answers.
struct CycleOutput {
  Tick tick{};
  LeaderCommand leader;
  FollowerCommand follower;
};

class Cycle {
 public:
  /// leader: the controller's model, which may differ from the arm itself. Throws std::invalid_argument naming an
  /// option that cannot be.
  Cycle(const CycleOptions& options, arm::Arm leader, arm::Arm follower);

  /// One cycle: no allocation, no lock, no exception, whatever the input. The answer lives until the next step.
  CycleOutput& step(const CycleInput& in) noexcept;

  [[nodiscard]] const mapping::Mapping& mapping() const noexcept { return haptics_.mapping(); }
  /// From now on these fixtures; they outlive it, or the next ones.
  void take(const guidance::Fixtures& fixtures) noexcept { haptics_.take(fixtures); }
  [[nodiscard]] const guidance::Guidance& guidance() const noexcept { return haptics_.guidance(); }
  /// Another scene: contact starts afresh from where the tool is.
  void forget_contacts() noexcept { haptics_.forget_contacts(); }
  /// Times the stages from now on; the clock outlives the cycle. None: nothing is timed.
  void watch(StageClock* clock) noexcept {
    clock_ = clock;
    haptics_.watch(clock);
  }
  /// For whoever drives the cycle: see contact::Method::collide.
  [[nodiscard]] contact::Tool& contact() noexcept { return haptics_.contact(); }

 private:
  void mark(Stage stage) noexcept {
    if (clock_ != nullptr) clock_->mark(stage);
  }
  bool trust(const CycleInput& in) noexcept;
  void hold_up() noexcept;
  void locate() noexcept;
  void place_spheres() noexcept;
  [[nodiscard]] unsigned estimate() noexcept;
  void record_leader() noexcept;
  void record_follower() noexcept;

  CycleOptions options_;
  arm::Arm leader_, follower_;
  Haptics haptics_;
  std::unique_ptr<force::Estimate> estimate_;  ///< none when the source does not ask for it
  torque::Torque torque_;

  // The last states worth trusting.
  LeaderState leader_state_;
  FollowerState follower_state_;
  JointVector zero_;    ///< follower joint velocities: not needed, not measured
  JointVector q_step_;  ///< most that the follower's joints may turn in a cycle [rad, m]
  bool leader_known_ = false, follower_known_ = false;
  ToolJoints joints_;  ///< of the follower
  HapticsInput in_;    ///< the same states as poses
  StageClock* clock_ = nullptr;
  CycleOutput out_;
};

}  // namespace palpate::loop
