// The wrench of the fixtures on the tool: the law of each, their priorities, and the rate limit of the sum.
#pragma once

#include "palpate/guidance/corrector.hpp"
#include "palpate/guidance/fixture_state.hpp"
#include "palpate/guidance/qp.hpp"
#include "palpate/types/damped_wrench.hpp"

namespace palpate::guidance {

/// The two goals at which fixtures act, and what is known of the tool between them. A hard fixture that corrects the
/// goal acts on the hand, at the mapped goal; all others act on the tool, at the corrected goal.
struct Goals {
  const Input& mapped;     ///< input of the stage
  const Input& corrected;  ///< the same with the corrected goal and its velocity
  const Mat6& J_before;    ///< derivative of the corrected goal in the last tick: how the hand felt the tool then
};

/// Sets the force of every fixture. A fixture that a corrector handles acts along its share of the correction. A hard
/// fixture that begins to hold the tool takes over the force with which the tool was pressed towards it: the hand feels
/// no step, and as the force stays constant while the fixture holds the tool, no loop of the hand gains energy.
FixtureEnergy apply_laws(FixtureStates& states, const Corrector& hard, const Corrector& joint,
                         const FollowerLimits& follower, const Goals& goals) noexcept;

/// Enforces the priorities among the fixtures that act on the tool: none pushes against one that ranks above it. The
/// map of the correction keeps them from pushing against hard fixtures.
class Priorities {
 public:
  /// Replaces the wrench of each fixture by the nearest wrench that opposes no fixture of higher priority. Damping that
  /// the device renders by itself (renders_damping) is left unchanged.
  void apply(FixtureStates& states, bool renders_damping) noexcept;

 private:
  Qp qp_;
};

/// Limits the change of the sum of all forces to what the motions of hand and fixtures explain, plus force_rate and
/// moment_rate: a fixture that is switched, edited or moved fades over from the previous wrench. Where the map of the
/// correction steps, the sum takes over what contacts lose by it.
class Blend {
 public:
  /// dt: period of the cycle [s].
  Blend(const Options& options, double dt) : options_(options), dt_(dt) {}
  /// The rate-limited sum on the hand's side, at the mapped goal; valid until the next step. before: the mapped goal of
  /// the previous tick. J: derivative of the corrected with respect to the mapped goal.
  const DampedWrench& step(const FixtureStates& states, const Input& in, const ToolGoal& before,
                           const Mat6& J) noexcept;

 private:
  Options options_;
  double dt_;
  DampedWrench on_hand_;
  Mat6 J_ = Mat6::Identity();
  double preload_ = 0.0;  ///< sum of all preloads in the last step
};

}  // namespace palpate::guidance
