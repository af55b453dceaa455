// Stage `guidance`: the fixtures correct the tool's goal and exert a wrench on the tool.
//
//   mapped goal -> every fixture: query -> role -> authority -> law -> priorities -> blend -> wrench
//              \-> hard fixtures: corrector -> corrected goal, and each one's share of the correction
//
// Forces are evaluated at the mapped goal, which follows the hand without lag, so that the lag of the follower is
// outside the force loop of a fixture.
#pragma once

#include "palpate/guidance/authority.hpp"
#include "palpate/guidance/corrector.hpp"
#include "palpate/guidance/fixture_state.hpp"
#include "palpate/guidance/follower_limits.hpp"
#include "palpate/guidance/forces.hpp"
#include "palpate/guidance/input.hpp"
#include "palpate/types/damped_wrench.hpp"

namespace palpate::guidance {

/// Output of the stage, in W.
struct Output {
  Pose X_WT_goal;                  ///< corrected goal; exactly the mapped goal if no hard fixture corrects it
  DampedWrench on_tool;            ///< wrench of the fixtures; its B is zero unless the device renders damping
  int strongest = -1;              ///< index of the fixture with the largest wrench; -1: no fixture exerts one
  double gap = 0.0;                ///< gap of that fixture, or without force the smallest gap [m, rad]
  Vec3 correction = Vec3::Zero();  ///< corrected minus mapped position of the goal [m]
  FixtureEnergy energy;            ///< energies of the fixtures
  unsigned status = 0;             ///< bits of Status
};

/// The stage `guidance` with the state of all fixtures.
class Guidance {
 public:
  /// dt: period of the cycle [s]. Throws std::invalid_argument naming an invalid option.
  Guidance(const Options& options, double dt);
  Guidance(const Guidance&) = delete;
  Guidance& operator=(const Guidance&) = delete;

  /// Replaces the fixtures from the next step on; `fixtures` must outlive their use. A fixture keeps the state of the
  /// previous one with the same name.
  void take(const Fixtures& fixtures) noexcept { states_.take(fixtures); }
  /// One tick, without allocation, lock or exception. The result is valid until the next step.
  const Output& step(const Input& in) noexcept;
  /// Authority [0-1], wrench on the tool in W [N, N m] and gap [m, rad] of fixture i in the last step.
  [[nodiscard]] double authority(int i) const noexcept { return states_[i].authority; }
  [[nodiscard]] const Wrench& wrench(int i) const noexcept { return states_[i].force.F; }
  [[nodiscard]] double gap(int i) const noexcept { return states_[i].constraint.gap; }
  /// Summed stiffness of all active fixtures along the direction of the force F_T_W [N/m].
  [[nodiscard]] double stiffness_along(const Vec3& F_T_W) const noexcept;

 private:
  void correct(const Input& in) noexcept;
  void report(const Input& in) noexcept;

  FixtureStates states_;
  Authority authority_;
  FollowerLimits follower_;
  Corrector hard_;   ///< corrects the goal
  Corrector joint_;  ///< finds the pose to which soft fixtures with a joint law pull
  Priorities priorities_;
  Blend blend_;
  ToolGoal before_;  ///< mapped goal of the previous tick
  bool started_ = false, joint_started_ = false;
  Output out_;
};

}  // namespace palpate::guidance
