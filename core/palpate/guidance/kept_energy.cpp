#include "palpate/guidance/kept_energy.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/guidance/authority.hpp"
#include "palpate/types/so3.hpp"
#include "palpate/types/virtual_work.hpp"

namespace palpate::guidance {
namespace {

constexpr double kInexact = 2e-4;       // error of the work of a tick, relative to force times motion
constexpr double kInexactJoint = 2e-3;  // the same where a program finds the correction
constexpr double kCrease = 0.1;         // change of a force in a tick, relative to it, that a crease explains
constexpr int kSteps = 16;              // of an integral over the gap
constexpr double kInexactMotion = 0.1;  // of the energy by the motion of a fixture: its velocity is that of one moment

Twist motion(const Pose& from, const Pose& to) noexcept {
  return {to.p - from.p, rotation_vector(to.R * from.R.transpose())};
}

double work(const Wrench& F, const Twist& moved) noexcept { return -F.f.dot(moved.v) - F.t.dot(moved.w); }

/// Energy that the motion of a fixture with the wrench F, and of those above it, stores in a period [J].
double energy_of_motion(const FixtureState& now, const Wrench& F, double dt) noexcept {
  const Wrench& J = now.constraint.gradient;
  const double size = J.f.squaredNorm() + J.t.squaredNorm() / (kLength * kLength);
  const double along = F.f.dot(J.f) + F.t.dot(J.t) / (kLength * kLength);
  const double own = size > 0.0 ? -along / size * now.constraint.gap_rate_of_fixture : 0.0;
  return (own + now.power_above) * dt;
}

/// True if fixture i, with a joint law, is the first such one of its priority in the list.
bool first_of_priority(const FixtureStates& states, int i) noexcept {
  for (int j = 0; j < i; ++j) {
    const Fixture& other = states.fixture(j);
    if (has_joint_law(other) && other.policy.priority == states.fixture(i).policy.priority) return false;
  }
  return true;
}

/// Energy whose gradient is the fixture's force times its factor by distance: the sum of the changes of the law's own
/// energy in equal steps of the gap, times the factor in the middle of each [J].
double energy_with_ramps(const Fixture& fixture, Constraint c) noexcept {
  const double begin = c.attracts ? 0.0 : fixture.law->reach(), whole = begin - c.gap;
  if (!(whole > 0.0) || !std::isfinite(whole)) return 0.0;
  double sum = 0.0, before = 0.0;
  for (int k = 0; k < kSteps; ++k) {
    c.gap = begin - whole * (k + 1) / kSteps;
    const double U = fixture.law->force(c, {}).U;
    sum += factor_by_distance(fixture.policy, begin - whole * (k + 0.5) / kSteps) * (U - before);
    before = U;
  }
  return sum;
}

/// Energy that a fixture with ramps by distance stores at its present authority [J]. Rise and fall times delay the
/// authority; the part that is still too large adds to the force of the law as it is.
double present_energy(const Fixture& fixture, const FixtureState& now) noexcept {
  const double wanted = fixture.policy.authority * factor_by_distance(fixture.policy, now.constraint.gap);
  const double U = fixture.policy.authority * energy_with_ramps(fixture, now.constraint);
  if (!now.active()) return U;
  if (now.authority < wanted) return U * now.authority / wanted;
  return U + (now.authority - wanted) / now.authority * now.force.U;
}

/// True if a fixture that does not act is only too far away: its authority returns with the hand.
bool is_too_far(const Fixture& fixture, const FixtureState& now) noexcept {
  return !now.active() && fixture.on && follows_distance(fixture.policy) &&
         !(factor_by_distance(fixture.policy, now.constraint.gap) > 0.0);
}

/// True if the authority of fixture i follows the distance, and a soft fixture of higher priority may move its goal:
/// its energy then includes the ramp.
bool is_cut_on_a_ramp(const FixtureStates& states, int i) noexcept {
  const Policy& own = states.fixture(i).policy;
  if (!follows_distance(own)) return false;
  bool cut = false;
  for (int j = 0; j < states.size(); ++j) {
    const Policy& other = states.fixture(j).policy;
    cut |= !other.hard && other.priority > own.priority;
  }
  return cut;
}

}  // namespace

void KeptEnergy::step(FixtureStates& states, const Pose& X_mapped, const Pose& X_corrected, const Mat6& J) noexcept {
  const Twist hand = motion(X_mapped_, X_mapped), tool = motion(X_corrected_, X_corrected);
  X_mapped_ = X_mapped, X_corrected_ = X_corrected;
  for (int i = 0; i < states.size(); ++i) {
    Account& account = account_[to_index(i)];
    const Fixture& fixture = states.fixture(i);
    if (fixture.policy.hard) {
      account.key = 0;
    } else if (fixture.law->solves_jointly()) {
      if (first_of_priority(states, i)) step_joint(states, i, tool);
    } else if (states[i].active()) {
      scale(states[i].force, share(account, stored(fixture, states[i], is_cut_on_a_ramp(states, i)), tool));
    } else if (account.key != states[i].key || !is_cut_on_a_ramp(states, i) || !is_too_far(fixture, states[i])) {
      account.key = 0;
    } else {
      account.F = {};
    }
  }
  step_hard(states, hand, J);
}

// Lets the fixtures with a joint law that have the priority of fixture `first` keep the energy of their common
// correction, which follows their authorities.
void KeptEnergy::step_joint(FixtureStates& states, int first, const Twist& moved) noexcept {
  const auto is_joint = [&](int i) {
    return has_joint_law(states.fixture(i)) &&
           states.fixture(i).policy.priority == states.fixture(first).policy.priority;
  };
  Stored all;
  all.joint = true;
  for (int i = 0; i < states.size(); ++i) {
    const Fixture& fixture = states.fixture(i);
    FixtureState& now = states[i];
    if (!is_joint(i) || !(now.active() || is_too_far(fixture, now))) continue;
    const bool ramped = follows_distance(fixture.policy);
    all.U += ramped ? present_energy(fixture, now) : now.force.U;
    all.F = all.F + now.force.F;
    all.motion += energy_of_motion(now, now.F_left, dt_);
    all.key += now.key;
    all.edited |= now.edited || (now.rise > 0.0 && !ramped);
    all.slack += now.slack;
    now.edited = false;
  }
  const double by = share(account_[to_index(first)], all, moved);
  for (int i = 0; by < 1.0 && i < states.size(); ++i) {
    if (is_joint(i) && states[i].active()) scale(states[i].force, by);
  }
}

// Lets the hard fixtures keep the energy of their common correction, at the hand: there they act if they hold the tool,
// and by J if they do not. Dampers store nothing.
void KeptEnergy::step_hard(FixtureStates& states, const Twist& moved, const Mat6& J) noexcept {
  const auto stores = [&](int i) {
    return states.fixture(i).policy.hard && states[i].active() && std::isinf(states[i].constraint.speed_limit);
  };
  Stored all;
  for (int i = 0; i < states.size(); ++i) {
    FixtureState& now = states[i];
    if (!stores(i)) continue;
    all.U += now.force.U;
    all.F = all.F + (now.corrects ? now.force.F : carried_back(J, now.force.F));
    all.motion += energy_of_motion(now, now.force.F, dt_);
    all.key += now.key;
    all.holding += now.corrects ? 1 : 0;
    all.edited |= now.edited || now.rise > 0.0;
    all.slack += now.slack;
    now.edited = false;
  }
  const double by = share(hard_, all, moved);
  for (int i = 0; by < 1.0 && i < states.size(); ++i) {
    if (stores(i)) scale(states[i].force, by);
  }
}

KeptEnergy::Stored KeptEnergy::stored(const Fixture& fixture, FixtureState& now, bool ramped) const noexcept {
  const double one = ramped ? 1.0 : 1.0 / now.authority;
  Stored out;
  out.F = {one * now.force.F.f, one * now.force.F.t};
  out.U = ramped ? present_energy(fixture, now) : one * now.force.U;
  out.motion = one * energy_of_motion(now, now.F_left, dt_);
  out.key = now.key;
  out.edited = now.edited;
  out.slack = now.slack;
  out.creased = true;
  out.rises = ramped && now.rise > 0.0;
  now.edited = false;
  return out;
}

double KeptEnergy::share(Account& account, const Stored& now, const Twist& moved) noexcept {
  const Wrench last = account.F;
  const int holding = account.holding;
  const bool appears = now.key != account.key, begins = now.edited || appears;
  // A goal that jumps renews the slack, which no longer only shrinks.
  const bool shrinks = begins ? now.slack > 0.0 : now.slack < account.slack;
  account.appears = (begins || account.appears) && (now.rises || shrinks);
  account.slack = now.slack;
  account.F = now.F;
  account.key = now.key;
  account.holding = now.holding;
  if (appears || account.appears) {
    account.spring.start(now.U);
    return 1.0;
  }
  if (now.edited) return account.spring.edit(now.U);
  const double before = work(last, moved), after = work(now.F, moved);
  double inexact =
      (now.joint ? kInexactJoint : kInexact) * (now.F.f.norm() * moved.v.norm() + now.F.t.norm() * moved.w.norm());
  inexact += kInexactMotion * std::abs(now.motion);
  const bool steps = now.joint || (now.creased && (now.F.f - last.f).norm() > kCrease * now.F.f.norm());
  if (steps || now.holding != holding) inexact += 0.5 * std::abs(after - before);  // somewhere within the tick
  return account.spring.step(now.U, before, after, now.motion, inexact);
}

}  // namespace palpate::guidance
