// The wrench of the fixtures on the tool: the law of each, and the rate limit of the sum.
#pragma once

#include "palpate/guidance/corrector.hpp"
#include "palpate/guidance/fixture_state.hpp"
#include "palpate/types/damped_wrench.hpp"

namespace palpate::guidance {

/// Sets the force of a soft fixture that acts at a goal with the velocity V_WT, where its constraint has been
/// evaluated. joint: corrector of the fixtures with a joint law, each of which acts along its share of the correction.
void apply_soft_law(FixtureStates& states, int i, const Corrector& joint, const Twist& V_WT,
                    FixtureEnergy& energy) noexcept;

/// The goals between which hard fixtures act, and what is known of the tool. A hard fixture that corrects the goal acts
/// on the hand, at the mapped goal; one that does not acts on the tool, at the corrected goal.
struct Goals {
  const Input& mapped;     ///< input of the stage
  const Input& corrected;  ///< the same with the corrected goal and its velocity
  const Mat6& J_before;    ///< derivative of the corrected goal in the last tick: how the hand felt the tool then
};

/// Sets the forces of the hard fixtures. One that corrects the goal acts along its share of the correction. When it
/// begins to hold the tool it takes over the force with which the tool was pressed towards it: the hand feels no step,
/// and as the force stays constant while the fixture holds the tool, no loop of the hand gains energy. soft: sum of the
/// soft fixtures' wrenches on the tool.
void apply_hard_laws(FixtureStates& states, const Corrector& hard, const FollowerLimits& follower, const Goals& goals,
                     const Wrench& soft, FixtureEnergy& energy) noexcept;

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
