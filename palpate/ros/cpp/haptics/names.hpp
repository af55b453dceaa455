// The devices of a haptic node and the CRTK names of their topics.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace palpate::ros {

struct HapticNames {
  std::string leader = "MTMR";
  std::string follower = "PSM1";     ///< empty: a virtual follower without an arm
  std::string teleop = "MTMR_PSM1";  ///< the external teleoperation component; empty: Palpate moves the follower
  std::string console = "console";
  std::string space;  ///< namespace of the nodes, e.g. /right; empty: none

  /// Name of the haptic node, which differs from those of the nodes on other leaders.
  [[nodiscard]] std::string node() const {
    std::string name = "palpate_haptics_" + leader;
    std::replace(name.begin(), name.end(), '/', '_');
    return name;
  }

  [[nodiscard]] bool own_teleop() const { return teleop.empty(); }
  [[nodiscard]] std::string of_leader(const std::string& topic) const { return "/" + leader + "/" + topic; }
  [[nodiscard]] std::string of_follower(const std::string& topic) const { return "/" + follower + "/" + topic; }
  /// Topics of measurements that this node reads.
  [[nodiscard]] std::vector<std::string> measured() const {
    std::vector<std::string> topics;
    for (const char* topic : {"measured_cp", "measured_cv", "measured_js", "gripper/measured_js"}) {
      topics.push_back(of_leader(topic));
    }
    if (follower.empty()) return topics;
    for (const char* topic : {"measured_cp", "measured_js", "jaw/measured_js"}) topics.push_back(of_follower(topic));
    return topics;
  }
  /// Topic of the wrenches: the leader's own topic only if no external teleoperation publishes on it.
  [[nodiscard]] std::string wrench() const {
    return own_teleop() ? of_leader("body/servo_cf") : "/" + teleop + "/following/mtm/body/servo_cf";
  }
};

}  // namespace palpate::ros
