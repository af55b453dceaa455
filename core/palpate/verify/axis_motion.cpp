#include "palpate/verify/axis_motion.hpp"

#include <cmath>

namespace palpate::verify {
namespace {

constexpr int kEvents = 64;  // largest number of reversals within a step; beyond it the mass stays where it is

/// Root of f in (0, h] by bisection with secants. f(0) and f(h) must differ in sign.
template <typename F>
double root(const F& f, double h) noexcept {
  double a = 0.0, b = h, fa = f(a), fb = f(b);
  for (int i = 0; i < 60 && b - a > 1e-14 * h; ++i) {
    const double secant = b - fb * (b - a) / (fb - fa);
    const double inside = std::fmin(std::fmax(secant, a + 1e-3 * (b - a)), b - 1e-3 * (b - a));
    const double m = i % 3 == 2 || !std::isfinite(inside) ? 0.5 * (a + b) : inside;
    const double fm = f(m);
    if ((fm < 0.0) == (fa < 0.0)) {
      a = m, fa = fm;
    } else {
      b = m, fb = fm;
    }
  }
  return b;
}

}  // namespace

AxisMass::Transition AxisMass::transition(double h) const noexcept {
  Transition phi;
  phi.h = h;
  const double d = D_ / M_;
  if (k_ == 0.0) {  // the velocity decays; xv is its integral
    phi.vv = std::exp(-d * h);
    phi.xv = d > 0.0 ? -std::expm1(-d * h) / d : h;
    return phi;
  }
  const double square = 0.25 * d * d - k_ / M_;  // squared half distance of the two poles
  const double pole = std::sqrt(std::abs(square)), y = pole * h;
  const double c = square > 0.0 ? std::cosh(y) : std::cos(y);
  const double s = y < 1e-6 ? h : (square > 0.0 ? std::sinh(y) : std::sin(y)) / pole;
  const double decay = std::exp(-0.5 * d * h);
  phi.xx = decay * (c + 0.5 * d * s);
  phi.xv = decay * s;
  phi.vx = -decay * k_ / M_ * s;
  phi.vv = decay * (c - 0.5 * d * s);
  return phi;
}

const AxisMass::Transition& AxisMass::remembered(double h) noexcept {
  for (const Transition& phi : memory_) {
    if (phi.h == h) return phi;
  }
  oldest_ = (oldest_ + 1) % memory_.size();
  return memory_[oldest_] = transition(h);
}

AxisMass::State AxisMass::free(const Transition& phi, double c, double p, double w) const noexcept {
  if (k_ == 0.0) {
    // v tends to c / D; this form also holds for D = 0.
    const double d = D_ / M_, a = c / M_;
    const double lag = d * phi.h > 1e-5 ? (phi.h - phi.xv) / d : 0.5 * phi.h * phi.h * (1.0 - d * phi.h / 3.0);
    return {x + v * phi.xv + a * lag, v * phi.vv + a * phi.xv};
  }
  const double x0 = p + (c - D_ * w) / k_, dx = x - x0, dv = v - w;
  return {x0 + w * phi.h + phi.xx * dx + phi.xv * dv, w + phi.vx * dx + phi.vv * dv};
}

void AxisMass::step(double h, double c, double p, double w) noexcept {
  if (Fc_ == 0.0) {
    const State next = free(remembered(h), c, p, w);
    x = next.x, v = next.v;
    return;
  }
  for (int i = 0; i < kEvents && h > 0.0; ++i) {
    if (way_ == 0 && v != 0.0) way_ = v > 0.0 ? 1 : -1;
    const double done = way_ == 0 ? stick(h, c, p, w) : slip(h, c, p, w);
    p += w * done;
    h -= done;
  }
}

// Stays at rest until the other forces exceed Fc. Returns the elapsed time [s].
double AxisMass::stick(double h, double c, double p, double w) noexcept {
  v = 0.0;
  const double pull = c + k_ * (p - x), growth = k_ * w;
  if (std::abs(pull) > Fc_) {
    way_ = pull > 0.0 ? 1 : -1;
    return 0.0;
  }
  const double until = growth == 0.0 ? h : (std::copysign(Fc_, growth) - pull) / growth;
  if (until >= h) return h;
  way_ = growth > 0.0 ? 1 : -1;
  return until;
}

// Slides in one direction until the velocity is zero. Returns the elapsed time [s].
double AxisMass::slip(double h, double c, double p, double w) noexcept {
  const double s = way_;
  c -= s * Fc_;
  const auto speed = [&](double t) { return s * free(transition(t), c, p, w).v; };
  const auto gain = [&](double t) {
    const State at = free(transition(t), c, p, w);
    return s * (c - D_ * at.v - k_ * (at.x - p - w * t));
  };
  const State end = free(remembered(h), c, p, w);
  double until = h;
  if (s * end.v < 0.0) {
    until = root(speed, h);
  } else if (gain(0.0) < 0.0 && gain(h) > 0.0) {  // slower, then faster again: it may stop in between
    const double slowest = root(gain, h);
    if (speed(slowest) < 0.0) until = root(speed, slowest);
  }
  const State at = until == h ? end : free(transition(until), c, p, w);
  x = at.x, v = at.v;
  if (until < h || s * v <= 0.0) {
    v = 0.0;
    way_ = 0;
  }
  return until;
}

}  // namespace palpate::verify
