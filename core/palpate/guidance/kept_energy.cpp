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
  for (int i = 0; i < states.size(); ++i) {
    Account& account = account_[to_index(i)];
    if (!states[i].active() || states.fixture(i).policy.hard || states.fixture(i).law->solves_jointly()) {
      account.last.key = 0;
    } else {
      scale(states[i].force, share(account, states[i], moved));
    }
  }
}

double KeptEnergy::share(Account& account, FixtureState& fixture, const Twist& moved) const noexcept {
  const double one = 1.0 / fixture.authority, U = one * fixture.force.U;
  const Last last = account.last;
  account.last = {{one * fixture.force.F.f, one * fixture.force.F.t}, fixture.key};
  const bool by_others = fixture.edited || fixture.slack > 0.0 || fixture.key != last.key;
  fixture.edited = false;
  if (by_others) {
    account.rest.start(U);
    return 1.0;
  }
  const Wrench& F = account.last.F;
  const double before = work(last.F, moved), after = work(F, moved);
  const double by_motion = energy_of_motion(fixture, F, dt_);
  const double inexact = kInexact * (F.f.norm() * moved.v.norm() + F.t.norm() * moved.w.norm());
  return account.rest.step(U, std::min(before, after) + by_motion, std::max(before, after) + by_motion,
                           inexact + kRounding * U + kInexactMotion * std::abs(by_motion));
}

}  // namespace palpate::guidance
