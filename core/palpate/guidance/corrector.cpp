#include "palpate/guidance/corrector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/types/index.hpp"

namespace palpate::guidance {
namespace {

constexpr int kRounds = 6;               // rounds of linearisation and solution
constexpr int kRoundsToSettle = 40;      // the same where rows of a guiding surface are not its gradient
constexpr double kSettled = 1e-7;        // [m] motion of the solution in the last of these rounds
constexpr double kSameRow = 1.0 - 1e-6;  // cosine (1.4 mrad): rows that are closer have one direction
constexpr double kTolerance = 1e-8;      // [m, rad] constraint violation accepted as satisfied
constexpr double kOvertaken = 1e-6;      // [m] a border that overtakes the goal by more pushes it
constexpr double kMostCorrection = 0.5;  // [m] a larger correction is rejected
constexpr double kBeforeTarget = 1e-6;   // [m] distance before a target at which its constraint has a gradient
constexpr double kJump = 1e-3;           // [m] a border that moves farther in one period has jumped

// Amount by which the mapped goal violates the side of a border that was evaluated at X, linearised there [m]. Another
// side may be nearer to the goal.
double beyond(const Constraint& c, const Pose& X, const Input& in) noexcept {
  return row(c).dot(displacement(in.goal.X_WT_goal, X)) - c.gap;
}

bool guides_to_surface(const Constraint& c) noexcept { return c.attracts && !c.rotational && c.free.trace() > 1.5; }

}  // namespace

bool Corrector::needed(const FixtureStates& states) const noexcept {
  bool any = false;
  for (int i = 0; i < states.size(); ++i) any |= has(states, i);
  return any;
}

void Corrector::add(const Vec6& a, double b, int rank, int fixture) noexcept {
  const int r = qp_.add(a, b, rank);
  if (r >= 0) fixture_of_[to_index(r)] = fixture;
}

// Evaluates the constraints of all members at X. At the mapped goal they have been evaluated already.
void Corrector::evaluate(const FixtureStates& states, const Pose& X, const Input& in) noexcept {
  const Pose& mapped = in.goal.X_WT_goal;
  const bool at_goal = X.p == mapped.p && X.R == mapped.R;
  for (int i = 0; i < states.size(); ++i) {
    if (has(states, i)) constraint_[to_index(i)] = at_goal ? states[i].constraint : states.evaluate(i, X, in);
  }
}

// Violation that is allowed to a constraint evaluated at X: of a border, the fraction of that of its own side.
double Corrector::allowed(const FixtureState& state, const Constraint& c, const Pose& X, const Input& in) noexcept {
  if (state.authority >= 1.0 || !has_sides(c)) return state.allowed();
  return std::max(state.slack, (1.0 - state.authority) * beyond(c, X, in));
}

// When a fixture appears, is edited or jumps, goal and tool may violate it. The slack allows that violation and
// decreases at the return speed.
void Corrector::update_slack(FixtureStates& states, int i, const Input& in) const noexcept {
  FixtureState& now = states[i];
  const Constraint& c = constraint_[to_index(i)];
  const double pace = return_speed_ * dt_ / (c.rotational ? kLength : 1.0);
  now.slack = std::max(now.slack - pace, 0.0);
  const bool jumped = c.violation() - allowed(now, c, X_WT_, in) > (c.rotational ? kJump / kLength : kJump);
  if (!now.needs_slack && !jumped) return;
  now.needs_slack = false;
  now.slack = std::max(c.violation(), c.attracts ? 0.0 : states.evaluate(i, in.tool.X_WT, in).violation());
}

// Remaining distance of the goal to its border in the coming period, after the allowed violation, the standoff and the
// border's own motion; negative when violated [m, rad].
double Corrector::room(const FixtureState& state, const Constraint& c, const Pose& X, const Input& in) const noexcept {
  const double keep = follower_ != nullptr && !c.attracts ? follower_->standoff() : 0.0;
  return c.gap + allowed(state, c, X, in) - keep - std::max(-c.gap_rate_of_fixture, 0.0) * dt_;
}

// Largest violation at the last evaluated pose X beyond the allowed one [m].
double Corrector::worst_violation(const FixtureStates& states, const Pose& X, const Input& in) const noexcept {
  double worst = 0.0;
  for (int i = 0; i < states.size(); ++i) {
    const Constraint& c = constraint_[to_index(i)];
    if (!has(states, i) || !c.one_sided()) continue;
    const double lacks = -room(states[i], c, X, in);
    worst = std::max(worst, c.rotational ? kLength * lacks : lacks);
  }
  return worst;
}

// Adds the linearised constraint room(X) + J . (y - y_X) >= 0.
void Corrector::add_row(const FixtureStates& states, int i, const Constraint& c, const Pose& X,
                        const Input& in) noexcept {
  if (!c.one_sided()) return;
  const Vec6 a = row(c);
  add(a, a.dot(displacement(in.goal.X_WT_goal, X)) - room(states[i], c, X, in), states.fixture(i).policy.priority, i);
}

// Adds the row with which the tool, which lags its goal, satisfies the constraint as well. Returns the amount by which
// the present goal violates this row [m].
double Corrector::add_tool_row(const FixtureStates& states, int i, const Input& in) noexcept {
  const Constraint c = states.evaluate(i, in.tool.X_WT, in);
  if (!c.one_sided() || c.attracts || c.rotational) return 0.0;
  const Vec6 a = row(c);
  const double lead = follower_->lead(c, states[i].allowed());
  const Pose X = {in.goal.X_WT_goal.R, in.tool.X_WT.p};
  add(a, a.dot(displacement(in.goal.X_WT_goal, X)) + lead, states.fixture(i).policy.priority, i);
  return lead - c.gradient.f.dot(X_WT_.p - in.tool.X_WT.p);
}

// Adds the rows that are not re-linearised in this tick: joint limits, rows of the tool, and attracting fixtures
// linearised at the mapped goal. Returns the largest violation of the tool's rows [m].
double Corrector::add_lasting_rows(const FixtureStates& states, const Input& in) noexcept {
  double violation = 0.0;
  qp_.clear();
  if (follower_ != nullptr) {
    follower_->add_joint_rows(in, [this](const Vec6& a, double b, int rank) { add(a, b, rank, -1); });
  }
  for (int i = 0; i < states.size(); ++i) {
    if (!has(states, i)) continue;
    if (follower_ != nullptr && follower_->lags()) violation = std::max(violation, add_tool_row(states, i, in));
    if (states[i].constraint.attracts) add_row(states, i, states[i].constraint, in.goal.X_WT_goal, in);
  }
  return violation;
}

// Solves and re-linearises. Repelling fixtures are linearised at the previous goal, so that the goal stays on its side
// of them, and again at each solution. Attracting fixtures add a cutting plane where a solution violates them. Returns
// false if there is no solution; the goal then stays in place.
bool Corrector::iterate(const FixtureStates& states, const Input& in, int lasting, Pose& X,
                        Qp::Status& status) noexcept {
  for (int round = 0; round < kRounds; ++round) {
    for (int i = 0; i < states.size(); ++i) {
      if (!has(states, i)) continue;
      const Constraint& c = constraint_[to_index(i)];
      const bool cuts = round > 0 && c.violation() > states[i].allowed() + kTolerance;
      if (!c.attracts || cuts) add_row(states, i, c, X, in);
    }
    status = qp_.solve(Vec6::Zero());
    if (!(qp_.y().norm() < kMostCorrection)) return false;
    X = displaced(in.goal.X_WT_goal, qp_.y());
    if (status == Qp::Status::stopped || round + 1 == kRounds) break;
    evaluate(states, X, in);
    if (worst_violation(states, X, in) < kTolerance || qp_.rows() + states.size() > Qp::kRows) break;
    drop_misleading_rows(states, lasting, X, in);
  }
  return true;
}

bool Corrector::step(FixtureStates& states, const Input& in) noexcept {
  const Pose& mapped = in.goal.X_WT_goal;
  Pose X = X_WT_;
  if (follower_ != nullptr) follower_->begin(X, in);
  evaluate(states, X, in);
  for (int i = 0; i < states.size(); ++i) {
    if (has(states, i)) update_slack(states, i, in);
  }
  const double lacks = worst_violation(states, X, in);
  const double overtaken = std::max(lacks, add_lasting_rows(states, in));
  const int lasting = qp_.rows();
  Qp::Status status = Qp::Status::solved;
  held_ = !iterate(states, in, lasting, X, status);
  if (held_) return false;
  if (leans(states, in, X)) settle(states, in, lasting, X);
  collect_rows(states);
  // A feasible goal is replaced only by one nearer to the mapped goal, so that it does not move at rest.
  const Vec6 stays = displacement(mapped, X_WT_);
  if (lacks < kTolerance && stays.norm() <= qp_.y().norm() && qp_.satisfies(stays, lasting)) X = X_WT_;
  if (follower_ != nullptr) {
    X = towards(X, states, in);
    // A border that has moved over the goal pushes it even if its speed was limited above.
    if (overtaken > kOvertaken && qp_.solve(displacement(mapped, X)) != Qp::Status::stopped &&
        qp_.y().norm() < kMostCorrection) {
      X = displaced(mapped, qp_.y());
    }
  }
  X_WT_ = X;
  return status == Qp::Status::solved;
}

// The pose a little before X on the way from the mapped goal: a target has no gradient at itself.
Pose Corrector::before(const Pose& X, const Input& in) noexcept {
  return displaced(X, -kBeforeTarget * displacement(in.goal.X_WT_goal, X).stableNormalized());
}

// True if an active row of a guiding surface is not its gradient at the solution X, which then lies where cutting
// planes meet and not at the nearest place. (A line is held by rows of two directions.)
bool Corrector::leans(const FixtureStates& states, const Input& in, const Pose& X) const noexcept {
  for (int r = 0; r < qp_.rows(); ++r) {
    const int i = fixture_of_[to_index(r)];
    if (i < 0 || !(qp_.multiplier(r) > 0.0) || !guides_to_surface(states[i].constraint)) continue;
    const Vec6 a = qp_.row(r), b = row(states.evaluate(i, before(X, in), in));
    if (a.dot(b) < kSameRow * a.norm() * b.norm()) return true;
  }
  return false;
}

// Moves the solution to the nearest place, starting at the last goal, with one row for each border, so that the goal
// follows the hand by a map that has a derivative. X and rows stay if the rounds settle at no nearer place.
void Corrector::settle(const FixtureStates& states, const Input& in, int lasting, Pose& X) noexcept {
  const Qp qp = qp_;
  const auto fixture_of = fixture_of_;
  int others = 0;  // lasting rows without those of the attracting fixtures at the mapped goal
  for (int r = 0; r < lasting; ++r) {
    const int i = fixture_of_[to_index(r)];
    if (i >= 0 && states[i].constraint.attracts) continue;
    fixture_of_[to_index(others)] = i;
    qp_.move(r, others++);
  }
  const double farthest = qp_.y().norm() + kSettled;
  Pose X_now = X_WT_;
  for (int round = 0; round < kRoundsToSettle; ++round) {
    qp_.truncate(others);
    for (int i = 0; i < states.size(); ++i) {
      if (!has(states, i)) continue;
      const Pose at = states[i].constraint.attracts ? before(X_now, in) : X_now;
      add_row(states, i, states.evaluate(i, at, in), at, in);
    }
    if (qp_.solve(Vec6::Zero()) != Qp::Status::solved || !(qp_.y().norm() < kMostCorrection)) break;
    const double moved = (qp_.y() - displacement(in.goal.X_WT_goal, X_now)).norm();
    X_now = displaced(in.goal.X_WT_goal, qp_.y());
    if (moved > kSettled) continue;
    if (qp_.y().norm() > farthest) break;
    X = X_now;
    return;
  }
  qp_ = qp;
  fixture_of_ = fixture_of;
}

// Removes rows that predicted less room than the constraint has at the solution: the border curves away from such a
// row, which would forbid feasible poses. A row that predicted more room is kept in addition to the newer one, because
// where walls meet each wall needs its own row.
void Corrector::drop_misleading_rows(const FixtureStates& states, int from, const Pose& X, const Input& in) noexcept {
  int rows = from;
  for (int r = from; r < qp_.rows(); ++r) {
    const int i = fixture_of_[to_index(r)];
    const Constraint& c = constraint_[to_index(i)];
    if (!c.attracts && qp_.slack(r) < room(states[i], c, X, in)) continue;
    fixture_of_[to_index(rows)] = i;
    qp_.move(r, rows++);
  }
  qp_.truncate(rows);
}

Pose Corrector::towards(const Pose& X_goal, const FixtureStates& states, const Input& in) noexcept {
  double speed = std::numeric_limits<double>::infinity();
  for (int i = 0; i < states.size(); ++i) {
    if (has(states, i)) speed = std::min(speed, states[i].constraint.speed_limit);
  }
  return follower_->towards(X_WT_, X_goal, speed, in);
}

}  // namespace palpate::guidance
