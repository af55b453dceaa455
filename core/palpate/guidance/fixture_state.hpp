// The fixtures of the list with what the stage remembers of each.
#pragma once

#include <array>
#include <cstdint>

#include "palpate/guidance/fixture.hpp"
#include "palpate/guidance/input.hpp"
#include "palpate/types/index.hpp"

namespace palpate::guidance {

/// One fixture within the stage.
struct FixtureState {
  std::uint64_t key = 0;   ///< hash of the fixture's name
  double authority = 0.0;  ///< after ramps, rise and fall
  double rise = 0.0;       ///< increase of the authority in this tick
  double since = 0.0;      ///< time of engagement [s]
  double slack = 0.0;      ///< violation found when the fixture appeared, decreasing at the return speed [m, rad]
  bool engaged = false, fresh = true;
  Constraint constraint;  ///< at the mapped goal; of a corrected one along its share of the correction
  ConstraintForce force;  ///< times the authority

  [[nodiscard]] bool active() const noexcept { return authority > 0.0; }
  /// Violation that is still allowed: the slack, or the share that an authority below one leaves [m, rad].
  [[nodiscard]] double allowed() const noexcept;
};

/// The list of fixtures and their states, by the same index.
class FixtureStates {
 public:
  /// Another list, which outlives its use. A fixture whose name was in the list before keeps its state.
  void take(const Fixtures& fixtures) noexcept;
  /// Tells the live frames that a tick begins.
  void begin(const Input& in) noexcept;

  [[nodiscard]] int size() const noexcept { return list_ == nullptr ? 0 : static_cast<int>(list_->fixture.size()); }
  [[nodiscard]] const Fixture& fixture(int i) const noexcept { return list_->fixture[to_index(i)]; }
  [[nodiscard]] FixtureState& operator[](int i) noexcept { return state_[to_index(i)]; }
  [[nodiscard]] const FixtureState& operator[](int i) const noexcept { return state_[to_index(i)]; }
  /// The constraint of fixture i for a tool at X_WT; inactive when a number is not finite.
  [[nodiscard]] Constraint evaluate(int i, const Pose& X_WT, const Input& in) const noexcept;

 private:
  const Fixtures* list_ = nullptr;
  std::array<FixtureState, kMaxFixtures> state_{}, old_{};
};

}  // namespace palpate::guidance
