// The authority of each fixture: engagement and ramps of its policy, within the policy's rise and fall times.
#pragma once

#include <algorithm>

#include "palpate/guidance/fixture_state.hpp"

namespace palpate::guidance {

/// Factor of the authority at the value that a ramp measures [0-1].
[[nodiscard]] inline double factor(const Ramp& ramp, double measured) noexcept {
  return std::clamp((measured - ramp.from) / (ramp.to - ramp.from), 0.0, 1.0);
}

/// True if the authority changes with the distance of the hand.
[[nodiscard]] inline bool follows_distance(const Policy& policy) noexcept {
  return std::any_of(policy.ramps.begin(), policy.ramps.end(),
                     [](const Ramp& ramp) { return ramp.by == Ramp::By::distance; });
}

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
