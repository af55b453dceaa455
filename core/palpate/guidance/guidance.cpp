#include "palpate/guidance/guidance.hpp"

#include <cmath>
#include <limits>
#include <memory>

#include "palpate/types/status.hpp"

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
  out_.energy = apply_laws(states_, hard_, joint_, follower_, in);
  priorities_.apply(states_, in.handle.renders_damping);
  out_.on_tool = blend_.step(states_, in, before_);
  report(in);
  before_ = in.goal;
  follower_.command(out_.X_WT_goal.p);
  return out_;
}

void Guidance::correct(const Input& in) noexcept {
  const Pose& mapped = in.goal.X_WT_goal;
  const bool joint = joint_.needed(states_);
  if (joint) {
    if (!joint_started_) joint_.start_at(mapped);
    joint_.step(states_, in);
  }
  joint_started_ = joint;
  if (hard_.needed(states_)) {
    if (!hard_.step(states_, in)) out_.status |= kGuidanceConflict;
  } else if (same(hard_.X_WT(), before_.X_WT_goal)) {
    hard_.start_at(mapped);  // exact equality: no hard fixture corrects the goal or did so before
  } else {
    hard_.start_at(hard_.towards(mapped, states_, in));
  }
  out_.X_WT_goal = hard_.X_WT();
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
