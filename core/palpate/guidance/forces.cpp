#include "palpate/guidance/forces.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/guidance/authority.hpp"
#include "palpate/guidance/law/profile.hpp"
#include "palpate/types/index.hpp"
#include "palpate/types/virtual_work.hpp"

namespace palpate::guidance {
namespace {

constexpr double kLagForce = 3.0;  // [N] largest force towards a goal that a speed limit delays
constexpr double kMoves = 5e-6;    // [m] motion of the hand in one period that explains any change of the map

bool finite(const ConstraintForce& force) noexcept {
  return force.F.f.allFinite() && force.F.t.allFinite() && force.B.allFinite() && force.F_of_B.f.allFinite();
}

/// Sets gap and gradient of a corrected fixture from its share of the correction. The goal moves only the fraction
/// `authority` of the whole correction; the law is evaluated for the whole correction, and its force is scaled once.
void take_share(FixtureState& now, const CorrectionMap::Share& share) noexcept {
  if (!(share.size > 0.0)) {
    now.constraint.gap = std::max(now.constraint.gap, 0.0);
    return;
  }
  const Vec3 turning = now.constraint.gradient.f;  // the target direction changes with the position
  now.constraint.gradient = share.direction;
  if (now.constraint.rotational) now.constraint.gradient.f = turning;
  now.constraint.gap = -share.size / now.authority;
}

/// The force along the gradient of a constraint that F loses where the constraint holds the tool: the part that presses
/// the tool towards the allowed side, which is what the hand works against [N, N m].
double pressing(const Wrench& F, const Wrench& gradient) noexcept {
  const double size = gradient.f.squaredNorm() + gradient.t.squaredNorm() / (kLength * kLength);
  const double along = F.f.dot(gradient.f) + F.t.dot(gradient.t) / (kLength * kLength);
  return along > 0.0 ? along / size : 0.0;
}

/// Updates the preload of a hard fixture that has taken its share. A border that limits the touched force needs none:
/// the hand goes on feeling that force.
void take_preload(FixtureState& now, const Wrench& felt) noexcept {
  const bool corrected = now.corrects;
  now.corrects = now.constraint.gap < 0.0;
  if (!now.corrects || now.constraint.by_force)
    now.preload = 0.0;
  else if (!corrected)
    now.preload = pressing(felt, now.constraint.gradient);
}

/// Adds the preload to the force of the law. Their sum stays below the largest force of the law, or the preload if that
/// is larger; it depends on the gap alone, so that it has a potential.
void add_preload(FixtureState& now, const Law& law) noexcept {
  if (now.preload == 0.0) return;
  const Wrench& along = now.constraint.gradient;
  const double most = std::max(law.most(now.constraint), now.preload);
  const double more = std::clamp(most - pressing(now.force.F, along), 0.0, now.preload);
  now.force.F = now.force.F + Wrench{more * along.f, more * along.t};
  const double e = now.constraint.violation(), sum = now.force.U + now.preload * e;
  now.force.U = std::isfinite(most) ? std::min(sum, most * e) : sum;
}

/// Scales the force of fixture i by its authority, and adds its energy.
void take_authority(FixtureStates& states, int i, FixtureEnergy& energy) noexcept {
  FixtureState& now = states[i];
  energy.potential += now.force.U;
  if (earns_credit(states.fixture(i).policy)) energy.credit += now.rise * now.force.U;
  scale(now.force, now.authority);
  energy.present += now.force.U;
}

/// Sets the force of fixture i by its law, before its authority scales it.
void apply_law(FixtureStates& states, int i, const Twist& V_WT) noexcept {
  FixtureState& now = states[i];
  const Law& law = *states.fixture(i).law;
  now.force = law.force(now.constraint, V_WT);
  add_preload(now, law);
  const double speed = V_WT.v.norm();
  if (speed > now.constraint.speed_limit) {
    now.force.F.f -= law.damping() * (1.0 - now.constraint.speed_limit / speed) * V_WT.v;
  }
}

/// Bound of the 2-norm of J: 1 for the identity.
double gain_of(const Mat3& J) noexcept {
  return std::sqrt(J.cwiseAbs().rowwise().sum().maxCoeff() * J.cwiseAbs().colwise().sum().maxCoeff());
}

/// Moves `now` towards `goal` by at most `step`.
void approach(const Vec3& goal, double step, Vec3& now) noexcept {
  const Vec3 change = goal - now;
  const double far = change.norm();
  now = far > step ? Vec3(now + step / far * change) : goal;
}

/// The change of a fixture's wrench in one period that the motions of hand and fixture explain.
Change explained(const Fixture& fixture, const FixtureState& now, const Input& in, const ToolGoal& before,
                 double dt) noexcept {
  const Law& law = *fixture.law;
  const Constraint& c = now.constraint;
  const Vec3 turned = in.goal.V_WT.w * dt;
  const double moved = (in.goal.X_WT_goal.p - before.X_WT_goal.p).norm(), turn = turned.norm();
  const double dv = (in.goal.V_WT.v - before.V_WT.v).norm(), dw = (in.goal.V_WT.w - before.V_WT.w).norm();
  const double drift = std::abs(c.gap_rate_of_fixture) * dt;
  const double shift = c.gradient.f.norm(), lever = c.gradient.t.norm();
  const double K = c.rotational ? law.turning_stiffness() : law.stiffness();
  const double rise = K * (shift * moved + lever * turn + drift);
  double damps = c.rotational ? law.turning_damping() * dw : law.damping() * (shift * dv + lever * dw);
  if (in.handle.renders_damping && lever == 0.0 && now.force.B != Mat3::Zero())
    damps = 0.0;  // the device renders this damping
  return {shift * (c.rotational ? rise : rise + damps), lever * (rise + damps)};
}

}  // namespace

void apply_soft_law(FixtureStates& states, int i, const Corrector& joint, const Twist& V_WT,
                    FixtureEnergy& energy) noexcept {
  FixtureState& now = states[i];
  now.force = ConstraintForce{};
  now.corrects = false, now.preload = 0.0;
  if (!now.active()) return;
  const bool is_joint = states.fixture(i).law->solves_jointly() && std::isfinite(now.constraint.gap);
  if (is_joint) take_share(now, joint.map().share(i));
  apply_law(states, i, V_WT);
  if (!finite(now.force)) now.force = ConstraintForce{};
  take_authority(states, i, energy);
}

void apply_hard_laws(FixtureStates& states, const Corrector& hard, const FollowerLimits& follower, const Goals& goals,
                     const Wrench& soft, FixtureEnergy& energy) noexcept {
  for (int i = 0; i < states.size(); ++i) {
    FixtureState& now = states[i];
    const Fixture& f = states.fixture(i);
    if (!f.policy.hard) continue;
    now.force = ConstraintForce{};
    if (!now.active()) {
      now.corrects = false, now.preload = 0.0;
      continue;
    }
    if (std::isfinite(now.constraint.gap)) {
      take_share(now, hard.map().share(i));
      take_preload(now, carried_back(goals.J_before, goals.mapped.tool_force.F_T_W + soft));
    }
    const Twist& V_WT = (now.corrects ? goals.mapped : goals.corrected).goal.V_WT;
    apply_law(states, i, V_WT);
    if (V_WT.v.norm() > now.constraint.speed_limit) {
      now.force.F.f += std::min(f.law->stiffness() * follower.lag(), kLagForce) * follower.lag_direction();
    }
    if (!finite(now.force)) now.force = ConstraintForce{};
    take_authority(states, i, energy);
  }
}

const DampedWrench& Blend::step(const FixtureStates& states, const Input& in, const ToolGoal& before,
                                const Mat6& J) noexcept {
  if (!in.goal.engaged) {
    J_ = J;
    return on_hand_ = {};
  }
  DampedWrench on_hand, on_tool;
  double f = options_.force_rate * dt_, t = options_.moment_rate * dt_, preload = 0.0;
  const double dv = (in.goal.V_WT.v - before.V_WT.v).norm();
  const double gain = std::max(gain_of(J.topLeftCorner<3, 3>()), 1.0);  // the tool may move more than the hand
  const double moved = (in.goal.X_WT_goal.p - before.X_WT_goal.p).norm() + kLength * in.goal.V_WT.w.norm() * dt_;
  for (int i = 0; i < states.size(); ++i) {
    const FixtureState& now = states[i];
    DampedWrench& sum = now.corrects ? on_hand : on_tool;
    sum.F = sum.F + now.force.F;
    if (in.handle.renders_damping) {
      sum.F.f -= now.force.F_of_B.f;
      sum.B += now.force.B;
    }
    preload += now.authority * now.preload;
    if (!now.active()) continue;
    const Change change = explained(states.fixture(i), now, in, before, dt_);
    const double by = now.corrects ? 1.0 : gain * gain;
    f += by * change.f + now.turned.f * std::min(moved / kDampingRamp, 1.0);
    t += now.turned.t * std::min(moved / kDampingRamp, 1.0);
    // A speed limit has no gradient; only its damping changes with the motion.
    if (std::isfinite(now.constraint.speed_limit)) f += states.fixture(i).law->damping() * dv;
    t += by * change.t;
  }
  // The contacts, which reach the hand by J as well, do not step where J does: this sum takes up the difference.
  const Wrench touched = carried_back(J - J_, in.tool_force.F_T_W);
  on_hand_.F.f -= touched.f, on_hand_.F.t -= touched.t;
  // A motion over a border changes the map and what a fixture has taken over; at rest only edits do.
  const Wrench turned = touched + carried_back(J - J_, on_tool.F);
  const double share = std::min(moved / kMoves, 1.0);
  f += share * (turned.f.norm() + std::abs(preload - preload_));
  t += share * turned.t.norm();
  preload_ = preload;
  J_ = J;
  const Mat3 J_p = J.topLeftCorner<3, 3>();
  const DampedWrench sum{on_hand.F + carried_back(J, on_tool.F), on_hand.B + J_p.transpose() * on_tool.B * J_p};
  // The change of the damping is limited by the force that it causes at the present velocity.
  const Mat3 change = sum.B - on_hand_.B;
  const double felt = (change * in.goal.V_WT.v).norm(), most = options_.force_rate * dt_;
  on_hand_.B += felt > most ? Mat3(most / felt * change) : change;
  approach(sum.F.f, f, on_hand_.F.f);
  approach(sum.F.t, t, on_hand_.F.t);
  return on_hand_;
}

}  // namespace palpate::guidance
