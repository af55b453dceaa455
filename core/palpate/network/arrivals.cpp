#include "palpate/network/arrivals.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::network {

double Arrivals::limit() const noexcept {
  return ticks_ < kFirst ? kPatience : std::max(p999_ + kAlarm, once_an_hour_);
}

void Arrivals::step(double age, double dt) noexcept {
  const double before = age_;
  age_ = age;
  watch(limit(), dt);
  if (outage_) {
    waits_ = 0;
    return;
  }
  if (age < before) add(peaks_, before);
  observed_ += dt;
  since_halved_ += dt;
  if (waits_ == kWait) {
    count(waiting_[first_]);
    first_ = (first_ + 1) % kWait;
    --waits_;
  }
  waiting_[(first_ + waits_++) % kWait] = age;
}

// Bin of an age; NaN: 0.
std::size_t Arrivals::bin_of(double age) noexcept {
  return static_cast<std::size_t>(std::min(std::max(0.0, age / kBin), kBins - 1.0));
}

void Arrivals::add(Histogram& to, double age) noexcept {
  const std::size_t bin = bin_of(age);
  to[bin] += 1.0f;
  top_ = std::max(top_, bin + 1);
}

// Adds an age to the histogram.
void Arrivals::count(double age) noexcept {
  add(count_, age);
  total_ += 1.0;
  if (++ticks_ % kForget == 0) {
    for (float& c : count_) c *= 0.5f;
    total_ *= 0.5;
  }
  if (ticks_ % kRefresh != 0) return;
  refresh();
  if (since_halved_ > kRemember) {
    for (float& c : peaks_) c *= 0.5f;
    observed_ *= 0.5;
    since_halved_ = 0.0;
  }
  fit_tail();
}

// The age that an excursion exceeds once an hour, by the largest excursions.
void Arrivals::fit_tail() noexcept {
  once_an_hour_ = 0.0;
  if (observed_ < kBefore) return;
  double above = 0.0, sum = 0.0;
  std::size_t i = top_;
  while (i > 0 && above < kTail) {
    --i;
    above += peaks_[i];
    sum += peaks_[i] * static_cast<double>(i);
  }
  const double an_hour = above * 3600.0 / observed_;
  if (above < kTail || an_hour <= 1.0) return;
  const double u = static_cast<double>(i), mean = sum / above - u + 0.5;
  once_an_hour_ = kBin * (u + mean * (1.0 + 1.0 / std::sqrt(above)) * std::log(an_hour));
}

void Arrivals::start_anew() noexcept {
  count_.fill(0.0f);
  peaks_.fill(0.0f);
  total_ = observed_ = since_halved_ = once_an_hour_ = 0.0;
  ticks_ = 0;
  top_ = 0;
  outage_ = false;
}

// Begins and ends outages.
void Arrivals::watch(double limit, double dt) noexcept {
  if (!outage_ && age_ > limit) {
    outage_ = true;
    back_ = since_ = lasting_ = 0.0;
    age_then_ = oldest_ = age_;
    ++outages_;
    return;
  }
  if (!outage_) return;
  lasting_ += dt;
  back_ = age_ <= limit ? back_ + dt : 0.0;
  oldest_ = std::max(oldest_, age_);
  outage_ = back_ < kBack;
  if (!outage_ && lasting_ < kShort) add(peaks_, oldest_);
  since_ += dt;
  if (since_ < kSteady) return;
  if (age_ - age_then_ < 0.5 * since_) {  // without packets the age grows as fast as time
    start_anew();
  }
  since_ = 0.0;
  age_then_ = age_;
}

void Arrivals::refresh() noexcept {
  double beyond = 0.0;
  bool top = true, middle = true;
  for (std::size_t i = top_; i-- > 0;) {
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
