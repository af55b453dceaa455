// A lower bound of the energy that the device itself dissipates.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate::stability {

/// The certified part of the device's friction, per joint or, of a device without joints, per axis of its base L.
struct CertainFriction {
  JointVector coulomb;     ///< Coulomb friction Fc [N m, N]
  JointVector viscous;     ///< viscous friction Fv [N m s/rad, N s/m]
  JointVector quantum;     ///< resolution of the joint's position [rad, m]
  bool at_handle = false;  ///< the entries belong to the position of the handle in L instead of joints
};

/// A lower bound of the heat of every motion that explains the measured positions. Each true position lies within half
/// a quantum of the measured one. The shortest such motion is the measured one passed through a backlash of one
/// quantum; `step` is a step of that motion:
///
///   Coulomb:  integral of Fc |v| dt  >=  Fc |step|
///   viscous:  integral of Fv v^2 dt  >=  Fv step^2 / (time since its last step)          (Cauchy-Schwarz inequality)
///
/// An encoder that flickers between two counts proves no motion and adds no heat.
class Dissipation {
 public:
  /// Empty vectors: no friction is certified. dt: period [s]. Throws std::invalid_argument if sizes differ or an entry
  /// is negative or not finite.
  Dissipation(CertainFriction friction, double dt);
  /// Heat certified since the last step [J]. q: measured joint positions [rad, m].
  double step(const JointVector& q) noexcept { return step(q, dt_); }
  /// The same after the measured period dt [s].
  double step(const JointVector& q, double dt) noexcept;
  /// True if `step` expects the position of the handle in L [m] instead of joint positions.
  [[nodiscard]] bool at_handle() const noexcept { return friction_.at_handle; }

 private:
  CertainFriction friction_;
  double dt_;
  JointVector shortest_, time_at_rest_;  ///< position of the shortest motion; time since it moved [s]
  JointVector
      uncounted_;  ///< start of the first motion that is not counted: the initial position is known to half a quantum
};

}  // namespace palpate::stability
