// How often a link without an outage raises an alarm, and how soon a true outage is reported.
#pragma once

#include <cstdint>

#include "palpate/network/emulator.hpp"

namespace palpate::network {

/// Figures of the detector of outages on one emulated link.
struct Alarms {
  int false_alarms = 0;  ///< outages that were reported while packets were sent
  double seconds = 0.0;  ///< virtual time in which they were counted [s]
  double p999 = 0.0;     ///< 99.9th percentile of the age before the outage [s]
  double limit = 0.0;    ///< age from which an outage is reported then [s]
  double possible =
      0.0;             ///< age that an hour of this link exceeds once without an outage: no sooner may one be told [s]
  double told = -1.0;  ///< age at which the outage at the end was reported [s]; negative: never
};

/// Sends a packet every millisecond for `seconds` of virtual time, then none; counts what `Arrivals` reports. `settle`:
/// time at the start that does not count [s]. The fixed outages of the condition are left out.
[[nodiscard]] Alarms count_alarms(Condition condition, double seconds, double settle, std::uint64_t seed);

}  // namespace palpate::network
