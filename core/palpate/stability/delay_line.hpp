// What was sent over the last periods, and which of it acts now.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace palpate::stability {

/// A value sent at tick k acts from t_k + delay on, until the next one does. A delay of (steps + share) periods: during
/// the period that ends now, acting(1) = before(steps + 1) acted for its first `share`, acting(0) = before(steps)
/// after.
template <typename T>
class DelayLine {
 public:
  /// delay, dt [s]. Throws std::invalid_argument. Allocates, and never again.
  DelayLine(double delay, double dt) {
    if (!(delay >= 0.0 && delay <= 1.0)) {
      throw std::invalid_argument("stability.delay = " + std::to_string(delay) + ": must lie in 0..1 s");
    }
    steps_ = static_cast<std::size_t>(std::floor(delay / dt + 1e-9));
    share_ = std::max(delay / dt - static_cast<double>(steps_), 0.0);
    ring_.resize(steps_ + 2);
  }
  void push(const T& value) noexcept {
    head_ = head_ == 0 ? ring_.size() - 1 : head_ - 1;
    ring_[head_] = value;
  }
  /// The i-th before the newest; 0 is the newest.
  [[nodiscard]] const T& before(std::size_t i) const noexcept { return ring_[(head_ + i) % ring_.size()]; }
  [[nodiscard]] const T& acting(int i) const noexcept { return before(steps_ + static_cast<std::size_t>(i)); }
  [[nodiscard]] std::size_t steps() const noexcept { return steps_; }
  [[nodiscard]] double share() const noexcept { return share_; }

 private:
  std::vector<T> ring_;
  std::size_t head_ = 0, steps_ = 0;
  double share_ = 0.0;
};

}  // namespace palpate::stability
