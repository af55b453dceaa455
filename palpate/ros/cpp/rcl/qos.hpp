// Quality of service: the settings that the simulated dVRK and the haptic node use.
#pragma once

#include <rmw/qos_profiles.h>
#include <rmw/types.h>

#include <cstddef>

namespace palpate::ros {

struct Qos {
  std::size_t depth = 10;        ///< length of the message queue [-]
  bool reliable = true;          ///< lost messages are sent again
  bool transient_local = false;  ///< latched: late subscribers also receive the last messages

  [[nodiscard]] rmw_qos_profile_t profile() const noexcept {
    rmw_qos_profile_t profile = rmw_qos_profile_default;
    profile.depth = depth;
    profile.reliability = reliable ? RMW_QOS_POLICY_RELIABILITY_RELIABLE : RMW_QOS_POLICY_RELIABILITY_BEST_EFFORT;
    profile.durability =
        transient_local ? RMW_QOS_POLICY_DURABILITY_TRANSIENT_LOCAL : RMW_QOS_POLICY_DURABILITY_VOLATILE;
    return profile;
  }
};

inline constexpr Qos kLatched{.depth = 1, .reliable = true, .transient_local = true};

}  // namespace palpate::ros
