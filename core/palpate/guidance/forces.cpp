#include "palpate/guidance/forces.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/guidance/law/profile.hpp"
#include "palpate/types/index.hpp"

namespace palpate::guidance {
namespace {

constexpr double kLagForce = 3.0;  // [N] largest force towards a goal that a speed limit delays

bool none(const Wrench& F) noexcept { return F.f == Vec3::Zero() && F.t == Vec3::Zero(); }

bool comes_before(const Policy& a, const Policy& b) noexcept {
  return a.hard != b.hard ? a.hard : a.priority > b.priority;
}

bool finite(const ConstraintForce& force) noexcept {
  return force.F.f.allFinite() && force.F.t.allFinite() && force.B.allFinite() && force.F_of_B.f.allFinite();
}

void scale(ConstraintForce& force, double by) noexcept {
  force.F = {by * force.F.f, by * force.F.t};
  force.F_of_B.f *= by;
  force.B *= by;
  force.U *= by;
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
void take_share(FixtureState& now, double share, const Wrench& direction) noexcept {
  if (!none(direction)) now.constraint.gradient = direction;
  now.constraint.gap = share > 0.0 ? -share / now.authority : std::max(now.constraint.gap, 0.0);
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
                         const FollowerLimits& follower, const Input& in) noexcept {
  FixtureEnergy energy;
  for (int i = 0; i < states.size(); ++i) {
    FixtureState& now = states[i];
    now.force = ConstraintForce{};
    if (!now.active()) continue;
    const Fixture& f = states.fixture(i);
    const bool is_hard = f.policy.hard;
    if ((is_hard || f.law->solves_jointly()) && std::isfinite(now.constraint.gap)) {
      const Corrector& corrector = is_hard ? hard : joint;
      take_share(now, corrector.share(i), corrector.direction(i));
    }
    now.force = f.law->force(now.constraint, in.goal.V_WT);
    const double speed = in.goal.V_WT.v.norm();
    if (speed > now.constraint.speed_limit) {
      now.force.F.f -= f.law->damping() * (1.0 - now.constraint.speed_limit / speed) * in.goal.V_WT.v;
      const double pulls = std::min(f.law->stiffness() * follower.lag(), kLagForce);
      if (is_hard) now.force.F.f += pulls * follower.lag_direction();
    }
    if (!finite(now.force)) now.force = ConstraintForce{};
    energy.potential += now.force.U;
    if (earns_credit(f.policy)) energy.credit += now.rise * now.force.U;
    scale(now.force, now.authority);
  }
  return energy;
}

void Priorities::apply(FixtureStates& states, bool renders_damping) noexcept {
  std::array<bool, kMaxFixtures> pushes{};
  for (int i = 0; i < states.size(); ++i) {
    pushes[to_index(i)] = states[i].active() && !none(states[i].force.F);
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

const DampedWrench& Blend::step(const FixtureStates& states, const Input& in, const ToolGoal& before) noexcept {
  if (!in.goal.engaged) return on_tool_ = {};
  DampedWrench sum;
  double f = options_.force_rate * dt_, t = options_.moment_rate * dt_;
  const double dv = (in.goal.V_WT.v - before.V_WT.v).norm();
  for (int i = 0; i < states.size(); ++i) {
    const FixtureState& now = states[i];
    sum.F = sum.F + now.force.F;
    if (in.handle.renders_damping) {
      sum.F.f -= now.force.F_of_B.f;
      sum.B += now.force.B;
    }
    if (!now.active()) continue;
    const Change change = explained(states.fixture(i), now, in, before, dt_);
    f += change.f;
    // A speed limit has no gradient; only its damping changes with the motion.
    if (std::isfinite(now.constraint.speed_limit)) f += states.fixture(i).law->damping() * dv;
    t += change.t;
  }
  // The change of the damping is limited by the force that it causes at the present velocity.
  const Mat3 change = sum.B - on_tool_.B;
  const double felt = (change * in.goal.V_WT.v).norm(), most = options_.force_rate * dt_;
  on_tool_.B += felt > most ? Mat3(most / felt * change) : change;
  approach(sum.F.f, f, on_tool_.F.f);
  approach(sum.F.t, t, on_tool_.F.t);
  return on_tool_;
}

}  // namespace palpate::guidance
