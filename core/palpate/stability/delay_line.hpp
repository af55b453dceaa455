// A delay line: the values sent during the last periods, and those that act now.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace palpate::stability {

/// A value sent at tick k acts from t_k + delay until the next value does. The delay is (steps + fraction) periods. In
/// the period that ends now, acting(1) = before(steps + 1) acts during the first fraction `fraction` of the period, and
/// acting(0) = before(steps) during the rest.
template <typename T>
class DelayLine {
 public:
  /// delay [s], dt: period [s]. Throws std::invalid_argument unless delay lies in 0..1 s. Only the constructor
  /// allocates.
  DelayLine(double delay, double dt) {
    if (!(delay >= 0.0 && delay <= 1.0)) {
      throw std::invalid_argument("stability.delay = " + std::to_string(delay) + ": must lie in 0..1 s");
    }
    steps_ = static_cast<std::size_t>(std::floor(delay / dt + 1e-9));
    fraction_ = std::max(delay / dt - static_cast<double>(steps_), 0.0);
    ring_.resize(steps_ + 2);
  }
  /// Sends a value at this tick.
  void push(const T& value) noexcept {
    head_ = head_ == 0 ? ring_.size() - 1 : head_ - 1;
    ring_[head_] = value;
  }
  /// The value sent i ticks before the newest one.
  [[nodiscard]] const T& before(std::size_t i) const noexcept { return ring_[(head_ + i) % ring_.size()]; }
  /// The value that acts in the later (i = 0) or earlier (i = 1) part of the period that ends now.
  [[nodiscard]] const T& acting(int i) const noexcept { return before(steps_ + static_cast<std::size_t>(i)); }
  /// Whole periods of the delay, and the remaining fraction of a period.
  [[nodiscard]] std::size_t steps() const noexcept { return steps_; }
  [[nodiscard]] double fraction() const noexcept { return fraction_; }

 private:
  std::vector<T> ring_;
  std::size_t head_ = 0, steps_ = 0;
  double fraction_ = 0.0;
};

}  // namespace palpate::stability
