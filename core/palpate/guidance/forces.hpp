// The wrench of the fixtures on the tool: each one's law, their priorities, and the rate at which the sum may change.
#pragma once

#include "palpate/guidance/corrector.hpp"
#include "palpate/guidance/fixture_state.hpp"
#include "palpate/guidance/qp.hpp"
#include "palpate/types/damped_wrench.hpp"

namespace palpate::guidance {

/// Sets every fixture's force: soft ones at the mapped goal, corrected ones along their share of a correction. Returns
/// the energy stored by fixtures whose authority rose by no motion of the hand [J].
double apply_laws(FixtureStates& states, const Corrector& hard, const Corrector& joint, const FollowerLimits& follower,
                  const Input& in) noexcept;

/// A fixture never pushes against one of higher priority; hard fixtures come before soft ones.
class Priorities {
 public:
  /// Replaces each fixture's wrench by the nearest one that pushes against none of those before it. Damping that the
  /// device renders by itself pushes against nothing.
  void apply(FixtureStates& states, bool takes_damping) noexcept;

 private:
  Qp qp_;
};

/// Limits the change of the sum of all forces to what the motions of hand and fixtures explain, plus force_rate and
/// moment_rate: a fixture that is switched, edited or moved fades over from the previous wrench.
class Blend {
 public:
  /// dt: period of the cycle [s].
  Blend(const Options& options, double dt) : options_(options), dt_(dt) {}
  /// before: the mapped goal of the last tick. The answer lives until the next step.
  const DampedWrench& step(const FixtureStates& states, const Input& in, const ToolGoal& before) noexcept;

 private:
  Options options_;
  double dt_;
  DampedWrench on_tool_;
};

}  // namespace palpate::guidance
