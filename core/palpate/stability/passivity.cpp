#include "palpate/stability/passivity.hpp"

#include <limits>

namespace palpate::stability {
namespace {

constexpr int kHalvings = 24;  // bisections, which determine the share to 1e-7

ObserverOptions remembering(const PassivityOptions& options) {
  ObserverOptions o = options.observer;
  if (options.mode != Passivity::tank) o.capacity = std::numeric_limits<double>::infinity();
  return o;
}

Wrench scaled(double s, const Wrench& F) noexcept { return {s * F.f, s * F.t}; }

}  // namespace

PassivityController::PassivityController(const PassivityOptions& options, const Caps& caps, double dt)
    : mode_(options.mode),
      ramp_down_{caps.rate_cap, caps.moment_rate_cap},
      observer_(remembering(options), dt),
      dissipation_(options.friction, dt),
      credit_limit_(options.observer.capacity) {}

void PassivityController::observe(const Pose& X_LH, const Twist& V_LH, const JointVector& q) noexcept {
  observer_.step(X_LH, V_LH, dissipation_.step(q));
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
