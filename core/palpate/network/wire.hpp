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
  Wire(const Condition& condition, std::uint64_t seed) : link_(condition, seed), datagrams_(kMost) {
    flights_.reserve(kMost);
    for (std::uint32_t k = kMost; k-- > 0;) free_.push_back(k);
  }
  /// Sends a datagram at the time t [s]. Returns false if it is lost; so is one beyond the kMost that are under way.
  bool send(double t, const Datagram& d) noexcept {
    const Fate fate = link_.send(t, kBytes);
    for (int i = 0; i < fate.copies && !free_.empty(); ++i) {
      const std::uint32_t place = free_.back();
      free_.pop_back();
      datagrams_[place] = d;
      flights_.push_back({fate.arrival[static_cast<std::size_t>(i)], ++number_, place});
      std::push_heap(flights_.begin(), flights_.end());
    }
    return fate.copies > 0;
  }
  /// Calls take(datagram, time of arrival) for all that have arrived by the time t [s], in the order of arrival.
  template <class Take>
  void deliver(double t, Take&& take) noexcept {
    while (!flights_.empty() && flights_.front().arrival <= t) {
      std::pop_heap(flights_.begin(), flights_.end());
      const Flight flight = flights_.back();
      flights_.pop_back();
      free_.push_back(flight.place);
      take(datagrams_[flight.place], flight.arrival);
    }
  }

 private:
  static constexpr std::size_t kBytes = 256;  ///< of a packet on the wire
  static constexpr std::size_t kMost = 8192;
  struct Flight {
    double arrival;
    std::uint64_t number;
    std::uint32_t place;                              // of its datagram
    bool operator<(const Flight& o) const noexcept {  // the earliest is the largest, on top of the heap
      return arrival != o.arrival ? arrival > o.arrival : number > o.number;
    }
  };

  Link link_;
  std::vector<Flight> flights_;      ///< a heap
  std::vector<Datagram> datagrams_;  ///< of the flights
  std::vector<std::uint32_t> free_;  ///< places there without a flight
  std::uint64_t number_ = 0;
};

}  // namespace palpate::network
