#include "palpate/network/peer.hpp"

#include <algorithm>

namespace palpate::network {

bool Peer::receive(const Datagram& d, double now) noexcept {
  if (known_ && d.t == newest_.t) return false;  // repeated, by a loop that rests: tells nothing about clocks or delays
  // A packet that left before the first tick has the time 0, and its answer tells nothing about clocks.
  if (d.t_received != 0.0 && d.t_peer != 0.0) clock_.add(d.t_peer, d.t_received, d.t, now);
  if (known_ && d.t < newest_.t) return false;
  newest_ = d;
  received_at_ = now;
  known_ = true;
  return true;
}

void Peer::step(double now) noexcept {
  const double dt = std::max(now - last_, 0.0);
  last_ = now;
  if (known_ && clock_.known()) arrivals_.step(std::max(peer_time(now) - newest_.t, 0.0), dt);
}

void Peer::stamp(Datagram& out, double now) const noexcept {
  out.t = now;
  out.t_peer = known_ ? newest_.t : 0.0;
  out.t_received = known_ ? received_at_ : 0.0;
  out.flags = (out.flags & ~kOutage) | (arrivals_.lasting() > kGrace ? kOutage : 0u);
}

}  // namespace palpate::network
