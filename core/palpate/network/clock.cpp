#include "palpate/network/clock.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::network {
namespace {

constexpr double kDoubt = 2e-4;      // [s] error of an interval with the smallest round trip
constexpr double kMostDrift = 1e-3;  // [-] clocks of computers drift less

}  // namespace

void ClockSync::add(double t1, double t2, double t3, double t4) noexcept {
  const double forward = t2 - t1, backward = t4 - t3;
  if (!std::isfinite(forward) || !std::isfinite(backward) || forward + backward < 0.0) return;
  Bin& newest = bins_[head_];
  if (size_ == 0 || t4 - newest.t >= kSpan) {
    head_ = (head_ + 1) % kBins;
    size_ = std::min(size_ + 1, kBins);
    bins_[head_] = {t4, forward, backward};
  } else {
    const bool better = forward < newest.forward || backward < newest.backward;
    newest.forward = std::min(newest.forward, forward);
    newest.backward = std::min(newest.backward, backward);
    if (!better) return;
  }
  fit();
}

// Weighted line through the offsets of the intervals.
void ClockSync::fit() noexcept {
  double best = INFINITY, oldest = INFINITY, latest = -INFINITY;
  for (std::size_t i = 0; i < size_; ++i) {
    const Bin& b = bins_[(head_ + kBins - i) % kBins];
    best = std::min(best, b.forward + b.backward);
    oldest = std::min(oldest, b.t);
    latest = std::max(latest, b.t);
  }
  double sw = 0.0, st = 0.0, sy = 0.0, stt = 0.0, sty = 0.0;
  const double middle = 0.5 * (oldest + latest), first = 0.5 * (bins_[head_].forward - bins_[head_].backward);
  for (std::size_t i = 0; i < size_; ++i) {
    const Bin& b = bins_[(head_ + kBins - i) % kBins];
    const double error = kDoubt + b.forward + b.backward - best, w = kDoubt * kDoubt / (error * error);
    const double t = b.t - middle, y = 0.5 * (b.forward - b.backward) - first;  // small numbers keep their digits
    sw += w;
    st += w * t;
    sy += w * y;
    stt += w * t * t;
    sty += w * t * y;
  }
  const double det = sw * stt - st * st;
  const bool long_enough = latest - oldest >= kFirstDrift && det > 1e-9 * sw * sw;
  drift_ = long_enough ? std::clamp((sw * sty - st * sy) / det, -kMostDrift, kMostDrift) : 0.0;
  offset_ = first + (sy - drift_ * st) / sw;
  t0_ = middle;
  bound_ = 0.5 * best;
}

}  // namespace palpate::network
