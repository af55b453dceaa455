#include "palpate/stability/stability.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "palpate/loop/tick.hpp"

namespace palpate::stability {
namespace {

// Rounding must not carry a shortened vector over the cap.
constexpr double kInside = 1.0 - 1e-12;

/// v shortened to `length`, direction kept. Says whether it was. Safe for any finite v.
bool shorten(Vec3& v, double length) {
  const double norm = v.stableNorm();
  if (norm <= length) {
    return false;
  }
  // Components of 1e308 have a norm of infinity: divide by the largest first.
  v /= v.cwiseAbs().maxCoeff();
  v *= kInside * length / v.norm();
  return true;
}

/// Takes `now` towards `goal`, below `cap` and by `step` at most. Says which of the two was in the way.
unsigned approach(Vec3 goal, double cap, double step, Vec3& now) {
  unsigned status = 0;
  if (shorten(goal, cap)) {
    status |= loop::kForceCapped;
  }
  Vec3 change = goal - now;
  if (shorten(change, step)) {
    status |= loop::kRateCapped;
    now += change;
  } else {
    now = goal;  // exactly, so that zero is zero
  }
  return status;
}

void require(bool good, const char* name, double value, const char* mend) {
  if (!good) {
    throw std::invalid_argument("stability." + std::string(name) + " = " + std::to_string(value) + ": " + mend);
  }
}

}  // namespace

Limiter::Limiter(const Options& options, double dt) : options_(options), dt_(dt) {
  require(options.force_cap >= 0.0 && std::isfinite(options.force_cap), "force_cap", options.force_cap,
          "must be 0 N or more, and finite");
  require(options.rate_cap > 0.0 && std::isfinite(options.rate_cap), "rate_cap", options.rate_cap,
          "must be above 0 N/s, and finite");
  require(options.moment_cap >= 0.0 && std::isfinite(options.moment_cap), "moment_cap", options.moment_cap,
          "must be 0 N m or more, and finite");
  require(options.moment_rate_cap > 0.0 && std::isfinite(options.moment_rate_cap), "moment_rate_cap",
          options.moment_rate_cap, "must be above 0 N m/s, and finite");
  require(options.stale_after > 0.0, "stale_after", options.stale_after, "must be above 0 s, for example 0.03");
}

bool Limiter::stale(double now, double stamp) const noexcept {
  return !(std::abs(now - stamp) <= options_.stale_after);  // so written, NaN is stale
}

Output Limiter::step(const Input& in) noexcept {
  Output out;
  if (!in.leader_valid || stale(in.t, in.t_leader)) {
    out.status |= loop::kLeaderStale;
  }
  if (!in.follower_valid || stale(in.t, in.t_follower)) {
    out.status |= loop::kFollowerStale;
  }
  Wrench wanted = in.F_H_L;
  if (!wanted.f.allFinite() || !wanted.t.allFinite()) {
    out.status |= loop::kNotFinite;
    wanted = {};
  }
  const bool trusted = in.engaged && out.status == 0;
  const unsigned force = approach(trusted ? wanted.f : Vec3::Zero(), options_.force_cap, options_.rate_cap * dt_, F_.f);
  const unsigned moment =
      approach(trusted ? wanted.t : Vec3::Zero(), options_.moment_cap, options_.moment_rate_cap * dt_, F_.t);
  out.status |= force | moment;
  out.F_H_L = F_;
  out.F_cut = {wanted.f - F_.f, wanted.t - F_.t};
  return out;
}

}  // namespace palpate::stability
