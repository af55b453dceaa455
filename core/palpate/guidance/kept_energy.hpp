// Fixtures pay back no more than what was put into them.
#pragma once

#include <array>

#include "palpate/guidance/fixture_state.hpp"
#include "palpate/types/spring_rest.hpp"

namespace palpate::guidance {

/// A fixture is the gradient of its energy, but the nearest place of its geometry, of those of higher priority, or of
/// all hard fixtures together may jump. Motion then changes the energy without work. The rest of its spring is
/// displaced by that (types/spring_rest.hpp), so that no loop of the hand gains energy. Fixtures with a joint law have
/// one common correction for each priority, and so one account; hard fixtures have one as well.
class KeptEnergy {
 public:
  /// dt: period of the cycle [s].
  explicit KeptEnergy(double dt) : dt_(dt) {}
  /// Scales the wrenches of all fixtures, after the priorities, for a tool at X_corrected. J: derivative of this
  /// goal with respect to the mapped goal X_mapped, at which hard fixtures act.
  void step(FixtureStates& states, const Pose& X_mapped, const Pose& X_corrected, const Mat6& J) noexcept;

 private:
  /// The energy of a fixture, or of several with one correction.
  struct Account {
    Wrench F;               ///< at the last tick, as `Stored`
    std::uint64_t key = 0;  ///< of the fixtures; 0: none acted
    int holding = 0;        ///< number of hard fixtures that held the tool
    bool appears = false;   ///< the energy has grown by itself ever since the last edit
    double slack = 0.0;     ///< as `Stored`
    SpringAccount spring;
  };
  /// What a fixture stores: at an authority of one, or, if its authority follows the distance, at the present one.
  struct Stored {
    double U = 0.0;         ///< energy whose gradient the wrench is [J]
    double motion = 0.0;    ///< part that the motion of the fixture stored since the last tick [J]
    Wrench F;               ///< [N, N m]
    std::uint64_t key = 0;  ///< of the fixtures
    int holding = 0;        ///< number of hard fixtures that hold the tool
    bool edited = false;    ///< the energy does not follow from the last one and the motion
    double slack = 0.0;     ///< tolerated violations, whose decrease lets the energy grow [m, rad]
    bool creased = false;   ///< the force may step where another part of one geometry becomes the nearest
    bool joint = false;     ///< of fixtures with a joint law
    bool rises = false;     ///< an authority that follows the hand rises, which lets the energy grow
  };
  static double share(Account& account, const Stored& now, const Twist& moved) noexcept;
  [[nodiscard]] Stored stored(const Fixture& fixture, FixtureState& now, bool ramped) const noexcept;
  void step_joint(FixtureStates& states, int first, const Twist& moved) noexcept;
  void step_hard(FixtureStates& states, const Twist& moved, const Mat6& J) noexcept;

  double dt_;
  Pose X_mapped_, X_corrected_;
  std::array<Account, kMaxFixtures> account_{};  ///< a joint law has that of the first fixture of its priority
  Account hard_;
};

}  // namespace palpate::guidance
