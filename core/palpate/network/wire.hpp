// Datagrams on an emulated link, in virtual time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "palpate/network/emulator.hpp"
#include "palpate/network/packet.hpp"

namespace palpate::network {

/// One direction of an emulated link with the datagrams that are under way.
class Wire {
 public:
  Wire(const Condition& condition, std::uint64_t seed) : link_(condition, seed) { flights_.reserve(kMost); }
  /// Sends a datagram at the time t [s]. Returns false if it is lost; so is one beyond the kMost that are under way.
  bool send(double t, const Datagram& d) noexcept {
    const Fate fate = link_.send(t, kBytes);
    for (int i = 0; i < fate.copies && flights_.size() < kMost; ++i) {
      flights_.push_back({fate.arrival[static_cast<std::size_t>(i)], ++number_, d});
      std::push_heap(flights_.begin(), flights_.end());
    }
    return fate.copies > 0;
  }
  /// Calls take(datagram, time of arrival) for all that have arrived by the time t [s], in the order of arrival.
  template <class Take>
  void deliver(double t, Take&& take) noexcept {
    while (!flights_.empty() && flights_.front().arrival <= t) {
      std::pop_heap(flights_.begin(), flights_.end());
      take(flights_.back().d, flights_.back().arrival);
      flights_.pop_back();
    }
  }

 private:
  static constexpr std::size_t kBytes = 256;  ///< of a packet on the wire
  static constexpr std::size_t kMost = 8192;
  struct Flight {
    double arrival;
    std::uint64_t number;
    Datagram d;
    bool operator<(const Flight& o) const noexcept {  // the earliest is the largest, on top of the heap
      return arrival != o.arrival ? arrival > o.arrival : number > o.number;
    }
  };

  Link link_;
  std::vector<Flight> flights_;
  std::uint64_t number_ = 0;
};

}  // namespace palpate::network
