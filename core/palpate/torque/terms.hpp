// Torque terms that depend on the joint positions and velocities only.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate::torque {

/// Friction compensation, for each joint
///
///   tau = gain r(|v|) (Fc sign v + Fv v)
///
/// where r is 0 below `dead_band` and rises linearly to 1 at `full_speed`. The compensation cannot drive the arm by
/// itself: inside the dead band it is zero, and outside its power gain r (Fc |v| + Fv v^2) is at most the power that
/// friction dissipates, as long as gain Fc and gain Fv are not above the true coefficients.
struct FrictionOptions {
  double gain = 0.0;  ///< fraction of the friction that is compensated [-]; 0: off; below 1 allows for errors of Fc
  double dead_band = 0.02;  ///< speed below which nothing is compensated [rad/s, m/s]
  double full_speed = 0.2;  ///< speed above which the compensation is full [rad/s, m/s]
  JointVector coulomb;      ///< Coulomb friction Fc of the controller's model (n,) [N m, N]; empty: none
  JointVector viscous;      ///< viscous friction Fv of the controller's model (n,) [N m s/rad, N s/m]; empty: none
};
/// Torque that compensates friction at the joint velocities v (n,) [N m, N].
[[nodiscard]] JointVector friction(const FrictionOptions& options, const JointVector& v) noexcept;

/// Soft stops before the joint limits. The torque rises linearly from zero, at a distance `margin` before the limit, to
/// gain tau_max at the limit. The torque is the gradient of a potential, so a soft stop returns the energy that it
/// stores and generates none.
struct LimitOptions {
  double gain = 0.2;     ///< torque at the joint limit, as a fraction of the drive limit [-]; 0 switches the stops off
  double margin = 0.03;  ///< width of a soft stop, as a fraction of the joint range [-]
};
/// Torque of the soft stops at the joint positions q (n,) [N m, N]. tau_max: drive limits (n,) [N m, N].
[[nodiscard]] JointVector limits(const LimitOptions& options, const JointVector& q, const JointVector& q_min,
                                 const JointVector& q_max, const JointVector& tau_max) noexcept;

/// Torque of joint 4 by the dVRK's platform controller (mtsIntuitiveResearchKitMTM, effort mode), which keeps the
/// gimbal of an MTM open [N m]. q: joint positions (7,) [rad]; v: joint velocities (7,) [rad/s].
[[nodiscard]] double platform(double gain, const JointVector& q, const JointVector& v) noexcept;

}  // namespace palpate::torque
