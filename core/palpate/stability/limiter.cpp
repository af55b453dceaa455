#include "palpate/stability/limiter.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "palpate/types/require.hpp"

namespace palpate::stability {
namespace {

// Factor below 1, so that rounding cannot lengthen a shortened vector beyond the cap.
constexpr double kInside = 1.0 - 1e-12;

/// Shortens v to `length` in the same direction. Returns true if it was longer. Safe for any finite v.
bool shorten(Vec3& v, double length) {
  const double norm = v.stableNorm();
  if (norm <= length) {
    return false;
  }
  // The norm of components near 1e308 overflows, so v is first divided by the largest one.
  v /= v.cwiseAbs().maxCoeff();
  v *= kInside * length / v.norm();
  return true;
}

/// Moves `now` towards `goal` by at most `step`, within `cap`; a fall by `explained` is free. Returns the bits of the
/// limits that acted.
unsigned approach(Vec3 goal, double cap, double step, double explained, Vec3& now) {
  unsigned status = 0;
  if (shorten(goal, cap)) {
    status |= kForceCapped;
  }
  if (explained > 0.0) shorten(now, std::max(goal.norm(), now.norm() - explained));
  Vec3 change = goal - now;
  if (shorten(change, step)) {
    status |= kRateCapped;
    now += change;
  } else {
    now = goal;  // exact, so that zero is reached
  }
  return status;
}

}  // namespace

Limiter::Limiter(const Caps& caps, double dt) : caps_(caps), dt_(dt) {
  require("stability", caps.force_cap >= 0.0 && std::isfinite(caps.force_cap), "force_cap", caps.force_cap,
          "must be 0 N or more, and finite");
  require("stability", caps.rate_cap > 0.0 && std::isfinite(caps.rate_cap), "rate_cap", caps.rate_cap,
          "must be above 0 N/s, and finite");
  require("stability", caps.moment_cap >= 0.0 && std::isfinite(caps.moment_cap), "moment_cap", caps.moment_cap,
          "must be 0 N m or more, and finite");
  require("stability", caps.moment_rate_cap > 0.0 && std::isfinite(caps.moment_rate_cap), "moment_rate_cap",
          caps.moment_rate_cap, "must be above 0 N m/s, and finite");
  require("stability", caps.stale_after > 0.0, "stale_after", caps.stale_after, "must be above 0 s, for example 0.03");
}

bool Limiter::stale(double now, double stamp) const noexcept {
  return !(std::abs(now - stamp) <= caps_.stale_after);  // true for NaN
}

Limited Limiter::step(const LimiterInput& in) noexcept {
  Limited out;
  if (!in.leader.valid || stale(in.t, in.leader.t)) {
    out.status |= kLeaderStale;
  }
  if (!in.follower.valid || stale(in.t, in.follower.t)) {
    out.status |= kFollowerStale;
  }
  Wrench commanded = in.F_H_L;
  if (!commanded.f.allFinite() || !commanded.t.allFinite()) {
    out.status |= kNotFinite;
    commanded = {};
  }
  const bool trusted = in.engaged && out.status == 0;
  Wrench goal;
  if (trusted) {
    const double share =
        saturation_.step({commanded.f.stableNorm(), in.potential, in.work, in.work_of_motion}, caps_.force_cap);
    goal = commanded;
    if (share < 1.0) {
      goal = {kInside * share * commanded.f, kInside * share * commanded.t};
      out.status |= kForceCapped;
    }
  } else {
    saturation_.reset();
  }
  const double dt = in.dt > 0.0 ? std::min(in.dt, dt_) : dt_;  // after a gap no larger step than usual
  const double explained = trusted ? in.explained : 0.0;       // a released hand moves along no spring
  const unsigned force = approach(goal.f, caps_.force_cap, caps_.rate_cap * dt, explained, F_.f);
  const unsigned moment = approach(goal.t, caps_.moment_cap, caps_.moment_rate_cap * dt, 0.0, F_.t);
  out.status |= force | moment;
  out.F_H_L = F_;
  out.F_cut = {commanded.f - F_.f, commanded.t - F_.t};
  return out;
}

}  // namespace palpate::stability
