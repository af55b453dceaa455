// Torque terms beside the force's and gravity's, each a function of the joints alone.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate::torque {

/// Dry and viscous friction, taken off the hand:  tau = gain r(|v|) (Fc sign v + Fv v),
/// r = 0 below `dead_band`, rising to 1 at `full_speed` [rad/s, m/s]. It never drives the arm by itself: at rest and in
/// the dead band it is zero, and beyond, its power gain r (Fc |v| + Fv v^2) is at most what friction takes, as long as
/// gain Fc and gain Fv are not above the true ones.
struct FrictionOptions {
  double gain = 0.0;        ///< 0 switches it off; below 1, so that an error of Fc does not drive
  double dead_band = 0.02;  ///< [rad/s, m/s]
  double full_speed = 0.2;  ///< [rad/s, m/s]
  JointVector coulomb;      ///< Fc of the controller's model [N m, N]; empty: none
  JointVector viscous;      ///< Fv [N m s/rad, N s/m]; empty: none
};
[[nodiscard]] JointVector friction(const FrictionOptions& options, const JointVector& v) noexcept;

/// A soft stop before each end stop: tau rises from zero, `margin` of the joint's range before it, to gain tau_max at
/// the limit. Of a potential, so that it stores and gives back, no more.
struct LimitOptions {
  double gain = 0.2;     ///< share of the drive's limit; 0 switches it off
  double margin = 0.03;  ///< share of the joint's range
};
[[nodiscard]] JointVector limits(const LimitOptions& options, const JointVector& q, const JointVector& q_min,
                                 const JointVector& q_max, const JointVector& tau_max) noexcept;

/// The dVRK's platform controller (mtsIntuitiveResearchKitMTM, effort mode), which keeps the gimbal of an MTM open:
/// torque of joint 4 [N m].
[[nodiscard]] double platform(double gain, const JointVector& q, const JointVector& v) noexcept;

}  // namespace palpate::torque
