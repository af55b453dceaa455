#include "palpate/guidance/forces.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/guidance/law/profile.hpp"
#include "palpate/types/index.hpp"
#include "palpate/types/virtual_work.hpp"

namespace palpate::guidance {
namespace {

constexpr double kLagForce = 3.0;  // [N] largest force towards a goal that a speed limit delays
constexpr double kMoves = 5e-6;    // [m] motion of the hand in one period that explains any change of the map

bool none(const Wrench& F) noexcept { return F.f == Vec3::Zero() && F.t == Vec3::Zero(); }

bool comes_before(const Policy& a, const Policy& b) noexcept {
  return a.hard != b.hard ? a.hard : a.priority > b.priority;
}

bool finite(const ConstraintForce& force) noexcept {
  return force.F.f.allFinite() && force.F.t.allFinite() && force.B.allFinite() && force.F_of_B.f.allFinite();
}

/// True if the energy that a rising authority stores is credited. What the hand can trigger by its motion earns
/// nothing, because it could be repeated: a ramp by distance or force, an engagement by distance.
bool earns_credit(const Policy& policy) noexcept {
  return !policy.hard && std::isinf(policy.engage) &&
         std::none_of(policy.ramps.begin(), policy.ramps.end(),
                      [](const Ramp& ramp) { return ramp.by == Ramp::By::distance || ramp.by == Ramp::By::force; });
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

/// Sets the force of fixture i by its law, before its authority scales it.
void apply_law(FixtureStates& states, int i, const FollowerLimits& follower, const Goals& goals) noexcept {
  FixtureState& now = states[i];
  const Fixture& f = states.fixture(i);
  const Twist& V_WT = (now.corrects ? goals.mapped : goals.corrected).goal.V_WT;
  now.force = f.law->force(now.constraint, V_WT);
  add_preload(now, *f.law);
  const double speed = V_WT.v.norm();
  if (speed > now.constraint.speed_limit) {
    now.force.F.f -= f.law->damping() * (1.0 - now.constraint.speed_limit / speed) * V_WT.v;
    const double pulls = std::min(f.law->stiffness() * follower.lag(), kLagForce);
    if (f.policy.hard) now.force.F.f += pulls * follower.lag_direction();
  }
  if (!finite(now.force)) now.force = ConstraintForce{};
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

/// Largest change of a force [N] and a moment [N m] in one period.
struct Change {
  double f = 0.0, t = 0.0;
};

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

FixtureEnergy apply_laws(FixtureStates& states, const Corrector& hard, const Corrector& joint,
                         const FollowerLimits& follower, const Goals& goals) noexcept {
  FixtureEnergy energy;
  Wrench soft;  // sum of the soft fixtures' wrenches on the tool, which a hard one may take over
  for (int k = 0; k < 2 * states.size(); ++k) {
    const int i = k % states.size();
    FixtureState& now = states[i];
    const Fixture& f = states.fixture(i);
    const bool is_hard = f.policy.hard;
    if (is_hard != (k >= states.size())) continue;  // first the soft ones
    now.force = ConstraintForce{};
    if (!now.active() || !is_hard) now.corrects = false, now.preload = 0.0;
    if (!now.active()) continue;
    if ((is_hard || f.law->solves_jointly()) && std::isfinite(now.constraint.gap)) {
      take_share(now, (is_hard ? hard : joint).map().share(i));
      if (is_hard) take_preload(now, carried_back(goals.J_before, goals.mapped.tool_force.F_T_W + soft));
    }
    apply_law(states, i, follower, goals);
    energy.potential += now.force.U;
    if (earns_credit(f.policy)) energy.credit += now.rise * now.force.U;
    scale(now.force, now.authority);
    energy.present += now.force.U;
    if (!is_hard) soft = soft + now.force.F;
  }
  return energy;
}

void Priorities::apply(FixtureStates& states, bool renders_damping) noexcept {
  std::array<bool, kMaxFixtures> pushes{};
  for (int i = 0; i < states.size(); ++i) {
    pushes[to_index(i)] = states[i].active() && !states[i].corrects && !none(states[i].force.F);
  }
  for (int i = 0; i < states.size(); ++i) {
    if (!pushes[to_index(i)]) continue;
    Wrench& F = states[i].force.F;
    const Vec3 F_B = renders_damping ? states[i].force.F_of_B.f : Vec3(Vec3::Zero());
    Vec6 y;
    y << F.f - F_B, F.t / kLength;
    bool against = false;
    qp_.clear();
    for (int j = 0; j < states.size(); ++j) {
      const bool first = comes_before(states.fixture(j).policy, states.fixture(i).policy);
      if (!pushes[to_index(j)] || !first) continue;
      // A violation over which the damping of fixture j still rises (profile.hpp) counts in proportion.
      const Constraint& c = states[j].constraint;
      const Vec6 a = row(c).stableNormalized();
      const double share = std::min(c.violation() / (c.rotational ? kDampingRampRotational : kDampingRamp), 1.0);
      const double opposes = std::min(a.dot(y), 0.0);
      against |= share * opposes < 0.0;
      qp_.add(a, (1.0 - share) * opposes);
    }
    if (!against) continue;
    const bool found = qp_.solve(y) != Qp::Status::stopped;
    F = found ? Wrench{F_B + qp_.y().head<3>(), kLength * qp_.y().tail<3>()} : Wrench{F_B, Vec3::Zero()};
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
    f += by * change.f;
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
