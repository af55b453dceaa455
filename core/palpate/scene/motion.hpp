// Motion of an object as a closed-form function of time: pose and velocity are known at any time, and nothing is
// stored.
#pragma once

#include <vector>

#include "palpate/types/spatial.hpp"

namespace palpate::scene {

/// Sinusoidal motion, for example breathing, a heartbeat or a shaking table.
struct Wave {
  Vec3 shift = Vec3::Zero();     ///< amplitude of the translation, in W [m]
  Vec3 rotation = Vec3::Zero();  ///< amplitude of the rotation vector, in W [rad]
  double period = 1.0;           ///< period [s]
  double phase = 0.0;            ///< phase at t0 [rad]
};

/// Motion of a rigid object by a displacement D(t) from its rest pose X_WO:
///
///   X_WO(t) = D(t) X_WO      D(t): x -> R(theta) (x - about) + about + s
///   s(t) = V.v (t - t0) + sum_i shift_i sin(2 pi (t - t0) / period_i + phase_i)
///   theta(t) = V.w (t - t0) + sum_i rotation_i sin(2 pi (t - t0) / period_i + phase_i)
///
/// where R(theta) is the rotation with the rotation vector theta. All vectors are expressed in W.
struct Motion {
  Twist V;                    ///< constant part of the velocity [m/s, rad/s]
  std::vector<Wave> waves;    ///< periodic part of the motion
  Vec3 about = Vec3::Zero();  ///< centre of the rotation, in W [m]
  double t0 = 0.0;            ///< time of zero displacement by the constant part [s]

  /// True for an object that never moves.
  [[nodiscard]] bool is_static() const noexcept { return waves.empty() && V.v.isZero(0.0) && V.w.isZero(0.0); }
  /// Pose in W at time t [s] of the object with the rest pose X_WO.
  [[nodiscard]] Pose pose(const Pose& X_WO, double t) const noexcept;
  /// Velocity in W [m/s] of the material point that is at p at time t. p: position in W [m]; t: [s].
  [[nodiscard]] Vec3 velocity(const Vec3& p, double t) const noexcept;
  /// Angular velocity in W at time t [rad/s]; t: [s].
  [[nodiscard]] Vec3 angular_velocity(double t) const noexcept;
};

}  // namespace palpate::scene
