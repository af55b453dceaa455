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
  /// Of a fixture, at an authority of one.
  struct Sum {
    Wrench F;
    double U = 0.0;          ///< stored energy [J]
    double by_motion = 0.0;  ///< energy by the motion of the fixtures since the last tick [J]
    std::uint64_t keys = 0;  ///< of the fixtures
    bool by_others = false;  ///< appeared, edited or jumped: not the hand changes the energy
  };
  /// The energy of a fixture.
  struct Account {
    Sum last;
    SpringRest rest;
    double share = 1.0;
  };
  void add(FixtureState& fixture, Sum& sum) const noexcept;
  static void settle(Account& account, const Sum& now, const Twist& moved) noexcept;

  double dt_;
  Pose X_WT_;
  std::array<Account, kMaxFixtures> account_{};  ///< of each fixture
};

}  // namespace palpate::guidance
