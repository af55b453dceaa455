#include "palpate/guidance/authority.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/status.hpp"

namespace palpate::guidance {
namespace {

/// True if every live frame of the fixture has a pose that has not timed out.
bool placed(const Fixture& f) noexcept {
  return std::all_of(f.frames.begin(), f.frames.end(),
                     [&f](const auto& frame) { return frame->has_pose() && frame->age() <= f.timeout; });
}

/// The measured value that a ramp follows.
double measured(const Ramp& ramp, const Fixture& f, const FixtureState& now, const Input& in) noexcept {
  switch (ramp.by) {
    case Ramp::By::distance:
      return std::min(std::abs(now.constraint.gap), 1e3);
    case Ramp::By::time:
      return in.t - now.engaged_at;
    case Ramp::By::force:
      return in.handle.F_hand >= 0.0 ? in.handle.F_hand : f.law->force(now.constraint, {}).F.f.norm();
    default:
      return in.pedal;
  }
}

/// Engages or releases the fixture. Returns the authority that its policy demands [0-1].
double target(const Fixture& f, FixtureState& now, bool has_place, const Input& in) noexcept {
  const double near = std::abs(now.constraint.gap);
  const bool engaged = f.on && has_place && (now.engaged ? near <= f.policy.release : near <= f.policy.engage);
  if (engaged && !now.engaged) now.engaged_at = in.t;
  now.engaged = engaged;
  double share = engaged ? f.policy.authority : 0.0;
  for (const Ramp& ramp : f.policy.ramps) {
    share *= factor(ramp, measured(ramp, f, now, in));
  }
  return std::isfinite(share) ? share : 0.0;
}

}  // namespace

unsigned Authority::step(FixtureStates& states, int i, const Input& in) const noexcept {
  const Fixture& f = states.fixture(i);
  FixtureState& now = states[i];
  now.rise = 0.0;
  now.falls = false;
  if (!f.on && !now.active()) return kOk;
  now.constraint = states.evaluate(i, in.goal.X_WT_goal, in);
  now.policy_gap = now.constraint.gap;
  const bool has_place = placed(f);
  const double wanted = target(f, now, has_place, in);
  const bool jumped = std::any_of(f.frames.begin(), f.frames.end(), [](const auto& frame) { return frame->jumped(); });
  const bool appears = now.authority == 0.0 && wanted > 0.0 && !follows_distance(f.policy);
  now.needs_slack |= jumped || appears;  // a hand that comes back is no edit, and its authority begins at zero
  now.edited |= jumped || appears;
  const double before = now.authority;
  now.authority = std::clamp(wanted, before - dt_ / f.policy.fall, before + dt_ / f.policy.rise);
  now.rise = std::max(now.authority - before, 0.0);
  now.falls = now.authority < before;
  return f.on && !has_place ? kFrameLost : kOk;
}

}  // namespace palpate::guidance
