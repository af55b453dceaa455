// The wrench of the fixtures on the tool: the law of each, their priorities, and the rate limit of the sum.
#pragma once

#include "palpate/guidance/corrector.hpp"
#include "palpate/guidance/fixture_state.hpp"
#include "palpate/guidance/qp.hpp"
#include "palpate/types/damped_wrench.hpp"

namespace palpate::guidance {

/// Sets the force of every fixture: at the mapped goal, or along its share of the correction if a corrector handles it.
FixtureEnergy apply_laws(FixtureStates& states, const Corrector& hard, const Corrector& joint,
                         const FollowerLimits& follower, const Input& in) noexcept;

/// Enforces the priorities: a fixture never pushes against one that ranks above it; hard fixtures rank above soft ones.
class Priorities {
 public:
  /// Replaces the wrench of each fixture by the nearest wrench that opposes no fixture ranked above it. Damping that
  /// the device renders by itself (renders_damping) is left unchanged.
  void apply(FixtureStates& states, bool renders_damping) noexcept;

 private:
  Qp qp_;
};

/// Limits the change of the sum of all forces to what the motions of hand and fixtures explain, plus force_rate and
/// moment_rate: a fixture that is switched, edited or moved fades over from the previous wrench.
class Blend {
 public:
  /// dt: period of the cycle [s].
  Blend(const Options& options, double dt) : options_(options), dt_(dt) {}
  /// The rate-limited sum; valid until the next step. before: the mapped goal of the previous tick.
  const DampedWrench& step(const FixtureStates& states, const Input& in, const ToolGoal& before) noexcept;

 private:
  Options options_;
  double dt_;
  DampedWrench on_tool_;
};

}  // namespace palpate::guidance
