#include "palpate/guidance/guidance.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "palpate/guidance/frame.hpp"
#include "palpate/types/require.hpp"

namespace palpate::guidance {
namespace {

constexpr double kTellsMoments = 0.02;  // [m] that makes a moment comparable to a force

bool usable(const Want& want) noexcept {
  return !std::isnan(want.gap) && !std::isnan(want.speed) && want.along.f.allFinite() && want.along.t.allFinite() &&
         std::isfinite(want.drift) && want.free.allFinite();
}

}  // namespace

Guidance::Guidance(const Options& options, double dt) : options_(options), dt_(dt), follower_(options.servo, dt) {
  require("guidance", options.force_rate > 0.0 && std::isfinite(options.force_rate), "force_rate", options.force_rate,
          "must be above 0 N/s, and finite; for example 20");
  require("guidance", options.moment_rate > 0.0 && std::isfinite(options.moment_rate), "moment_rate",
          options.moment_rate, "must be above 0 N m/s, and finite; for example 0.35");
  require("guidance", options.return_speed > 0.0 && std::isfinite(options.return_speed), "return_speed",
          options.return_speed, "must be above 0 m/s, and finite; for example 0.05");
  require("guidance", options.reserve >= 0.0 && options.reserve < 0.01, "reserve", options.reserve,
          "must lie in 0..0.01 m");
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
  for (int i = 0; i < size(); ++i) {
    for (const auto& frame : fixture(i).frames) frame->see(in.t);
  }
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
  const Want want = guidance::ask(fixture(i), {X_WT, in.X_WT.p, in.F_T_W, in.stiffness}, in.t);
  return usable(want) ? want : Want{};
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
    const auto& frames = fixture(i).frames;
    now.fresh |= std::any_of(frames.begin(), frames.end(), [](const auto& frame) { return frame->leapt(); });
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
  const bool placed = std::all_of(f.frames.begin(), f.frames.end(),
                                  [&f](const auto& frame) { return frame->told() && frame->age() <= f.patience; });
  if (f.on && !placed) out_.status |= kFrameLost;
  const bool engaged = f.on && placed && (now.engaged ? near <= f.policy.release : near <= f.policy.engage);
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
  if (out_.strongest >= 0) out_.status |= kGuided;
  if (out_.X_WT_goal.p != in.X_WT_goal.p || out_.X_WT_goal.R != in.X_WT_goal.R) out_.status |= kGoalCorrected;
}

}  // namespace palpate::guidance
