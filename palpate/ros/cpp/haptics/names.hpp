// Which devices a haptic node works with, and the CRTK names of their topics.
#pragma once

#include <string>

namespace palpate::ros {

struct HapticNames {
  std::string leader = "MTMR";
  std::string follower = "PSM1";     ///< empty: a virtual one
  std::string teleop = "MTMR_PSM1";  ///< of somebody else's teleoperation; empty: ours
  std::string console = "console";

  [[nodiscard]] bool own_teleop() const { return teleop.empty(); }
  [[nodiscard]] std::string of_leader(const std::string& topic) const { return "/" + leader + "/" + topic; }
  [[nodiscard]] std::string of_follower(const std::string& topic) const { return "/" + follower + "/" + topic; }
  /// Where wrenches go: straight to the leader only when no other teleoperation writes there.
  [[nodiscard]] std::string wrench() const {
    return own_teleop() ? of_leader("body/servo_cf") : "/" + teleop + "/following/mtm/body/servo_cf";
  }
};

}  // namespace palpate::ros
