#include "palpate/guidance/guidance.hpp"

#include <cmath>
#include <limits>
#include <memory>

#include "palpate/types/status.hpp"
#include "palpate/types/virtual_work.hpp"

namespace palpate::guidance {
namespace {

constexpr double kMomentLength = 0.02;  // [m] length that makes a moment comparable to a force

Options checked(Options options) {
  check(options);
  return options;
}

bool corrects_goal(const Fixture& f) noexcept { return f.policy.hard; }

bool has_joint_law(const Fixture& f) noexcept { return !f.policy.hard && f.law->solves_jointly(); }

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
  out_.status = authority_.step(states_, in);
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
      const bool at_hand = states_.fixture(i).policy.hard && hard_.map().share(i).size > 0.0;
      if (states_[i].active() && !at_hand) states_[i].constraint = states_.evaluate(i, out_.X_WT_goal, in);
    }
  }
  const bool joint = joint_.needed(states_);
  if (joint) {
    if (!joint_started_) joint_.start_at(out_.X_WT_goal);
    joint_.step(states_, at_tool);
    joint_.linearise(states_, at_tool, false);
  }
  joint_started_ = joint;
  out_.energy = apply_laws(states_, hard_, joint_, follower_, {in, at_tool, J_before_});
  priorities_.apply(states_, in.handle.renders_damping);
  kept_.step(states_, out_.X_WT_goal);
  out_.on_tool = blend_.step(states_, in, before_, out_.J_goal);
  for (int i = 0; i < states_.size(); ++i) {  // every wrench is reported as the hand feels it
    FixtureState& now = states_[i];
    if (now.active() && !now.corrects) now.force.F = carried_back(out_.J_goal, now.force.F);
  }
}

// True if a fixture that does not correct the goal may exert a wrench on the tool.
bool Guidance::soft_acts() const noexcept {
  for (int i = 0; i < states_.size(); ++i) {
    if (states_[i].active() && !states_.fixture(i).policy.hard) return true;
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
