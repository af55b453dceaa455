// Statistics of the periods and the compute times of a periodic thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "palpate/types/mailbox.hpp"

namespace palpate::ros {

/// Mean, standard deviation, smallest and largest value of samples.
struct Spread {
  void add(double x) noexcept {
    const double before = x - mean;
    mean += before / static_cast<double>(++n);
    squares += before * (x - mean);
    least = n == 1 ? x : std::min(least, x);
    most = n == 1 ? x : std::max(most, x);
  }
  [[nodiscard]] double deviation() const noexcept {
    return n > 1 ? std::sqrt(squares / static_cast<double>(n - 1)) : 0;
  }

  std::int64_t n = 0;
  double mean = 0.0, squares = 0.0, least = 0.0, most = 0.0;
};

/// Statistics of one window of time.
struct Interval {
  Spread period, compute;     ///< [s]
  std::int64_t overruns = 0;  ///< rounds that took longer than the mean period
};

/// Collects windows of a second. One thread adds its rounds, another one reads the last complete window.
class IntervalMeter {
 public:
  static constexpr double kWindow = 1.0;  // [s]

  /// Adds a round from `begin` to `end` on the monotonic clock [ns]. Does not allocate.
  void add(std::int64_t begin, std::int64_t end) noexcept {
    const double took = 1e-9 * static_cast<double>(end - begin);
    if (last_ > 0) {
      now_.period.add(1e-9 * static_cast<double>(begin - last_));
      if (took > now_.period.mean) ++now_.overruns;
    }
    now_.compute.add(took);
    last_ = begin;
    if (opened_ == 0) opened_ = begin;
    if (1e-9 * static_cast<double>(begin - opened_) < kWindow) return;
    complete_.write(now_);
    now_ = {};
    opened_ = begin;
  }
  /// The last complete window. Only one thread may call it.
  [[nodiscard]] const Interval& read() noexcept { return complete_.read(); }

 private:
  Mailbox<Interval> complete_;
  Interval now_;
  std::int64_t last_ = 0, opened_ = 0;
};

}  // namespace palpate::ros
