#include "palpate/network/follower.hpp"

#include <algorithm>
#include <utility>

#include "palpate/types/require.hpp"

namespace palpate::network {
namespace {

constexpr std::int64_t kMostMissed = 20;  // ticks by which the instrument catches up after a gap

}  // namespace

Follower::Follower(const FollowerOptions& options, scene::Snapshot scene, scene::Snapshot world, const Pose& X)
    : options_(options),
      site_(options.site, std::move(scene)),
      instrument_(options.instrument, options.site.radius, std::move(world), 1),
      thread_(options.realtime) {
  require("follower", options.rate >= 50.0 && options.rate <= 10000.0, "rate", options.rate, "must be 50 to 10000 Hz");
  require("follower", X.p.allFinite(), "p", X.p.sum(), "must be finite");
  instrument_.place(X);
  FollowerState before;
  before.x = X.p;
  state_.write(before);
}

void Follower::start() {
  thread_.start(options_.rate, [this](const loop::Wake& w) { return wake(w); });
}

FollowerState Follower::state() {
  const std::lock_guard lock(readers_);
  return state_.read();
}

bool Follower::wake(const loop::Wake& w) noexcept {
  const bool forget = forget_.exchange(false);
  if (forget) site_.forget_operator();
  for (Arrived a; inbox_.pop(a);) {
    if (!forget) site_.receive(a.d, a.at);  // with a new operator: packets of the one before
  }
  const double now = 1e-9 * static_cast<double>(loop::now_ns()), dt = 1.0 / options_.rate;
  const std::int64_t periods = 1 + std::min(w.missed, kMostMissed);
  const SiteGoal& goal = site_.step(instrument_.measure(now), dt * static_cast<double>(periods));
  for (std::int64_t i = 0; i < periods; ++i) instrument_.step(goal, now, dt);
  FollowerState s;
  static_cast<Ages&>(s) = site_.peer().arrivals().ages();
  s.out = site_.send();
  s.x = instrument_.x();
  s.F = instrument_.force();
  s.largest = instrument_.largest();
  s.account = site_.account();
  state_.write(s);
  return !w.stopping;
}

}  // namespace palpate::network
