// Poses of live objects: objects that follow a tracker while the loop runs. Another thread hands them to the loop.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "palpate/types/spatial.hpp"

namespace palpate {

/// Maximum number of live objects in a scene, and of tracked frames in a record.
inline constexpr int kMaxLive = 8;

/// Pose that a live object shall reach.
struct LiveTarget {
  double t = 0.0;     ///< time at which the pose is valid [s]
  Pose X_WO;          ///< pose of the object in W
  Twist V_WO;         ///< velocity of O's origin and angular velocity, in W; zero if unknown [m/s, rad/s]
  bool lost = false;  ///< true: the pose is no longer trusted; the object stops, and its force fades
};

/// State of a tracked frame, for the record only.
struct TrackedFrame {
  Pose X_WF;                                                 ///< last good pose in W
  double t_seen = -std::numeric_limits<double>::infinity();  ///< time of the last good pose; -inf: none yet [s]
  bool lost = true;                                          ///< true if the last good pose is too old
};

/// Targets of all live objects, in the order of the snapshot, and the tracked frames.
struct LiveTargets {
  std::array<LiveTarget, kMaxLive> object;
  std::array<TrackedFrame, kMaxLive> frame;
  int objects = 0, frames = 0;
  std::uint64_t epoch = 0;  ///< number of the set of objects that the targets belong to; set by loop::Front
};

}  // namespace palpate
