// Rate-limited motion of a live object towards poses that are set while the loop runs.
//
// The target moves on from its time t_g with its own velocity, for as long as it is young enough. With the displacement
// e from the object's centre to the target's, and the target's velocity v_g, the wanted velocity of the centre is
//
//   v_wanted = v_g + e / |e| min(k |e|, sqrt(a |e|))        limited to the largest speed
//
// where sqrt(a |e|) is a speed from which the object can still stop. The velocity approaches v_wanted at the rate 4 k,
// which filters the noise of a tracker and makes the pair critically damped, and changes by at most a dt in a time dt.
// The rotation about the centre likewise. An object rests while its mean displacement from a target at rest is below
// 0.3 mm and 0.3 deg, so that noise alone does not move it.
//
// When the target is lost, the object brakes to rest where it is, and its share of the force falls to zero.
#pragma once

#include "palpate/types/live.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::scene {

/// Limits of the motion of a live object, and the fading of its force when its target is lost.
struct LiveOptions {
  double speed = 0.1;         ///< largest speed of the centre [m/s]
  double turn = 1.05;         ///< largest angular speed [rad/s]
  double acceleration = 0.5;  ///< largest acceleration of the centre; that of the rotation is 10 / m times it [m/s^2]
  double max_age = 0.2;       ///< age of the target above which it is lost [s]
  double gain = 8.0;          ///< k: speed per remaining displacement near the target [1/s]
  double fade = 0.5;          ///< time in which the force of a lost object falls to zero; 0: the force stays [s]
  Vec3 p_OC = Vec3::Zero();   ///< centre of the object, about which it turns, in O [m]
};

/// Motion of one live object.
class Approach {
 public:
  /// Places the object at rest at X_WO, with its full force, at the time t [s].
  void reset(Pose X_WO, double t) noexcept;
  /// Moves the object to the time t [s]. A step back in time moves nothing.
  void step(const LiveTarget& target, const LiveOptions& options, double t) noexcept;

  /// Pose of the object in W.
  [[nodiscard]] const Pose& X_WO() const noexcept { return X_WO_; }
  /// Velocity of the object's centre and angular velocity, in W [m/s, rad/s].
  [[nodiscard]] const Twist& velocity() const noexcept { return V_; }
  /// Time of the last step [s].
  [[nodiscard]] double t() const noexcept { return t_; }
  /// True while the target is lost.
  [[nodiscard]] bool lost() const noexcept { return lost_; }
  /// Share of its stiffness and damping that the object renders [-].
  [[nodiscard]] double share() const noexcept { return share_; }

 private:
  void aim(const LiveTarget& target, const LiveOptions& options, double dt) noexcept;
  [[nodiscard]] bool settled(const Twist& V_target) const noexcept;

  Pose X_WO_;
  Twist V_;
  Vec3 off_ = Vec3::Zero(), turned_off_ = Vec3::Zero();  // mean displacement to the target [m], [rad]
  double t_ = 0.0, share_ = 1.0;
  bool lost_ = false;
};

}  // namespace palpate::scene
