#include "palpate/network/arrivals.hpp"

#include <algorithm>

namespace palpate::network {

void Arrivals::step(double age, double dt) noexcept {
  age_ = age;
  const double limit = ticks_ < kFirst ? kPatience : p999_ + kAlarm;
  watch(limit, dt);
  if (outage_) {
    waits_ = 0;
    return;
  }
  if (waits_ == kWait) {
    count(waiting_[first_]);
    first_ = (first_ + 1) % kWait;
    --waits_;
  }
  waiting_[(first_ + waits_++) % kWait] = age;
}

// Adds an age to the histogram.
void Arrivals::count(double age) noexcept {
  const auto bin = static_cast<std::size_t>(std::min(std::max(0.0, age / kBin), kBins - 1.0));  // NaN: 0
  count_[bin] += 1.0f;
  total_ += 1.0;
  if (++ticks_ % kForget == 0) {
    for (float& c : count_) c *= 0.5f;
    total_ *= 0.5;
  }
  if (ticks_ % kRefresh == 0) refresh();
}

// Begins and ends outages.
void Arrivals::watch(double limit, double dt) noexcept {
  if (!outage_ && age_ > limit) {
    outage_ = true;
    back_ = since_ = lasting_ = 0.0;
    age_then_ = age_;
    ++outages_;
    return;
  }
  if (!outage_) return;
  lasting_ += dt;
  back_ = age_ <= limit ? back_ + dt : 0.0;
  outage_ = back_ < kBack;
  since_ += dt;
  if (since_ < kSteady) return;
  if (age_ - age_then_ < 0.5 * since_) {  // without packets the age grows as fast as time
    count_.fill(0.0f);
    total_ = 0.0;
    ticks_ = 0;
    outage_ = false;
  }
  since_ = 0.0;
  age_then_ = age_;
}

void Arrivals::refresh() noexcept {
  double beyond = 0.0;
  bool top = true, middle = true;
  for (std::size_t i = kBins; i-- > 0;) {
    beyond += count_[i];
    const double edge = kBin * static_cast<double>(i + 1);
    if (top && beyond > 1e-3 * total_) {
      p999_ = edge;
      top = false;
    }
    if (middle && beyond > 1e-2 * total_) {
      p99_ = edge;
      middle = false;
    }
    if (beyond > 0.5 * total_) {
      p50_ = edge;
      break;
    }
  }
}

}  // namespace palpate::network
