// How much authority each fixture has: its policy's engagement and ramps, followed at the policy's pace.
#pragma once

#include "palpate/guidance/fixture_state.hpp"

namespace palpate::guidance {

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
