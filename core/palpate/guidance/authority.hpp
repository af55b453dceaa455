// The authority of each fixture: engagement and ramps of its policy, within the policy's rise and fall times.
#pragma once

#include <algorithm>
#include <cmath>

#include "palpate/guidance/fixture_state.hpp"

namespace palpate::guidance {

/// True if the authority changes with the distance of the hand.
[[nodiscard]] inline bool follows_distance(const Policy& policy) noexcept {
  return std::any_of(policy.ramps.begin(), policy.ramps.end(),
                     [](const Ramp& ramp) { return ramp.by == Ramp::By::distance; });
}

/// True if the energy that a changing authority stores is credited. What the hand can trigger by its motion earns
/// nothing, because it could be repeated: a ramp by distance or force, an engagement by distance.
[[nodiscard]] inline bool earns_credit(const Policy& policy) noexcept {
  return !policy.hard && std::isinf(policy.engage) &&
         std::none_of(policy.ramps.begin(), policy.ramps.end(),
                      [](const Ramp& ramp) { return ramp.by == Ramp::By::distance || ramp.by == Ramp::By::force; });
}

/// Engages and releases the fixtures and updates their authorities.
class Authority {
 public:
  /// dt: period of the cycle [s].
  explicit Authority(double dt) : dt_(dt) {}
  /// Evaluates the constraint of fixture i at the goal of `in`, and updates its authority. Returns bits of Status.
  unsigned step(FixtureStates& states, int i, const Input& in) const noexcept;

 private:
  double dt_;
};

}  // namespace palpate::guidance
