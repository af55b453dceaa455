// Soft fixtures pay back no more than what was put into them.
#pragma once

#include <array>

#include "palpate/guidance/fixture_state.hpp"
#include "palpate/types/spring_rest.hpp"

namespace palpate::guidance {

/// A soft fixture is the gradient of its energy, but the nearest place of its geometry, or of those of higher priority,
/// may jump. Motion then changes the energy without work. The rest of its spring is displaced by that
/// (types/spring_rest.hpp), so that no loop of the hand gains energy. Fixtures with a joint law have one common
/// correction for each priority, and so one account.
class KeptEnergy {
 public:
  /// dt: period of the cycle [s].
  explicit KeptEnergy(double dt) : dt_(dt) {}
  /// Scales the wrenches of the soft fixtures of a tool at X_WT, after the priorities.
  void step(FixtureStates& states, const Pose& X_WT) noexcept;

 private:
  /// The energy of a fixture, or of several with one correction.
  struct Account {
    Wrench F;               ///< at the last tick, as `Stored`
    std::uint64_t key = 0;  ///< of the fixtures; 0: none acted
    bool appears = false;   ///< the energy has grown by itself ever since the last edit
    double slack = 0.0;     ///< as `Stored`
    SpringRest rest;
  };
  /// What a fixture stores: at an authority of one, or, if it is cut on a ramp, at the present one.
  struct Stored {
    double U = 0.0;         ///< energy whose gradient the wrench is [J]
    double motion = 0.0;    ///< part that the motion of the fixture stored since the last tick [J]
    Wrench F;               ///< [N, N m]
    std::uint64_t key = 0;  ///< of the fixtures
    bool edited = false;    ///< the energy does not follow from the last one and the motion
    double slack = 0.0;     ///< tolerated violations, whose decrease lets the energy grow [m, rad]
    bool rises = false;     ///< an authority that follows the hand rises, which lets the energy grow
    double inexact = 0.0;   ///< error of the work of a tick, relative to force times motion
  };
  static double share(Account& account, const Stored& now, const Twist& moved) noexcept;
  [[nodiscard]] Stored stored(const Fixture& fixture, FixtureState& now, bool ramped) const noexcept;
  void step_joint(FixtureStates& states, int first, const Twist& moved) noexcept;

  double dt_;
  Pose X_WT_;
  std::array<Account, kMaxFixtures> account_{};  ///< a joint law has that of the first fixture of its priority
};

}  // namespace palpate::guidance
