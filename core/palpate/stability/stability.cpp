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
  Vec3 wanted = in.F_H_L;
  if (!wanted.allFinite()) {
    out.status |= loop::kNotFinite;
    wanted.setZero();
  }

  Vec3 goal = in.engaged && out.status == 0 ? wanted : Vec3::Zero();
  if (shorten(goal, options_.force_cap)) {
    out.status |= loop::kForceCapped;
  }
  Vec3 change = goal - F_;
  if (shorten(change, options_.rate_cap * dt_)) {
    out.status |= loop::kRateCapped;
    F_ += change;
  } else {
    F_ = goal;  // exactly, so that zero is zero
  }
  out.F_H_L = F_;
  out.F_cut = wanted - F_;
  return out;
}

}  // namespace palpate::stability
