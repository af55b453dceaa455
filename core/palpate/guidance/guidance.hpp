// Stage `guidance`: the fixtures correct the tool's goal and exert a wrench on the tool.
//
//   mapped goal -> hard fixtures: corrector -> corrected goal, and each one's share of the correction
//   corrected goal -> soft fixtures, in the order of priority: goal that the higher ones leave -> query -> role ->
//   authority -> law
//   wrenches at these goals, carried back by the transposed Jacobians, and of the shares -> blend -> wrench
//
// Both goals follow the hand without lag, so that the lag of the follower is outside the force loop of a fixture.
#pragma once

#include <array>
#include <optional>

#include "palpate/guidance/authority.hpp"
#include "palpate/guidance/corrector.hpp"
#include "palpate/guidance/fixture_state.hpp"
#include "palpate/guidance/follower_limits.hpp"
#include "palpate/guidance/forces.hpp"
#include "palpate/guidance/interface/stage.hpp"
#include "palpate/guidance/kept_energy.hpp"
#include "palpate/guidance/priorities.hpp"

namespace palpate::guidance {

/// The stage `guidance` with the state of all fixtures.
class Guidance final : public Stage {
 public:
  /// dt: period of the cycle [s]. Throws std::invalid_argument naming an invalid option.
  Guidance(const Options& options, double dt);

  void take(const FixtureList& fixtures) noexcept override { states_.take(fixtures); }
  const Output& step(const Input& in) noexcept override;
  /// Authority [0-1], wrench on the tool in W [N, N m] and gap [m, rad] of fixture i in the last step.
  [[nodiscard]] double authority(int i) const noexcept { return states_[i].authority; }
  [[nodiscard]] const Wrench& wrench(int i) const noexcept { return states_[i].force.F; }
  [[nodiscard]] double gap(int i) const noexcept { return states_[i].constraint.gap; }
  [[nodiscard]] double stiffness_along(const Vec3& F_T_W) const noexcept override;

 private:
  void correct(const Input& in) noexcept;
  void act(const Input& in) noexcept;
  Wrench act_softly(const Input& at_tool) noexcept;
  void act_at(int priority, const Input& at) noexcept;
  [[nodiscard]] bool soft_acts() const noexcept;
  void report(const Input& in) noexcept;

  FixtureStates states_;
  Authority authority_;
  FollowerLimits follower_;
  Corrector hard_;   ///< corrects the goal
  Corrector joint_;  ///< finds the pose to which soft fixtures with a joint law pull
  Priorities priorities_;
  KeptEnergy kept_;
  Blend blend_;
  ToolGoal before_;                                           ///< mapped goal of the previous tick
  Mat6 J_before_ = Mat6::Identity();                          ///< J_goal of the previous tick
  std::array<std::optional<Pose>, kMaxFixtures> joint_X_WT_;  ///< solutions of the joint law, one for each priority, by
                                                              ///< its first fixture; empty: it does not act
  bool started_ = false;
  Output out_;
};

}  // namespace palpate::guidance
