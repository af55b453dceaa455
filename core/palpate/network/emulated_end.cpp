#include "palpate/network/emulated_end.hpp"

#include <utility>

#include "palpate/types/require.hpp"

namespace palpate::network {

EmulatedEnd::EmulatedEnd(const EmulatedOptions& options, const scene::Snapshot& scene, scene::Snapshot world)
    : end_(options.operator_end, scene),
      site_(options.follower.site, scene),
      instrument_(options.follower.instrument, options.follower.site.radius, std::move(world), options.seed + 17),
      to_site_(options.to_site, options.seed + 1),
      to_operator_(options.to_operator, options.seed + 2),
      dt_(1.0 / options.follower.rate) {
  require("follower", options.follower.rate >= 50.0, "rate", options.follower.rate, "must be 50 Hz or more");
}

const loop::RemoteTick& EmulatedEnd::step(const loop::LocalTool& tool) noexcept {
  const double t = tool.t;
  if (!started_) instrument_.place(tool.X);
  started_ = true;
  to_site_.deliver(t, [this](const Datagram& d, double at) { site_.receive(d, at); });
  to_operator_.deliver(t, [this](const Datagram& d, double at) { end_.receive(d, at); });
  const loop::RemoteTick& felt = end_.step_at(tool, t);
  instrument_.step(site_.step(instrument_.measure(t), dt_), t, dt_);
  to_site_.send(t, end_.packet());
  to_operator_.send(t, site_.send());
  return felt;
}

}  // namespace palpate::network
