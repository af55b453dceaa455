// Stage `guidance`: the fixtures correct the tool's goal, and add a wrench on the tool.
//
//   mapped goal -> every fixture: query -> role -> authority -> law -> priorities -> blend -> wrench
//              \-> hard fixtures: corrector -> corrected goal, and each one's share of the correction
//
// All constraints are evaluated at the mapped goal, where the hand is: no lag of the follower is in a fixture's loop.
#pragma once

#include "palpate/guidance/authority.hpp"
#include "palpate/guidance/corrector.hpp"
#include "palpate/guidance/fixture_state.hpp"
#include "palpate/guidance/follower_limits.hpp"
#include "palpate/guidance/forces.hpp"
#include "palpate/guidance/input.hpp"
#include "palpate/types/damped_wrench.hpp"

namespace palpate::guidance {

/// Output of the stage. All in W, on the tool.
struct Output {
  Pose X_WT_goal;                  ///< corrected; exactly the mapped one when no hard fixture is in the way
  DampedWrench on_tool;            ///< of the fixtures; its damping is zero unless the device takes damping
  int strongest = -1;              ///< index of the fixture with the largest force; below zero: none
  double gap = 0.0;                ///< of that fixture, or of the nearest one when there is no force [m, rad]
  Vec3 correction = Vec3::Zero();  ///< of the goal's place [m]
  double credit = 0.0;             ///< energy stored by fixtures whose authority rose by no motion of the hand [J]
  unsigned status = 0;             ///< bits of Status
};

class Guidance {
 public:
  /// dt: period of the cycle [s]. Throws std::invalid_argument naming an option that cannot be.
  Guidance(const Options& options, double dt);
  Guidance(const Guidance&) = delete;
  Guidance& operator=(const Guidance&) = delete;

  /// From the next step on these fixtures, which outlive it. A fixture of a name that was there before keeps its state.
  void take(const Fixtures& fixtures) noexcept { states_.take(fixtures); }
  /// One tick: no allocation, no lock, no exception. The answer lives until the next step.
  const Output& step(const Input& in) noexcept;
  /// Fixture i as of the last step: its authority and its wrench.
  [[nodiscard]] double authority(int i) const noexcept { return states_[i].authority; }
  [[nodiscard]] const Wrench& wrench(int i) const noexcept { return states_[i].force.F; }
  [[nodiscard]] double gap(int i) const noexcept { return states_[i].constraint.gap; }
  /// Stiffness of all active fixtures along a force F [N/m].
  [[nodiscard]] double stiffness_along(const Vec3& F_T_W) const noexcept;

 private:
  void correct(const Input& in) noexcept;
  void report(const Input& in) noexcept;

  FixtureStates states_;
  Authority authority_;
  FollowerLimits follower_;
  Corrector hard_;   ///< of the goal
  Corrector joint_;  ///< of the place to which fixtures with a joint law pull
  Priorities priorities_;
  Blend blend_;
  ToolGoal before_;  ///< mapped goal of the last tick
  bool started_ = false, joint_started_ = false;
  Output out_;
};

}  // namespace palpate::guidance
