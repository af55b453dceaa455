// Soft fixtures pay back no more than what was put into them.
#pragma once

#include <array>

#include "palpate/guidance/fixture_state.hpp"
#include "palpate/types/spring_rest.hpp"

namespace palpate::guidance {

/// A soft fixture is the gradient of its energy but for two cases: priorities take away the part of its force that
/// opposes a higher fixture, and the nearest place of its geometry may jump. Motion then changes the energy without
/// work. The rest of its spring is displaced by that (types/spring_rest.hpp), so that no loop of the hand gains energy.
class KeptEnergy {
 public:
  /// dt: period of the cycle [s].
  explicit KeptEnergy(double dt) : dt_(dt) {}
  /// Scales the wrenches of the soft fixtures of a tool at X_WT, after the priorities. Fixtures with a joint law are
  /// left as they are: their common correction follows authority, slack and time as well, which is no jump.
  void step(FixtureStates& states, const Pose& X_WT) noexcept;

 private:
  /// Of a fixture at the last tick, at an authority of one.
  struct Last {
    Wrench F;
    std::uint64_t key = 0;  ///< of the fixture; 0: it did not act
  };
  /// The energy of a fixture.
  struct Account {
    Last last;
    SpringRest rest;
  };
  double share(Account& account, FixtureState& fixture, const Twist& moved) const noexcept;

  double dt_;
  Pose X_WT_;
  std::array<Account, kMaxFixtures> account_{};
};

}  // namespace palpate::guidance
