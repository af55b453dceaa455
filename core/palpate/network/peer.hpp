// What both ends do alike: clocks, ages, outages and the times in each packet.
#pragma once

#include "palpate/network/arrivals.hpp"
#include "palpate/network/clock.hpp"
#include "palpate/network/packet.hpp"

namespace palpate::network {

/// Time for which an outage only rests the tool; a longer one lets the hand go, and the tool aligns after it [s].
inline constexpr double kGrace = 0.15;

/// The other end, as seen from this one.
class Peer {
 public:
  /// A packet that arrived at the own time `now` [s]. Returns true if it is newer than all before.
  bool receive(const Datagram& d, double now) noexcept;
  /// One tick at the own time `now` [s].
  void step(double now) noexcept;
  /// Fills in the times and the flag of an outage of a packet that leaves at the own time `now` [s].
  void stamp(Datagram& out, double now) const noexcept;

  /// The newest packet by its sender's time.
  [[nodiscard]] const Datagram& newest() const noexcept { return newest_; }
  [[nodiscard]] bool known() const noexcept { return known_; }
  [[nodiscard]] const ClockSync& clock() const noexcept { return clock_; }
  [[nodiscard]] const Arrivals& arrivals() const noexcept { return arrivals_; }
  /// True while packets are missing, in the direction to this end.
  [[nodiscard]] bool outage() const noexcept { return arrivals_.outage(); }
  /// True once an outage has lasted kGrace, in either direction.
  [[nodiscard]] bool lost() const noexcept {
    return arrivals_.lasting() > kGrace || (known_ && (newest_.flags & kOutage) != 0);
  }
  /// The peer's time at the own time `now` [s].
  [[nodiscard]] double peer_time(double now) const noexcept { return now + clock_.offset(now); }

 private:
  Datagram newest_;
  double received_at_ = 0.0, last_ = 0.0;
  bool known_ = false;
  ClockSync clock_;
  Arrivals arrivals_;
};

}  // namespace palpate::network
