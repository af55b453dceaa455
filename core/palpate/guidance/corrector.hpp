// Projects the commanded goal onto the set of poses that several fixtures allow together, by a quadratic program.
//
//   y = displacement from the mapped goal       min |y|^2 / 2,   for every fixture:  gap(X) + J . (y - y_X) >= -allowed
//
// The program is linearised at the previous solution, so that the goal stays on its side of a thin fixture, and again
// at each new solution, at most kRounds times, until all constraints hold within 10 nm.
#pragma once

#include <array>
#include <optional>

#include "palpate/guidance/correction_map.hpp"
#include "palpate/guidance/fixture_state.hpp"
#include "palpate/guidance/follower_limits.hpp"
#include "palpate/guidance/qp.hpp"
#include "palpate/types/index.hpp"

namespace palpate::guidance {

/// Finds the nearest pose that all its member fixtures allow.
class Corrector {
 public:
  using Member = bool (*)(const Fixture&) noexcept;  ///< true for fixtures that the corrector satisfies

  /// member: selects the fixtures. dt: period of the cycle [s]. follower: limits of the follower if the tool follows
  /// the solution; null if the solution is only the target of a force.
  Corrector(Member member, const Options& options, double dt, FollowerLimits* follower = nullptr)
      : member_(member), follower_(follower), return_speed_(options.return_speed), dt_(dt) {}

  /// Selects, among the fixtures that are members, those of one priority.
  void choose(int priority) noexcept { priority_ = priority; }
  /// True if an active fixture is a member.
  [[nodiscard]] bool needed(const FixtureStates& states) const noexcept;
  /// One tick: finds the nearest allowed goal, starting at the previous one. Returns false if constraints contradict
  /// each other.
  bool step(FixtureStates& states, const Input& in) noexcept;

  /// The corrected goal.
  [[nodiscard]] const Pose& X_WT() const noexcept { return X_WT_; }
  /// Sets the goal from which the next step() starts.
  void start_at(const Pose& X_WT) noexcept { X_WT_ = X_WT; }
  /// The goal moved towards X_goal by one period, within the limits of follower and speed; for a corrector with a
  /// follower.
  [[nodiscard]] Pose towards(const Pose& X_goal, const FixtureStates& states, const Input& in) noexcept;

  /// Linearises the solution of the last step() around the mapped goal. The constraints in `states` must be those at
  /// the mapped goal. at_tool: a wrench acts on the tool, so that the curvature of the borders counts; else only where
  /// several rows act or the rotation matters.
  void linearise(const FixtureStates& states, const Input& in, bool at_tool) noexcept;
  /// The linearised map from the mapped to the corrected goal, with the share of each fixture in the correction.
  [[nodiscard]] const CorrectionMap& map() const noexcept { return map_; }

 private:
  [[nodiscard]] bool has(const FixtureStates& states, int i) const noexcept {
    const Fixture& f = states.fixture(i);
    return states[i].active() && member_(f) && (!priority_ || *priority_ == f.policy.priority);
  }
  void evaluate(const FixtureStates& states, const Pose& X_WT, const Input& in) noexcept;
  void update_slack(FixtureStates& states, int i, const Input& in) const noexcept;
  /// True for a border whose sides are told apart: an allowed violation is that of the side to which a goal is moved.
  [[nodiscard]] static bool has_sides(const Constraint& c) noexcept {
    return c.one_sided() && !c.attracts && !c.rotational;
  }
  [[nodiscard]] static double allowed(const FixtureState& state, const Constraint& c, const Pose& X,
                                      const Input& in) noexcept;
  [[nodiscard]] double room(const FixtureState& state, const Constraint& c, const Pose& X,
                            const Input& in) const noexcept;
  [[nodiscard]] double worst_violation(const FixtureStates& states, const Pose& X, const Input& in) const noexcept;
  void add(const Vec6& a, double b, int rank, int fixture) noexcept;
  void add_row(const FixtureStates& states, int i, const Constraint& c, const Pose& X, const Input& in) noexcept;
  double add_tool_row(const FixtureStates& states, int i, const Input& in) noexcept;
  double add_lasting_rows(const FixtureStates& states, const Input& in) noexcept;
  bool iterate(const FixtureStates& states, const Input& in, int lasting, Pose& X, Qp::Status& status) noexcept;
  void drop_misleading_rows(const FixtureStates& states, int from, const Pose& X, const Input& in) noexcept;
  static Pose before(const Pose& X, const Input& in) noexcept;
  [[nodiscard]] bool leans(const FixtureStates& states, const Input& in, const Pose& X) const noexcept;
  void settle(const FixtureStates& states, const Input& in, int lasting, Pose& X) noexcept;
  void collect_rows(const FixtureStates& states) noexcept;
  void bend(const FixtureStates& states, ActiveRow& row, const Input& in) const noexcept;

  Member member_;
  FollowerLimits* follower_;
  std::optional<int> priority_;
  double return_speed_, dt_;
  Pose X_WT_;
  Qp qp_;
  std::array<int, Qp::kRows> fixture_of_{};            ///< fixture of each row; -1 for a joint limit
  std::array<Constraint, kMaxFixtures> constraint_{};  ///< constraint of each fixture at the newest solution
  CorrectionMap map_;
  bool held_ = false;  ///< the last step found no solution: the goal stays in place
};

}  // namespace palpate::guidance
