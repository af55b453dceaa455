#include "palpate/loop/pace.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace palpate::loop {

Pace::Pace(double stop_time) : stop_time_(stop_time) {
  if (!(stop_time > 0.0 && std::isfinite(stop_time))) {
    throw std::invalid_argument("pace: stop_time = " + std::to_string(stop_time) + " must be above 0 s");
  }
}

double Pace::step(double wanted, double dt) noexcept {
  const double change = dt / stop_time_, before = value_;
  value_ = std::clamp(wanted, before - change, before + change);
  return 0.5 * (before + value_) * dt;
}

double Pace::limit(double left) const noexcept { return std::sqrt(2.0 * std::max(left, 0.0) / stop_time_); }

}  // namespace palpate::loop
