// What the hand feels of the fixtures: each one's law, what gives way to whom, and how fast their sum may change.
#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/guidance/guidance.hpp"
#include "palpate/guidance/law/profile.hpp"
#include "palpate/types/index.hpp"

namespace palpate::guidance {
namespace {

constexpr double kLagForce = 3.0;  // [N] most that a goal behind a limit of speed pulls with

bool none(const Wrench& F) noexcept { return F.f == Vec3::Zero() && F.t == Vec3::Zero(); }

bool comes_before(const Policy& a, const Policy& b) noexcept {
  return a.hard != b.hard ? a.hard : a.priority > b.priority;
}

bool finite(const Pull& pull) noexcept {
  return pull.F.f.allFinite() && pull.F.t.allFinite() && pull.B.allFinite() && pull.F_of_B.f.allFinite();
}

void scale(Pull& pull, double by) noexcept {
  pull.F = {by * pull.F.f, by * pull.F.t};
  pull.F_of_B.f *= by;
  pull.B *= by;
  pull.U *= by;
}

/// A ramp by distance or force goes with the hand: what it lent could be had again and again.
bool lends(const Policy& policy) noexcept {
  return !policy.hard && std::none_of(policy.ramps.begin(), policy.ramps.end(), [](const Ramp& ramp) {
    return ramp.by == Ramp::By::distance || ramp.by == Ramp::By::force;
  });
}

/// Takes `now` towards `goal`, by `step` at most.
void approach(const Vec3& goal, double step, Vec3& now) noexcept {
  const Vec3 change = goal - now;
  const double far = change.norm();
  now = far > step ? Vec3(now + step / far * change) : goal;
}

}  // namespace

// The wrench: of the soft ones at the mapped goal, of the joint and the hard ones along their share of the correction.
void Guidance::pull(const Input& in) noexcept {
  out_.lent = 0.0;
  for (int i = 0; i < size(); ++i) {
    Part& now = part(i);
    now.pull = Pull{};
    if (!counts(i)) continue;
    const Fixture& f = fixture(i);
    const bool hard = f.policy.hard, together = hard || f.law->jointly();
    if (together && std::isfinite(now.want.gap)) {
      const Proxy& proxy = hard ? hard_ : soft_;
      const double share = proxy.share[static_cast<std::size_t>(i)];
      const Wrench& along = proxy.along[static_cast<std::size_t>(i)];
      if (along.f != Vec3::Zero() || along.t != Vec3::Zero()) now.want.along = along;
      // The goal goes a share `authority` of the way there; the law is asked about the whole way, and weighed once.
      now.want.gap = share > 0.0 ? -share / now.authority : std::max(now.want.gap, 0.0);
    }
    now.pull = f.law->pull(now.want, in.V_WT);
    const double speed = in.V_WT.v.norm();
    if (speed > now.want.speed) {
      now.pull.F.f -= f.law->damping() * (1.0 - now.want.speed / speed) * in.V_WT.v;
      if (hard) now.pull.F.f += std::min(f.law->stiffness() * lag_, kLagForce) * lag_along_;
    }
    if (!finite(now.pull)) now.pull = Pull{};
    if (lends(f.policy)) out_.lent += now.rose * now.pull.U;
    scale(now.pull, now.authority);
  }
  yield(in.takes_damping);
  Wrench sum;
  Mat3 B_W = Mat3::Zero();
  for (int i = 0; i < size(); ++i) {
    const Pull& one = part(i).pull;
    sum = sum + one.F;
    if (in.takes_damping) {
      sum.f -= one.F_of_B.f;
      B_W += one.B;
    }
  }
  blend(sum, B_W, in);
}

// A fixture never pushes against one that comes before it, hard before soft, then by priority: its wrench is the
// nearest to its own that pushes against none of them (what is not yet wrong by the come-in counts by its share).
// Damping that the master takes pushes nowhere.
void Guidance::yield(bool takes_damping) noexcept {
  std::array<bool, kMaxFixtures> pulls{};
  for (int i = 0; i < size(); ++i) pulls[to_index(i)] = counts(i) && !none(part(i).pull.F);
  for (int i = 0; i < size(); ++i) {
    if (!pulls[to_index(i)]) continue;
    Wrench& F = part(i).pull.F;
    const Vec3 F_B = takes_damping ? part(i).pull.F_of_B.f : Vec3(Vec3::Zero());
    Vec6 y;
    y << F.f - F_B, F.t / kLength;
    bool against = false;
    yield_.clear();
    for (int j = 0; j < size(); ++j) {
      const Want& first = part(j).want;
      if (!pulls[to_index(j)] || !comes_before(fixture(j).policy, fixture(i).policy)) continue;
      const Vec6 a = row(first).stableNormalized();
      const double share = std::min(first.wrong() / (first.turns ? kComesInTurn : kComesIn), 1.0);
      const double pushes = std::min(a.dot(y), 0.0);
      against |= share * pushes < 0.0;
      yield_.add(a, (1.0 - share) * pushes);
    }
    if (!against) continue;
    const bool found = yield_.solve(y) != Qp::Status::stopped;
    F = found ? Wrench{F_B + yield_.y().head<3>(), kLength * yield_.y().tail<3>()} : Wrench{F_B, Vec3::Zero()};
  }
}

// The wrench changes as fast as the motions of hand and fixtures explain, and by force_rate beside them: a fixture that
// is switched, edited or moved by hand fades from what was there. So does a damping that the master takes: by what the
// hand, moving as it does, would feel of the change.
void Guidance::blend(const Wrench& F, const Mat3& B_W, const Input& in) noexcept {
  if (!in.engaged) {
    out_.F_T_W = {};
    out_.B_W.setZero();
    return;
  }
  const Vec3 turned = in.V_WT.w * dt_;
  const double moved = (in.X_WT_goal.p - X_before_.p).norm(), turn = turned.norm();
  const double dv = (in.V_WT.v - V_before_.v).norm(), dw = (in.V_WT.w - V_before_.w).norm();
  double f = options_.force_rate * dt_, t = options_.moment_rate * dt_;
  for (int i = 0; i < size(); ++i) {
    const Part& now = part(i);
    if (!counts(i)) continue;
    const Law& law = *fixture(i).law;
    const double drift = std::abs(now.want.drift) * dt_;
    const double shift = now.want.along.f.norm(), lever = now.want.along.t.norm();
    const double K = now.want.turns ? law.turning_stiffness() : law.stiffness();
    const double rise = K * (shift * moved + lever * turn + drift);
    double damps = now.want.turns ? law.turning_damping() * dw : law.damping() * (shift * dv + lever * dw);
    if (in.takes_damping && lever == 0.0 && now.pull.B != Mat3::Zero()) damps = 0.0;  // the master has it
    f += shift * (now.want.turns ? rise : rise + damps);
    if (std::isfinite(now.want.speed)) f += law.damping() * dv;  // a limit of speed has no slope to move along
    t += lever * (rise + damps);
  }
  const Mat3 change = B_W - out_.B_W;
  const double felt = (change * in.V_WT.v).norm(), most = options_.force_rate * dt_;
  out_.B_W += felt > most ? Mat3(most / felt * change) : change;
  approach(F.f, f, out_.F_T_W.f);
  approach(F.t, t, out_.F_T_W.t);
}

}  // namespace palpate::guidance
