// How an object moves: in closed form, so that where it is and how fast are known at any time, and nothing is stored.
#pragma once

#include <vector>

#include "palpate/types/spatial.hpp"

namespace palpate::scene {

/// A sinusoid: breathing, a heartbeat, a shaking table.
struct Wave {
  Vec3 shift = Vec3::Zero();  ///< amplitude of the shift, along the axes of W [m]
  Vec3 turn = Vec3::Zero();   ///< amplitude of the rotation vector, in W [rad]
  double period = 1.0;        ///< [s]
  double phase = 0.0;         ///< at t0 [rad]
};

/// The displacement D(t) of a rigid object from where it rests:
///
///   X_WO(t) = D(t) X_WO      D(t): x -> R(theta) (x - about) + about + s
///   s(t) = V.v (t - t0) + sum_i shift_i sin(2 pi (t - t0) / period_i + phase_i)      theta(t) likewise of V.w, turn_i
///
/// with R(theta) the rotation about the vector theta by its length.
struct Motion {
  Twist V;                    ///< steady part
  std::vector<Wave> waves;    ///< periodic part
  Vec3 about = Vec3::Zero();  ///< centre of the turning, in W [m]
  double t0 = 0.0;            ///< [s]

  [[nodiscard]] bool still() const noexcept { return waves.empty() && V.v.isZero(0.0) && V.w.isZero(0.0); }
  /// Where the pose X_WO at rest has gone at time t [s].
  [[nodiscard]] Pose pose(const Pose& X_WO, double t) const noexcept;
  /// Velocity at time t of the material point that is at p (in W) then [m/s].
  [[nodiscard]] Vec3 velocity(const Vec3& p, double t) const noexcept;
  /// Angular velocity at time t, in W [rad/s].
  [[nodiscard]] Vec3 spin(double t) const noexcept;
};

}  // namespace palpate::scene
