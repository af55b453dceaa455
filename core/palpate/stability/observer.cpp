#include "palpate/stability/observer.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "palpate/types/require.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::stability {
namespace {

/// Largest speed of the handle along a force (or its angular speed along a moment). since: the largest change of speed
/// since the velocity was measured.
double along(const Vec3& F, const Vec3& v, double since) noexcept {
  const double size = F.norm();
  return size > 0.0 ? F.dot(v) / size + since : 0.0;
}

double square(double x) noexcept { return x * x; }

}  // namespace

double held_cost(double F, double u, double a, double from, double to) noexcept {
  return F * (square(std::max(u + a * to, 0.0)) - square(std::max(u + a * from, 0.0))) / (2.0 * a);
}

double ramp_cost(double F, double u, double a, double from, double rate) noexcept {
  const double u1 = u + a * from;
  if (u1 >= 0.0) return u1 * F * F / (2.0 * rate) + a * F * F * F / (6.0 * rate * rate);
  const double left = std::max(F + rate * u1 / a, 0.0);  // rest of the ramp when the hand reverses
  return a * left * left * left / (6.0 * rate * rate);
}

Observer::Observer(const ObserverOptions& options, double dt)
    : options_(options), dt_(dt), delay_(options.delay), line_(options.delay, dt), stored_(options.allowance) {
  require("stability", options.quantum >= 0.0 && options.quantum < 0.01, "quantum", options.quantum,
          "must lie in 0..0.01 m");
  require("stability", options.allowance >= 0.0 && std::isfinite(options.allowance), "allowance", options.allowance,
          "must be 0 J or more, and finite");
  require("stability", options.acceleration > 0.0 && std::isfinite(options.acceleration), "acceleration",
          options.acceleration, "must be above 0 m/s^2, and finite; for example 5");
  require("stability", options.angular_acceleration > 0.0 && std::isfinite(options.angular_acceleration),
          "angular_acceleration", options.angular_acceleration, "must be above 0 rad/s^2, and finite; for example 100");
}

void Observer::step(const Pose& X_LH, const Twist& V_LH, double dissipated) noexcept {
  V_LH_ = V_LH;
  if (!started_) {
    X_LH_ = X_LH;
    started_ = true;
    return;
  }
  const double play = std::max(0.5 * (options_.quantum - V_LH.v.norm() * dt_), 0.0);
  Vec3 dx = X_LH.p - X_LH_.p;
  const double far = dx.norm();
  dx *= far > play ? 1.0 - play / far : 0.0;
  const Vec3 turn = rotation_vector(X_LH.R * X_LH_.R.transpose());
  X_LH_ = {X_LH.R, X_LH_.p + dx};

  const double fraction = line_.fraction();
  const Wrench &now = line_.acting(0), &before = line_.acting(1);
  const double work_now = now.f.dot(dx) + now.t.dot(turn);
  const double work_before = before.f.dot(dx) + before.t.dot(turn);
  stored_ += dissipated - (1.0 - fraction) * work_now - fraction * work_before;
}

void Observer::limit(double most) noexcept { stored_ = std::min(stored_, most); }

void Observer::sent(const Wrench& F_H_L) noexcept {
  line_.push(F_H_L);
  zero_periods_ = F_H_L.f == Vec3::Zero() && F_H_L.t == Vec3::Zero() ? zero_periods_ + 1 : 0;
}

void Observer::clear_deficit() noexcept {
  if (zero_periods_ > line_.steps() + 1) stored_ = std::max(stored_, options_.allowance);
}

double Observer::credit(double energy, double most) noexcept {
  if (!(energy > 0.0)) return 0.0;
  const double credited = std::clamp(most - stored_, 0.0, energy);
  stored_ += credited;
  return credited;
}

double Observer::held(const Wrench& F, double from, double to) const noexcept {
  const double a = options_.acceleration, w = options_.angular_acceleration;
  return held_cost(F.f.norm(), along(F.f, V_LH_.v, 0.5 * a * dt_), a, from, to) +
         held_cost(F.t.norm(), along(F.t, V_LH_.w, 0.5 * w * dt_), w, from, to);
}

double Observer::in_flight() const noexcept {
  double sum = 0.0;
  const auto count = static_cast<std::size_t>(std::ceil(delay_ / dt_ - 1e-9));
  for (std::size_t i = 0; i < count; ++i) {
    const double to = delay_ - static_cast<double>(i) * dt_;
    sum += held(line_.before(i), std::max(to - dt_, 0.0), to);
  }
  return sum;
}

double Observer::cost(const Wrench& F, const RampDownRates& rates) const noexcept {
  const double a = options_.acceleration, w = options_.angular_acceleration, begin = delay_ + dt_;
  return held(F, delay_, begin) + ramp_cost(F.f.norm(), along(F.f, V_LH_.v, 0.5 * a * dt_), a, begin, rates.force) +
         ramp_cost(F.t.norm(), along(F.t, V_LH_.w, 0.5 * w * dt_), w, begin, rates.moment);
}

}  // namespace palpate::stability
