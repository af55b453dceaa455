// A delay line: the values that are on their way, those that acted since the last tick, and those that will act.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace palpate::stability {

/// A value sent at the time s acts from s + delay on, until the next value does. Times are measured, so that uneven
/// periods and lost ticks count as they are.
template <typename T>
class DelayLine {
 public:
  /// delay [s], dt: nominal period [s]. Throws std::invalid_argument unless delay lies in 0..1 s. Only the constructor
  /// allocates.
  DelayLine(double delay, double dt) : delay_(delay) {
    if (!(delay >= 0.0 && delay <= 1.0)) {
      throw std::invalid_argument("stability.delay = " + std::to_string(delay) + ": must lie in 0..1 s");
    }
    ring_.resize(static_cast<std::size_t>(std::ceil(kFastest * delay / dt)) + 3);
  }
  /// Sends a value at the time t [s].
  void push(double t, const T& value) noexcept {
    head_ = head_ == 0 ? ring_.size() - 1 : head_ - 1;
    ring_[head_] = {t, value};
    size_ = std::min(size_ + 1, ring_.size());
  }
  /// Calls f(value, fraction) for every value that acted in the interval from..to [s], with the fraction of the
  /// interval in which it did.
  template <typename F>
  void acted(double from, double to, F&& f) const noexcept {
    double end = to;
    for (std::size_t i = 0; i < size_ && end > from; ++i) {
      const double begin = std::max(sent(i).t + delay_, from);
      if (begin >= end) continue;
      f(sent(i).value, (end - begin) / (to - from));
      end = begin;
    }
  }
  /// Calls f(value, begin, end) for every value that acts or will act from the time `now` on until `now` + delay, with
  /// the times from `now` on [s].
  template <typename F>
  void pending(double now, F&& f) const noexcept {
    double end = delay_;
    for (std::size_t i = 0; i < size_ && end > kInstant; ++i) {
      const double begin = std::max(sent(i).t + delay_ - now, 0.0);
      if (begin < end - kInstant) f(sent(i).value, begin, end);
      end = std::min(begin, end);
    }
  }
  [[nodiscard]] double delay() const noexcept { return delay_; }

 private:
  static constexpr double kFastest = 2.5;   // ticks per nominal period that the line holds
  static constexpr double kInstant = 1e-9;  // [s] shorter intervals are rounding errors

  struct Sent {
    double t = 0.0;
    T value{};
  };
  /// The value sent i ticks before the newest one.
  [[nodiscard]] const Sent& sent(std::size_t i) const noexcept { return ring_[(head_ + i) % ring_.size()]; }

  double delay_;
  std::vector<Sent> ring_;
  std::size_t head_ = 0, size_ = 0;
};

}  // namespace palpate::stability
