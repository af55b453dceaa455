#include "palpate/guidance/kept_energy.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/so3.hpp"

namespace palpate::guidance {
namespace {

constexpr double kInexact = 1e-2;   // error of the work of a tick, relative to force times motion: normals of clouds
constexpr double kRounding = 1e-9;  // of a stored energy
constexpr double kInexactMotion = 0.1;  // of the energy by the motion of a fixture: its velocity is that of one moment

double work(const Wrench& F, const Twist& moved) noexcept { return -F.f.dot(moved.v) - F.t.dot(moved.w); }

/// Energy that the motion of a fixture stores in a period, by its force along the gradient at an authority of one [J].
double energy_of_motion(const FixtureState& now, const Wrench& F, double dt) noexcept {
  const Wrench& J = now.constraint.gradient;
  const double size = J.f.squaredNorm() + J.t.squaredNorm() / (kLength * kLength);
  const double along = F.f.dot(J.f) + F.t.dot(J.t) / (kLength * kLength);
  return size > 0.0 ? -along / size * now.constraint.gap_rate_of_fixture * dt : 0.0;
}

}  // namespace

void KeptEnergy::step(FixtureStates& states, const Pose& X_WT) noexcept {
  const Twist moved = {X_WT.p - X_WT_.p, rotation_vector(X_WT.R * X_WT_.R.transpose())};
  X_WT_ = X_WT;
  std::array<Sum, kMaxFixtures> sums{};
  const auto acts = [&](int i) {
    return states[i].active() && !states.fixture(i).policy.hard && !states.fixture(i).law->solves_jointly();
  };
  for (int i = 0; i < states.size(); ++i) {
    if (acts(i)) add(states[i], sums[to_index(i)]);
  }
  for (std::size_t k = 0; k < sums.size(); ++k) settle(account_[k], sums[k], moved);
  for (int i = 0; i < states.size(); ++i) {
    if (acts(i)) scale(states[i].force, account_[to_index(i)].share);
  }
}

void KeptEnergy::add(FixtureState& fixture, Sum& sum) const noexcept {
  const double one = 1.0 / fixture.authority;
  const Wrench F = {one * fixture.force.F.f, one * fixture.force.F.t};
  sum.F = sum.F + F;
  sum.U += one * fixture.force.U;
  sum.by_motion += energy_of_motion(fixture, F, dt_);
  sum.keys += fixture.key;
  sum.by_others |= fixture.edited || fixture.slack > 0.0;
  fixture.edited = false;
}

void KeptEnergy::settle(Account& account, const Sum& now, const Twist& moved) noexcept {
  const Sum& last = account.last;
  account.share = 1.0;
  if (now.by_others || now.keys != last.keys) {
    account.rest.start(now.U);
  } else if (now.keys != 0) {
    const double before = work(last.F, moved), after = work(now.F, moved);
    const double inexact = kInexact * (now.F.f.norm() * moved.v.norm() + now.F.t.norm() * moved.w.norm());
    account.share =
        account.rest.step(now.U, std::min(before, after) + now.by_motion, std::max(before, after) + now.by_motion,
                          inexact + kRounding * now.U + kInexactMotion * std::abs(now.by_motion));
  }
  account.last = now;
}

}  // namespace palpate::guidance
