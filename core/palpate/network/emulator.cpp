#include "palpate/network/emulator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "palpate/types/random.hpp"
#include "palpate/types/require.hpp"

namespace palpate::network {
namespace {

constexpr double kLongest = 60.0;  // [s] longest delay
constexpr double kOften = 1e-3;    // [s] shortest mean time between outages, each of which is drawn
constexpr int kMostSteps = 60;     // of Newton's method

void check_share(double value, const char* key) {
  require("network", value >= 0.0 && value <= 1.0, key, value, "must be a probability, 0..1");
}

void check_time(double value, const char* key) {
  require("network", value >= 0.0 && value <= kLongest, key, value, "must lie in 0..60 s");
}

void check_mixture(const Condition& c) {
  require("network", c.weights.size() == c.rates.size(), "weights", static_cast<double>(c.weights.size()),
          "must be as many as the rates");
  for (const double w : c.weights) check_share(w, "weights");
  for (const double r : c.rates) require("network", r > 0.0 && std::isfinite(r), "rates", r, "must be above 0 1/s");
  const double sum = std::accumulate(c.weights.begin(), c.weights.end(), 0.0);
  require("network", c.weights.empty() || std::abs(sum - 1.0) < 0.01, "weights", sum, "must add up to 1");
}

}  // namespace

void check(const Condition& c) {
  check_time(c.delay, "delay");
  check_time(c.reorder_delay, "reorder_delay");
  check_time(c.queue, "queue");
  check_time(c.outage_min, "outage_min");
  check_time(c.outage_max, "outage_max");
  check_mixture(c);
  require("network", std::abs(c.correlation) < 1.0, "correlation", c.correlation, "must lie between -1 and 1");
  check_share(c.reorder, "reorder");
  check_share(c.duplicate, "duplicate");
  for (const double p : {c.gilbert.to_bad, c.gilbert.to_good, c.gilbert.loss_good, c.gilbert.loss_bad}) {
    check_share(p, "gilbert");
  }
  const FourStates& f = c.four;
  for (const double p : {f.p13, f.p31, f.p32, f.p23, f.p14, f.p13 + f.p14, f.p31 + f.p32}) check_share(p, "four");
  require("network", c.rate >= 0.0 && std::isfinite(c.rate), "rate", c.rate, "must be 0 (unlimited) or more bytes/s");
  require("network", c.outage_every == 0.0 || c.outage_every >= kOften, "outage_every", c.outage_every,
          "must be 0 s (none), or 1 ms or more");
  require("network", c.outage_max >= c.outage_min, "outage_max", c.outage_max, "must not be below outage_min");
  for (std::size_t i = 0; i < c.trace.size(); ++i) {
    require("network", c.trace[i].delay <= kLongest, "trace", c.trace[i].delay, "has a delay above 60 s");
    require("network", i == 0 || c.trace[i].t > c.trace[i - 1].t, "trace", c.trace[i].t, "times must increase");
  }
}

double mixture_quantile(const Condition& c, double survival) noexcept {
  if (c.rates.empty()) return 0.0;
  // The survival function is convex and falls, so Newton's method from the left converges without overshoot.
  double x = -std::log(survival) / *std::max_element(c.rates.begin(), c.rates.end());
  for (int k = 0; k < kMostSteps; ++k) {
    double value = -survival, slope = 0.0;
    for (std::size_t i = 0; i < c.rates.size(); ++i) {
      const double part = c.weights[i] * std::exp(-c.rates[i] * x);
      value += part;
      slope += c.rates[i] * part;
    }
    if (!(value > 1e-14) || !(slope > 0.0)) break;
    x += value / slope;
  }
  return std::min(x, kLongest);
}

Link::Link(const Condition& condition, std::uint64_t seed) : c_(condition), random_(seed) {
  check(c_);
  z_ = gauss(random_);
  next_outage_ = c_.outage_every > 0.0 ? -c_.outage_every * std::log1p(-uniform(random_)) : INFINITY;
}

// Additional delay of the next packet [s].
double Link::extra() noexcept {
  if (c_.rates.empty()) return 0.0;
  const double c = c_.correlation;
  z_ = c * z_ + std::sqrt(1.0 - c * c) * gauss(random_);
  return mixture_quantile(c_, std::max(0.5 * std::erfc(z_ * std::numbers::sqrt2 / 2.0), 1e-15));
}

// Steps both chains of loss by one packet; true if it is lost.
bool Link::lost_by_chain() noexcept {
  const GilbertElliott& g = c_.gilbert;
  bad_ = bad_ ? !(uniform(random_) < g.to_good) : uniform(random_) < g.to_bad;
  const bool lost = uniform(random_) < (bad_ ? g.loss_bad : g.loss_good);
  const FourStates& f = c_.four;
  const double u = uniform(random_);
  if (state_ == 1) {
    state_ = u < f.p13 ? 3 : (u < f.p13 + f.p14 ? 4 : 1);
  } else if (state_ == 3) {
    state_ = u < f.p31 ? 1 : (u < f.p31 + f.p32 ? 2 : 3);
  } else if (state_ == 2) {
    state_ = u < f.p23 ? 3 : 2;
  } else {
    state_ = 1;
  }
  return lost || state_ >= 3;
}

bool Link::in_outage(double t) noexcept {
  while (t >= next_outage_) {
    outage_end_ = next_outage_ + c_.outage_min + (c_.outage_max - c_.outage_min) * uniform(random_);
    next_outage_ = outage_end_ - c_.outage_every * std::log1p(-uniform(random_));
  }
  return t < outage_end_ || std::any_of(
                                c_.outages.begin(), c_.outages.end(),
                                [t](const Outage& o) { return t >= o.begin && t < o.begin + o.duration; });
}

// Smallest delay of a packet sent at t; sets `lost` where the trace says so.
double Link::base(double t, bool& lost) const noexcept {
  if (c_.trace.empty()) return c_.delay;
  const double begin = c_.trace.front().t, span = c_.trace.back().t - begin;
  const double at = span > 0.0 && t > begin ? begin + std::fmod(t - begin, span) : begin;
  const auto after =
      std::upper_bound(c_.trace.begin() + 1, c_.trace.end(), at, [](double x, const TracePoint& p) { return x < p.t; });
  const double delay = std::prev(after)->delay;
  lost |= delay < 0.0;
  return std::max(delay, 0.0);
}

double Link::arrival(double t, double sent, bool& lost) noexcept {
  double at = sent + base(t, lost);
  if (c_.trace.empty()) at += extra();
  if (uniform(random_) < c_.reorder) return at + c_.reorder_delay;
  if (!c_.keep_order) return at;
  last_ = std::max(last_, at);
  return last_;
}

Fate Link::send(double t, std::size_t bytes) noexcept {
  Fate fate;
  bool lost = lost_by_chain();
  const bool out = in_outage(t);
  double sent = t;
  if (c_.rate > 0.0) {
    const double begin = std::max(t, free_at_);
    if (begin - t > c_.queue) return fate;
    sent = free_at_ = begin + static_cast<double>(bytes) / c_.rate;
  }
  const int copies = uniform(random_) < c_.duplicate ? 2 : 1;
  for (int i = 0; i < copies; ++i) fate.arrival[static_cast<std::size_t>(i)] = arrival(t, sent, lost);
  fate.copies = lost || out ? 0 : copies;
  return fate;
}

}  // namespace palpate::network
