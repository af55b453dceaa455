#include "palpate/guidance/guidance.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "palpate/guidance/frame.hpp"
#include "palpate/guidance/law/profile.hpp"
#include "palpate/loop/tick.hpp"

namespace palpate::guidance {
namespace {

constexpr double kTellsMoments = 0.02;  // [m] that makes a moment comparable to a force
constexpr double kLagForce = 3.0;       // [N] most that a goal behind a limit of speed pulls with

void require(bool good, const char* key, double value, const char* mend) {
  if (!good) throw std::invalid_argument("guidance." + std::string(key) + " = " + std::to_string(value) + ": " + mend);
}

bool finite(const Want& want) noexcept {
  return !std::isnan(want.gap) && !std::isnan(want.speed) && want.along.f.allFinite() && want.along.t.allFinite() &&
         std::isfinite(want.drift) && want.free.allFinite();
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

Guidance::Guidance(const Options& options, double dt) : options_(options), dt_(dt), follower_(options.servo, dt) {
  require(options.force_rate > 0.0 && std::isfinite(options.force_rate), "force_rate", options.force_rate,
          "must be above 0 N/s, and finite; for example 20");
  require(options.moment_rate > 0.0 && std::isfinite(options.moment_rate), "moment_rate", options.moment_rate,
          "must be above 0 N m/s, and finite; for example 0.35");
  require(options.return_speed > 0.0 && std::isfinite(options.return_speed), "return_speed", options.return_speed,
          "must be above 0 m/s, and finite; for example 0.05");
  require(options.reserve >= 0.0 && options.reserve < 0.01, "reserve", options.reserve, "must lie in 0..0.01 m");
}

void Guidance::take(const Fixtures& fixtures) noexcept {
  const int before = size();
  std::swap(old_, part_);
  fixtures_ = &fixtures;
  for (int i = 0; i < size(); ++i) {
    const std::uint64_t key = std::hash<std::string>{}(fixture(i).name);
    const auto* old = std::find_if(old_.begin(), old_.begin() + before, [&](const Part& p) { return p.key == key; });
    part(i) = old != old_.begin() + before ? *old : Part{};
    part(i).key = key;
    part(i).fresh = true;
  }
}

const Output& Guidance::step(const Input& in) noexcept {
  if (!started_) {
    X_before_ = in.X_WT_goal;
    V_before_ = in.V_WT;
    started_ = true;
  }
  if (fixtures_ != nullptr && fixtures_->tool != nullptr) fixtures_->tool->set({in.X_WT, in.V_WT});
  follower_.observe(in.X_WT.p);
  out_.X_WT_goal = in.X_WT_goal;
  out_.status = 0;
  look(in);
  correct(in);
  pull(in);
  tell(in);
  X_before_ = in.X_WT_goal;
  V_before_ = in.V_WT;
  follower_.command(out_.X_WT_goal.p);
  return out_;
}

Want Guidance::ask(int i, const Pose& X_WT, const Input& in) const noexcept {
  const Want want = guidance::ask(fixture(i), {X_WT, in.F_T_W, in.stiffness}, in.t);
  return finite(want) ? want : Want{};
}

// What each fixture wants where the hand is, and how much it counts: its authority goes there at the policy's pace.
void Guidance::look(const Input& in) noexcept {
  for (int i = 0; i < size(); ++i) {
    Part& now = part(i);
    const Policy& policy = fixture(i).policy;
    now.rose = 0.0;
    if (!fixture(i).on && !counts(i)) continue;
    now.want = ask(i, in.X_WT_goal, in);
    const double wanted = wanted_authority(i, in);
    if (now.authority == 0.0 && wanted > 0.0) now.fresh = true;
    const double before = now.authority;
    now.authority = std::clamp(wanted, before - dt_ / policy.fall, before + dt_ / policy.rise);
    now.rose = std::max(now.authority - before, 0.0);
  }
}

double Guidance::wanted_authority(int i, const Input& in) noexcept {
  Part& now = part(i);
  const Fixture& f = fixture(i);
  const double near = std::abs(now.want.gap);
  const bool engaged = f.on && (now.engaged ? near <= f.policy.release : near <= f.policy.engage);
  if (engaged && !now.engaged) now.since = in.t;
  now.engaged = engaged;
  double share = engaged ? f.policy.authority : 0.0;
  for (const Ramp& ramp : f.policy.ramps) {
    double x = in.pedal;
    if (ramp.by == Ramp::By::distance) x = std::min(near, 1e3);
    if (ramp.by == Ramp::By::time) x = in.t - now.since;
    if (ramp.by == Ramp::By::force) x = in.F_hand >= 0.0 ? in.F_hand : f.law->pull(now.want, {}).F.f.norm();
    share *= std::clamp((x - ramp.from) / (ramp.to - ramp.from), 0.0, 1.0);
  }
  return std::isfinite(share) ? share : 0.0;
}

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
  yield();
  Wrench sum;
  out_.B_W.setZero();
  for (int i = 0; i < size(); ++i) {
    const Pull& one = part(i).pull;
    sum = sum + one.F;
    if (in.takes_damping) {
      sum.f -= one.F_of_B.f;
      out_.B_W += one.B;
    }
  }
  blend(sum, in);
}

// A fixture never pulls against one that comes before it: hard before soft, then by priority.
void Guidance::yield() noexcept {
  for (int j = 0; j < size(); ++j) {
    const Part& first = part(j);
    if (!counts(j) || (first.pull.F.f == Vec3::Zero() && first.pull.F.t == Vec3::Zero())) continue;
    const Policy& before = fixture(j).policy;
    const double in = first.want.turns ? kComesInTurn : kComesIn;
    const double share = std::min(first.want.wrong() / in, 1.0);
    for (int i = 0; i < size(); ++i) {
      const Policy& policy = fixture(i).policy;
      const bool comes_after = before.hard != policy.hard ? before.hard : before.priority > policy.priority;
      if (!comes_after || !counts(i)) continue;
      Wrench& F = part(i).pull.F;
      if (first.want.turns) {
        F.t -= share * std::min(F.t.dot(first.want.along.t), 0.0) * first.want.along.t;
      } else {
        F.f -= share * std::min(F.f.dot(first.want.along.f), 0.0) * first.want.along.f;
      }
    }
  }
}

// The wrench changes as fast as the motions of hand and fixtures explain, and by force_rate beside them: a fixture that
// is switched, edited or moved by hand fades from what was there.
void Guidance::blend(const Wrench& F, const Input& in) noexcept {
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
    const double damps = now.want.turns ? law.turning_damping() * dw : law.damping() * (shift * dv + lever * dw);
    f += shift * (now.want.turns ? rise : rise + damps);
    t += lever * (rise + damps);
  }
  approach(F.f, f, out_.F_T_W.f);
  approach(F.t, t, out_.F_T_W.t);
}

double Guidance::stiffness_along(const Vec3& F_T_W) const noexcept {
  const double force = F_T_W.norm();
  double sum = 0.0;
  for (int i = 0; force > 0.0 && i < size(); ++i) {
    const Part& now = part_[static_cast<std::size_t>(i)];
    if (now.authority == 0.0 || now.pull.F.f == Vec3::Zero()) continue;
    const Law& law = *fixture(i).law;
    const double share = now.want.along.f.dot(F_T_W) / force;
    sum += now.authority * share * share * (now.want.turns ? law.turning_stiffness() : law.stiffness());
  }
  return sum;
}

// Who pulls most, and how near the nearest is.
void Guidance::tell(const Input& in) noexcept {
  out_.strongest = -1;
  out_.gap = 0.0;
  double most = 0.0, nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < size(); ++i) {
    const Part& now = part(i);
    if (!counts(i)) continue;
    const double force = now.pull.F.f.norm() + now.pull.F.t.norm() / kTellsMoments;
    if (force > most) most = force, out_.strongest = i, out_.gap = now.want.gap;
    if (most == 0.0 && now.want.gap < nearest) nearest = now.want.gap, out_.gap = nearest;
  }
  if (!std::isfinite(out_.gap)) out_.gap = 0.0;
  out_.correction = out_.X_WT_goal.p - in.X_WT_goal.p;
  if (out_.strongest >= 0) out_.status |= loop::kGuided;
  if (out_.X_WT_goal.p != in.X_WT_goal.p || out_.X_WT_goal.R != in.X_WT_goal.R) out_.status |= loop::kGoalCorrected;
}

}  // namespace palpate::guidance
