// The authority of each fixture: engagement and ramps of its policy, within the policy's rise and fall times.
#pragma once

#include "palpate/guidance/fixture_state.hpp"

namespace palpate::guidance {

/// Engages and releases the fixtures and updates their authorities.
class Authority {
 public:
  /// dt: period of the cycle [s].
  explicit Authority(double dt) : dt_(dt) {}
  /// Evaluates every constraint at the mapped goal and updates the authorities. Returns bits of Status.
  unsigned step(FixtureStates& states, const Input& in) const noexcept;

 private:
  double dt_;
};

}  // namespace palpate::guidance
