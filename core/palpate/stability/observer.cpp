#include "palpate/stability/observer.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "palpate/types/require.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::stability {
namespace {

/// Largest speed of the handle along a force (or its angular speed along a moment), by two measured velocities. since:
/// the largest change of speed since the velocity was measured.
double along(const Vec3& F, const Vec3& v, const Vec3& mean, double since) noexcept {
  const double size = F.norm();
  return size > 0.0 ? std::max(F.dot(v), F.dot(mean)) / size + since : 0.0;
}

double square(double x) noexcept { return x * x; }

}  // namespace

double held_cost(double F, double u, double a, double from, double to) noexcept {
  return F * (square(std::max(u + a * to, 0.0)) - square(std::max(u + a * from, 0.0))) / (2.0 * a);
}

double fade_cost(double F, double u, double a, double from, double span) noexcept {
  const double u1 = u + a * from;
  if (u1 >= 0.0) return F * span * (0.5 * u1 + a * span / 6.0);
  const double left = std::max(span + u1 / a, 0.0);  // rest of the fade when the hand reverses
  return F * a * left * left * left / (6.0 * span);
}

Observer::Observer(const ObserverOptions& options, double dt)
    : options_(options), dt_(dt), line_(options.delay, dt), stored_(options.allowance) {
  require("stability", options.quantum >= 0.0 && options.quantum < 0.01, "quantum", options.quantum,
          "must lie in 0..0.01 m");
  require("stability", options.allowance >= 0.0 && std::isfinite(options.allowance), "allowance", options.allowance,
          "must be 0 J or more, and finite");
  require("stability", options.acceleration > 0.0 && std::isfinite(options.acceleration), "acceleration",
          options.acceleration, "must be above 0 m/s^2, and finite; for example 5");
  require("stability", options.angular_acceleration > 0.0 && std::isfinite(options.angular_acceleration),
          "angular_acceleration", options.angular_acceleration, "must be above 0 rad/s^2, and finite; for example 100");
}

void Observer::step(const Pose& X_LH, const Twist& V_LH, double dissipated, double dt) noexcept {
  V_LH_ = V_LH;
  if (!started_) {
    X_LH_ = X_LH;
    p_measured_ = X_LH.p;
    mean_ = V_LH;
    started_ = true;
    return;
  }
  const double play = std::max(0.5 * (options_.quantum - V_LH.v.norm() * dt), 0.0);
  Vec3 dx = X_LH.p - X_LH_.p;
  const double far = dx.norm();
  dx *= far > play ? 1.0 - play / far : 0.0;
  const Vec3 turn = rotation_vector(X_LH.R * X_LH_.R.transpose());
  X_LH_ = {X_LH.R, X_LH_.p + dx};
  mean_ = {dx / dt, turn / dt};
  const double last = now_;
  now_ += dt;
  stored_ += dissipated;
  Wrench acted;  // mean of the period
  line_.acted(last, now_, [&](const Wrench& F, double fraction) noexcept {
    acted.f += fraction * F.f;
    acted.t += fraction * F.t;
  });
  impulse_ += dt * acted.f;
  since_ += dt;
  const double moved = dx.norm();
  const Vec3 count = moved > options_.quantum ? Vec3(options_.quantum / moved * dx) : dx;
  stored_ -= impulse_.dot(count) / since_ + acted.f.dot(dx - count) + acted.t.dot(turn);
  if (X_LH.p != p_measured_) {
    p_measured_ = X_LH.p;
    impulse_.setZero();
    since_ = 0.0;
  }
}

void Observer::sent(const Wrench& F_H_L) noexcept { line_.push(now_, F_H_L); }

double Observer::held(const Wrench& F, double from, double to) const noexcept {
  const double a = options_.acceleration, w = options_.angular_acceleration;
  return held_cost(F.f.norm(), along(F.f, V_LH_.v, mean_.v, 0.5 * a * dt_), a, from, to) +
         held_cost(F.t.norm(), along(F.t, V_LH_.w, mean_.w, 0.5 * w * dt_), w, from, to);
}

double Observer::in_flight() const noexcept {
  double sum = 0.0;
  line_.pending(now_, [&](const Wrench& F, double begin, double end) noexcept { sum += held(F, begin, end); });
  return sum;
}

double Observer::cost(const Wrench& F, double hold) const noexcept {
  const double a = options_.acceleration, w = options_.angular_acceleration, begin = options_.delay + hold;
  return held(F, options_.delay, begin) +
         fade_cost(F.f.norm(), along(F.f, V_LH_.v, mean_.v, 0.5 * a * dt_), a, begin, kFade) +
         fade_cost(F.t.norm(), along(F.t, V_LH_.w, mean_.w, 0.5 * w * dt_), w, begin, kFade);
}

}  // namespace palpate::stability
