// The list of fixtures, with the state that the stage keeps for each of them.
#pragma once

#include <array>
#include <cstdint>

#include "palpate/guidance/fixture.hpp"
#include "palpate/types/index.hpp"

namespace palpate::guidance {

/// Change of a force [N] and of a moment [N m].
struct Change {
  double f = 0.0, t = 0.0;
};

/// State of one fixture.
struct FixtureState {
  std::uint64_t key = 0;    ///< hash of the fixture's name
  double authority = 0.0;   ///< present authority, after ramps, rise and fall [0-1]
  double rise = 0.0;        ///< increase of the authority in this tick
  bool falls = false;       ///< the authority decreased in this tick
  double policy_gap = 0.0;  ///< gap at which the policy was evaluated [m, rad]
  double engaged_at = 0.0;  ///< time at which the fixture engaged [s]
  double slack =
      0.0;  ///< tolerated violation: that found when the fixture appeared, less the return speed times time [m, rad]
  bool engaged = false, needs_slack = true;  ///< fresh: new, edited or jumped, and its slack is not yet set
  bool edited = true;     ///< appeared, edited or jumped: what the fixture stores does not follow from its last force
  bool corrects = false;  ///< a hard fixture that moves the goal: its wrench acts at the mapped, not the corrected goal
  double preload = 0.0;   ///< force along the gradient that the tool had when the fixture began to hold it [N, N m]
  Constraint constraint;  ///< at the goal where the wrench acts; for a corrected fixture gap and gradient of its share
  ConstraintForce force;  ///< force of the law times the authority
  Change turned;          ///< size of the force before fixtures of higher priority turned it
  Wrench F_left;          ///< the force at the goal that fixtures of higher priority leave [N, N m]
  double power_above = 0.0;  ///< rate at which the motion of these fixtures stores energy [W]

  /// True while the fixture has authority, that is, acts.
  [[nodiscard]] bool active() const noexcept { return authority > 0.0; }
  /// Violation that is allowed: the slack, or, if larger, the fraction that an authority below one leaves [m, rad].
  [[nodiscard]] double allowed() const noexcept;
};

/// The factor of a ramp for a measured value [0-1].
[[nodiscard]] double factor(const Ramp& ramp, double measured) noexcept;
/// Factor of the authority by the ramps that follow the distance, at a gap [m, rad].
[[nodiscard]] double factor_by_distance(const Policy& policy, double gap) noexcept;

/// The list of fixtures and their states, which share an index.
class FixtureStates {
 public:
  /// Replaces the list; `fixtures` must outlive its use. A fixture whose name was in the old list keeps its state.
  void take(const FixtureList& fixtures) noexcept;
  /// Updates the live frames at the beginning of a tick.
  void begin(const Input& in) noexcept;

  [[nodiscard]] int size() const noexcept { return list_ == nullptr ? 0 : static_cast<int>(list_->fixture.size()); }
  [[nodiscard]] const Fixture& fixture(int i) const noexcept { return list_->fixture[to_index(i)]; }
  [[nodiscard]] FixtureState& operator[](int i) noexcept { return state_[to_index(i)]; }
  [[nodiscard]] const FixtureState& operator[](int i) const noexcept { return state_[to_index(i)]; }
  /// The constraint of fixture i for a tool at X_WT; an inactive one if the computed constraint is not finite.
  [[nodiscard]] Constraint evaluate(int i, const Pose& X_WT, const Input& in) const noexcept;
  /// The authority that fixture i would have at another gap [m, rad]: its ramps by distance follow the gap.
  [[nodiscard]] double authority_at(int i, double gap) const noexcept;

 private:
  const Fixtures* list_ = nullptr;
  scene::LiveFrame* tool_ = nullptr;  ///< frame that receives the tool's pose; null: none
  std::array<FixtureState, kMaxFixtures> state_{}, old_{};
};

}  // namespace palpate::guidance
