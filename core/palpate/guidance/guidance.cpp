#include "palpate/guidance/guidance.hpp"

#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "palpate/types/status.hpp"
#include "palpate/types/virtual_work.hpp"

namespace palpate::guidance {
namespace {

constexpr double kMomentLength = 0.02;  // [m] length that makes a moment comparable to a force
constexpr double kMostFelt = 3.0;       // largest wrench on the tool, relative to that at the goal left to a fixture

Options checked(Options options) {
  check(options);
  return options;
}

bool corrects_goal(const Fixture& f) noexcept { return f.policy.hard; }

double size_of(const Wrench& F) noexcept { return std::hypot(F.f.norm(), F.t.norm() / kLength); }

bool same(const Pose& a, const Pose& b) noexcept { return a.p == b.p && a.R == b.R; }

}  // namespace

Guidance::Guidance(const Options& options, double dt)
    : authority_(dt),
      follower_(checked(options), dt),
      hard_(&corrects_goal, options, dt, &follower_),
      joint_(&has_joint_law, options, dt),
      kept_(dt),
      blend_(options, dt) {}

std::unique_ptr<Stage> Fixtures::make_stage(const Options& options, double dt) const {
  return std::make_unique<Guidance>(options, dt);
}

const Output& Guidance::step(const Input& in) noexcept {
  if (!started_) {
    before_ = in.goal;
    hard_.start_at(in.goal.X_WT_goal);
    started_ = true;
  }
  states_.begin(in);
  follower_.observe(in.tool.X_WT.p, before_.X_WT_goal);
  out_.status = kOk;
  for (int i = 0; i < states_.size(); ++i) {
    if (states_.fixture(i).policy.hard) out_.status |= authority_.step(states_, i, in);
  }
  correct(in);
  act(in);
  report(in);
  before_ = in.goal;
  follower_.command(out_.X_WT_goal.p);
  return out_;
}

// Corrects the goal by the hard fixtures.
void Guidance::correct(const Input& in) noexcept {
  const Pose& mapped = in.goal.X_WT_goal;
  J_before_ = out_.J_goal;
  out_.J_goal.setIdentity();
  if (hard_.needed(states_)) {
    if (!hard_.step(states_, in)) out_.status |= kGuidanceConflict;
    const Wrench& F = in.tool_force.F_T_W;
    const bool presses = F.f != Vec3::Zero() || F.t != Vec3::Zero();
    hard_.linearise(states_, in, presses || soft_acts());
    out_.J_goal = hard_.map().jacobian();
  } else if (same(hard_.X_WT(), before_.X_WT_goal)) {
    hard_.start_at(mapped);  // exact equality: no hard fixture corrects the goal or did so before
  } else {
    hard_.start_at(hard_.towards(mapped, states_, in));
  }
  out_.X_WT_goal = hard_.X_WT();
}

// Lets the fixtures act: those that correct the goal on the hand, all others on the tool at the corrected goal.
void Guidance::act(const Input& in) noexcept {
  Input at_tool = in;
  at_tool.goal.X_WT_goal = out_.X_WT_goal;
  at_tool.goal.V_WT = carried(out_.J_goal, in.goal.V_WT);
  if (!same(out_.X_WT_goal, in.goal.X_WT_goal)) {
    for (int i = 0; i < states_.size(); ++i) {
      const bool at_hand = hard_.map().share(i).size > 0.0;
      if (states_.fixture(i).policy.hard && states_[i].active() && !at_hand)
        states_[i].constraint = states_.evaluate(i, out_.X_WT_goal, in);
    }
  }
  out_.energy = {};
  const Wrench soft = act_softly(at_tool);
  apply_hard_laws(states_, hard_, follower_, {in, at_tool, J_before_}, soft, out_.energy);
  kept_.step(states_, in.goal.X_WT_goal, out_.X_WT_goal, out_.J_goal);
  out_.on_tool = blend_.step(states_, in, before_, out_.J_goal);
  for (int i = 0; i < states_.size(); ++i) {  // every wrench is reported as the hand feels it
    FixtureState& now = states_[i];
    if (now.active() && !now.corrects) now.force.F = carried_back(out_.J_goal, now.force.F);
  }
}

// Lets the soft fixtures act in the order of their priority, each at the goal that the higher ones leave. Returns the
// sum of their wrenches at the corrected goal.
Wrench Guidance::act_softly(const Input& at_tool) noexcept {
  Wrench sum;
  priorities_.begin(at_tool.goal.X_WT_goal);
  const auto next = [this](const int* above) -> const int* {  // the highest priority below `above`
    const int* found = nullptr;
    for (int i = 0; i < states_.size(); ++i) {
      const Policy& policy = states_.fixture(i).policy;
      if (policy.hard || (above != nullptr && policy.priority >= *above)) continue;
      if (found == nullptr || policy.priority > *found) found = &policy.priority;
    }
    return found;
  };
  for (const int* now = next(nullptr); now != nullptr;) {
    Input at = at_tool;
    at.goal.X_WT_goal = priorities_.X_WT();
    at.goal.V_WT = carried(priorities_.jacobian(), at_tool.goal.V_WT);
    act_at(*now, at);
    const int* after = next(now);
    for (int i = 0; i < states_.size(); ++i) {
      const Policy& policy = states_.fixture(i).policy;
      if (policy.hard || policy.priority != *now) continue;
      sum = sum + states_[i].force.F;
      if (after != nullptr && states_[i].active()) priorities_.add(states_, i, at_tool);
    }
    priorities_.solve();
    now = after;
  }
  return sum;
}

// Lets the soft fixtures of one priority act at the goal that the higher ones leave. Their wrenches are then those at
// the corrected goal.
void Guidance::act_at(int priority, const Input& at) noexcept {
  const auto acts = [&](int i) {
    return !states_.fixture(i).policy.hard && states_.fixture(i).policy.priority == priority;
  };
  int first = -1;
  for (int i = 0; i < states_.size(); ++i) {
    if (!acts(i)) continue;
    if (first < 0) first = i;
    out_.status |= authority_.step(states_, i, at);
  }
  joint_.choose(priority);
  std::optional<Pose>& X_joint = joint_X_WT_[to_index(first)];
  if (joint_.needed(states_)) {
    joint_.start_at(X_joint.value_or(at.goal.X_WT_goal));
    joint_.step(states_, at);
    joint_.linearise(states_, at, false);
    X_joint = joint_.X_WT();
  } else {
    X_joint.reset();
  }
  const Mat6& J = priorities_.jacobian();
  const Mat3 J_p = J.topLeftCorner<3, 3>();
  for (int i = 0; i < states_.size(); ++i) {
    if (!acts(i)) continue;
    apply_soft_law(states_, i, joint_, at.goal.V_WT, out_.energy);
    FixtureState& now = states_[i];
    ConstraintForce& force = now.force;
    now.turned = {};
    now.F_left = force.F;
    now.power_above = 0.0;
    now.edited |= priorities_.edited();
    if (!priorities_.moves()) continue;
    now.turned = {force.F.f.norm(), force.F.t.norm()};
    now.power_above = -force.F.f.dot(priorities_.drift().v) - force.F.t.dot(priorities_.drift().w);
    // Where walls nearly contradict each other, their goal moves much farther than the hand. That is treated as a jump,
    // of which the hand feels no more than kMostFelt times the wrench.
    const double size = size_of(force.F), carried = size_of(carried_back(J, force.F));
    const double by = carried > kMostFelt * size ? kMostFelt * size / carried : 1.0;
    const Mat6 J_felt = by * J;
    force.F = carried_back(J_felt, force.F);
    force.F_of_B = carried_back(J_felt, force.F_of_B);
    force.B = by * by * J_p.transpose() * force.B * J_p;
  }
}

// True if a soft fixture may exert a wrench on the tool.
bool Guidance::soft_acts() const noexcept {
  for (int i = 0; i < states_.size(); ++i) {
    if ((states_.fixture(i).on || states_[i].active()) && !states_.fixture(i).policy.hard) return true;
  }
  return false;
}

double Guidance::stiffness_along(const Vec3& F_T_W) const noexcept {
  const double force = F_T_W.norm();
  double sum = 0.0;
  for (int i = 0; force > 0.0 && i < states_.size(); ++i) {
    const FixtureState& now = states_[i];
    if (now.authority == 0.0 || now.force.F.f == Vec3::Zero()) continue;
    const Law& law = *states_.fixture(i).law;
    const double share = now.constraint.gradient.f.dot(F_T_W) / force;
    sum += now.authority * share * share * (now.constraint.rotational ? law.turning_stiffness() : law.stiffness());
  }
  return sum;
}

// Reports the fixture with the largest wrench, or else the smallest gap.
void Guidance::report(const Input& in) noexcept {
  out_.strongest = -1;
  out_.gap = 0.0;
  double most = 0.0, nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < states_.size(); ++i) {
    const FixtureState& now = states_[i];
    if (!now.active()) continue;
    const double force = now.force.F.f.norm() + now.force.F.t.norm() / kMomentLength;
    if (force > most) most = force, out_.strongest = i, out_.gap = now.constraint.gap;
    if (most == 0.0 && now.constraint.gap < nearest) nearest = now.constraint.gap, out_.gap = nearest;
  }
  if (!std::isfinite(out_.gap)) out_.gap = 0.0;
  out_.correction = out_.X_WT_goal.p - in.goal.X_WT_goal.p;
  if (out_.strongest >= 0) out_.status |= kGuided;
  if (!same(out_.X_WT_goal, in.goal.X_WT_goal)) out_.status |= kGoalCorrected;
}

}  // namespace palpate::guidance
