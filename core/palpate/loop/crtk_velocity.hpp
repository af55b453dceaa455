// Velocity of a leader's handle, from the stream of twists or from successive poses.
#pragma once

#include "palpate/loop/crtk_watch.hpp"

namespace palpate::loop {

/// The reported twist while it arrives, otherwise the velocity differenced from poses. Both streams are redundant: a
/// twist whose motion is not that of the poses is a fault (kStreamsDisagree), as its damping would push the hand.
class HandVelocity {
 public:
  explicit HandVelocity(const WatchOptions& options) : options_(options), twist_(options) {}

  /// Receives two successive poses of the handle, with the time between their stamps [s].
  void moved(const Pose& from, const Pose& to, double dt, ClockTime now) noexcept;
  /// Receives a twist [m/s, rad/s] stamped `stamp` [s].
  void reported(double stamp, const Twist& V, ClockTime now) noexcept;

  /// Returns the faults since the last call and clears them.
  Faults take_faults() noexcept { return twist_.take_faults(); }
  /// Velocity of the handle in L. A reported twist counts while its stream is not silent.
  [[nodiscard]] const Twist& value(ClockTime now) const noexcept { return speaks(now) ? V_reported_ : V_differenced_; }

 private:
  [[nodiscard]] bool speaks(ClockTime now) const noexcept { return twist_.received() && !twist_.stale(now); }
  void compare(const Vec3& moved, const Vec3& turned, double dt) noexcept;

  WatchOptions options_;
  Watch twist_;
  Twist V_reported_, V_differenced_;
  Vec3 p_excess_ = Vec3::Zero(), R_excess_ = Vec3::Zero();  ///< motion by the twist minus that of the poses, fading
  double v_most_ = 0.0, w_most_ = 0.0;                      ///< fading maxima of the speed by the poses [m/s, rad/s]
};

}  // namespace palpate::loop
