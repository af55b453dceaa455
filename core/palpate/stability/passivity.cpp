#include "palpate/stability/passivity.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "palpate/types/require.hpp"

namespace palpate::stability {
namespace {

constexpr int kHalvings = 24;  // bisections, which determine the share to 1e-7

PassivityOptions checked(const PassivityOptions& options) {
  require("stability", options.capacity >= options.observer.allowance, "tank_capacity", options.capacity,
          "must not be below stability.allowance [J]");
  require("stability", options.speed > 0.0 && std::isfinite(options.speed), "speed", options.speed,
          "must be above 0 m/s, and finite; for example 0.3");
  require("stability", options.angular_speed > 0.0 && std::isfinite(options.angular_speed), "angular_speed",
          options.angular_speed, "must be above 0 rad/s, and finite; for example 3");
  return options;
}

Wrench scaled(double s, const Wrench& F) noexcept { return {s * F.f, s * F.t}; }

}  // namespace

double reserve(const PassivityOptions& options, const Caps& caps, double lag, double dt) noexcept {
  const ObserverOptions& o = options.observer;
  const auto largest = [&](double F, double speed, double a, double rate) noexcept {
    const double until = o.delay + lag + dt, u = speed + 0.5 * a * dt;
    return held_cost(F, u, a, 0.0, until) + ramp_cost(F, u, a, until, rate);
  };
  return o.allowance + largest(caps.force_cap, options.speed, o.acceleration, caps.rate_cap) +
         largest(caps.moment_cap, options.angular_speed, o.angular_acceleration, caps.moment_rate_cap);
}

PassivityController::PassivityController(const PassivityOptions& options, const Caps& caps, double lag, double dt)
    : mode_(checked(options).mode),
      ramp_down_{caps.rate_cap, caps.moment_rate_cap},
      observer_(options.observer, dt),
      dissipation_(options.friction, dt),
      capacity_(options.capacity),
      reserve_(stability::reserve(options, caps, lag, dt)) {}

void PassivityController::observe(const Pose& X_LH, const Twist& V_LH, const JointVector& q,
                                  double potential) noexcept {
  observer_.step(X_LH, V_LH, dissipation_.step(q));
  if (mode_ == Passivity::observer) observer_.limit(potential + reserve_);
  if (mode_ == Passivity::tank) observer_.limit(capacity_);
}

Wrench PassivityController::step(const Wrench& F_H_L, const Limiter& limiter) noexcept {
  if (mode_ == Passivity::off) return F_H_L;
  const double in_flight = observer_.in_flight();
  const auto needs = [&](double share) noexcept {
    return in_flight + observer_.cost(limiter.next(scaled(share, F_H_L)), ramp_down_);
  };
  reserved_ = needs(1.0);
  if (reserved_ <= observer_.stored()) return F_H_L;
  double share = 0.0, too_much = 1.0;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (share + too_much);
    (needs(middle) <= observer_.stored() ? share : too_much) = middle;
  }
  reserved_ = needs(share);
  return scaled(share, F_H_L);
}

}  // namespace palpate::stability
