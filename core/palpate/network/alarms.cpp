#include "palpate/network/alarms.hpp"

#include <algorithm>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

#include "palpate/network/arrivals.hpp"
#include "palpate/types/require.hpp"

namespace palpate::network {
namespace {

constexpr double kEvery = 1e-3;            // [s] period of packets and ticks
constexpr double kEnd = 5.0;               // [s] for which the outage at the end is watched
constexpr std::size_t kPacketBytes = 256;  // of a packet

}  // namespace

Alarms count_alarms(Condition condition, double seconds, double settle, std::uint64_t seed) {
  require("alarms", seconds > 0.0 && seconds <= 1e6, "seconds", seconds, "must be above 0 s, up to 1e6 s");
  require("alarms", settle >= 0.0 && settle <= 1e6, "settle", settle, "must be 0 s or more, up to 1e6 s");
  condition.outages.clear();
  condition.outage_every = 0.0;
  Link link(condition, seed);
  Arrivals arrivals;
  using Flight = std::pair<double, double>;  // time of arrival, time of sending
  std::priority_queue<Flight, std::vector<Flight>, std::greater<>> flying;
  double newest = 0.0, before_age = 0.0;
  std::vector<double> largest;  // ages at which a packet ended the wait
  const auto tick = [&](double t) {
    for (; !flying.empty() && flying.top().first <= t; flying.pop()) newest = std::max(newest, flying.top().second);
    arrivals.step(t - newest, kEvery);
  };
  Alarms out;
  const auto ticks = static_cast<std::int64_t>((settle + seconds) / kEvery);
  int before = 0;
  for (std::int64_t k = 0; k < ticks; ++k) {
    const double t = kEvery * static_cast<double>(k);
    const Fate fate = link.send(t, kPacketBytes);
    for (int i = 0; i < fate.copies; ++i) flying.emplace(fate.arrival[static_cast<std::size_t>(i)], t);
    tick(t);
    if (t < settle) {
      before = arrivals.outages();
    } else if (t - newest < before_age) {
      largest.push_back(before_age);
    }
    before_age = t - newest;
  }
  const auto hours =
      std::min(static_cast<std::size_t>(seconds / 3600.0), largest.size() - std::min<std::size_t>(1, largest.size()));
  std::nth_element(largest.begin(), largest.begin() + static_cast<std::ptrdiff_t>(hours), largest.end(),
                   std::greater<>());
  out.possible = largest.empty() ? 0.0 : largest[hours];
  out.false_alarms = arrivals.outages() - before;
  out.seconds = seconds;
  out.p999 = arrivals.p999();
  out.limit = arrivals.limit();
  for (std::int64_t k = ticks; kEvery * static_cast<double>(k - ticks) < kEnd && out.told < 0.0; ++k) {
    tick(kEvery * static_cast<double>(k));
    if (arrivals.outage()) out.told = arrivals.age();
  }
  return out;
}

}  // namespace palpate::network
