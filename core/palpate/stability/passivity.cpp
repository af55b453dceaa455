#include "palpate/stability/passivity.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/require.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::stability {
namespace {

constexpr int kMostDelays = 8;   // largest number of steps in which an uncertain delay is divided
constexpr double kForget = 0.5;  // [s] time in which the longest measured period is forgotten
constexpr double kLongest = 10;  // [periods] longest next period for which a wrench is paid

PassivityOptions checked(const PassivityOptions& options) {
  require("stability", options.capacity >= options.observer.allowance, "tank_capacity", options.capacity,
          "must not be below stability.allowance [J]");
  require("stability", options.speed > 0.0 && std::isfinite(options.speed), "speed", options.speed,
          "must be above 0 m/s, and finite; for example 0.3");
  require("stability", options.angular_speed > 0.0 && std::isfinite(options.angular_speed), "angular_speed",
          options.angular_speed, "must be above 0 rad/s, and finite; for example 3");
  require("stability", options.delay_doubt >= 0.0 && options.observer.delay + options.delay_doubt <= 1.0, "delay_doubt",
          options.delay_doubt, "must be 0 s (the delay is known) or more, and at most 1 s with the delay");
  require("stability", options.moving_share >= 0.0 && options.moving_share <= 1.0, "moving_share", options.moving_share,
          "must lie in 0..1");
  return options;
}

std::vector<Observer> make_observers(const PassivityOptions& options, double dt) {
  const int steps = std::min(static_cast<int>(std::ceil(options.delay_doubt / dt - 1e-9)), kMostDelays);
  std::vector<Observer> observers;
  for (int i = 0; i <= steps; ++i) {
    ObserverOptions one = options.observer;
    one.delay += steps > 0 ? options.delay_doubt * i / steps : 0.0;
    observers.emplace_back(one, dt);
  }
  return observers;
}

}  // namespace

double reserve(const PassivityOptions& options, const Caps& caps, double lag, double dt) noexcept {
  const ObserverOptions& o = options.observer;
  const auto largest = [&](double F, double speed, double a) noexcept {
    const double until = o.delay + options.delay_doubt + lag + dt, u = speed + 0.5 * a * dt;
    return held_cost(F, u, a, 0.0, until) + fade_cost(F, u, a, until, kFade);
  };
  return o.allowance + largest(caps.force_cap, options.speed, o.acceleration) +
         largest(caps.moment_cap, options.angular_speed, o.angular_acceleration);
}

PassivityController::PassivityController(const PassivityOptions& options, const Caps& caps, double lag, double dt)
    : mode_(checked(options).mode),
      observers_(make_observers(options, dt)),
      dissipation_(options.friction, dt),
      dt_(dt),
      hold_(dt),
      capacity_(options.capacity),
      moving_share_(options.moving_share),
      reserve_(stability::reserve(options, caps, lag, dt)) {}

void PassivityController::observe(const Pose& X_LH, const Twist& V_LH, const JointVector& q, double potential,
                                  double dt) noexcept {
  // The next period is assumed to be no longer than the longest recent one.
  hold_ = std::max({dt_, std::min(dt, kLongest * dt_), hold_ - (hold_ - dt_) * std::min(dt / kForget, 1.0)});
  const double dissipated = dissipation_.at_handle() ? dissipation_.step(X_LH.p, dt) : dissipation_.step(q, dt);
  for (Observer& one : observers_) one.step(X_LH, V_LH, dissipated, dt);
  if (mode_ == Passivity::observer) limit_to(potential, X_LH, dt);
  if (mode_ == Passivity::tank) limit(capacity_);
}

Wrench PassivityController::step(const Wrench& F) noexcept {
  F_ = F;
  if (mode_ == Passivity::off) return F;
  double share = 1.0;
  reserved_ = 0.0;
  for (const Observer& one : observers_) {
    const double cost = one.cost(F, hold_), in_flight = one.in_flight(), room = one.stored() - in_flight;
    if (cost > room && cost > 0.0) share = std::min(share, std::max(room / cost, 0.0));
    reserved_ = std::max(reserved_, in_flight + share * cost);
  }
  return share < 1.0 ? Wrench{share * F.f, share * F.t} : F;
}

void PassivityController::credit(double energy) noexcept {
  if (mode_ == Passivity::off || !(energy > 0.0)) return;
  const double now = std::min(energy, capacity_ - credited_);
  credited_ += now;
  for (Observer& one : observers_) one.add(now);
}

void PassivityController::share(double work) noexcept {
  if (!std::isfinite(work)) return;
  for (Observer& one : observers_) one.add(moving_share_ * work);
}

// Takes the energy beyond `most` out of the account. It repays the credit; the rest is returned [J].
double PassivityController::limit(double most) noexcept {
  if (std::isnan(most)) return 0.0;  // the potential is unknown
  const double excess = std::max(stored() - most, 0.0), repaid = std::min(excess, credited_);
  credited_ -= repaid;
  for (Observer& one : observers_) one.add(-std::max(one.stored() - most, 0.0));
  return excess - repaid;
}

// Limits the account to the potential and the reserve. The energy of an object that disappears is set aside.
void PassivityController::limit_to(double potential, const Pose& X_LH, double dt) noexcept {
  const double change = potential - potential_;
  const double work =
      F_.f.norm() * (X_LH.p - X_LH_.p).norm() + F_.t.norm() * rotation_vector(X_LH.R * X_LH_.R.transpose()).norm();
  const double jump = std::isfinite(change) ? std::max(std::abs(change) - work, 0.0) : 0.0;
  aside_age_ += dt;
  if (aside_age_ > kAside) aside_ = 0.0;
  if (change > 0.0 && jump > 0.5 * potential) {  // an object appears
    const double back = std::min(aside_, jump);
    aside_ -= back;
    for (Observer& one : observers_) one.add(back);
  }
  const double taken = limit(potential + reserve_);
  if (change < 0.0 && jump > 0.5 * potential_) {  // an object disappears
    aside_ += std::min(taken, jump);
    aside_age_ = 0.0;
  }
  potential_ = potential;
  X_LH_ = X_LH;
}

void PassivityController::rendered(const Wrench& F_H_L) noexcept {
  for (Observer& one : observers_) one.sent(F_H_L);
}

double PassivityController::stored() const noexcept {
  double least = observers_.front().stored();
  for (const Observer& one : observers_) least = std::min(least, one.stored());
  return least;
}

}  // namespace palpate::stability
