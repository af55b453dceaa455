// What the device itself surely turns into heat.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate::stability {

/// The part of the device's friction that is certain, per joint.
struct CertainFriction {
  JointVector coulomb;  ///< [N m, N]
  JointVector viscous;  ///< [N m s/rad, N s/m]
  JointVector quantum;  ///< resolution of the joint's position [rad, m]
};

/// A bound from below on the heat of every motion that explains the measured positions. Each true position lies within
/// half a quantum of the measured one. The laziest such motion (a play of that width) is the shortest, so
///
///   Coulomb:  integral of Fc |v| dt  >=  Fc |step of the lazy motion|
///   viscous:  integral of Fv v^2 dt  >=  Fv step^2 / (time since its last step)          (Cauchy and Schwarz)
///
/// An encoder that flickers between two counts proves no motion, and earns nothing.
class Dissipation {
 public:
  /// Empty vectors: nothing is certain. dt [s]. Throws std::invalid_argument when sizes differ or entries are negative.
  Dissipation(CertainFriction friction, double dt);
  /// q: measured joints. What was surely dissipated since the last step [J].
  double step(const JointVector& q) noexcept;

 private:
  CertainFriction friction_;
  double dt_;
  JointVector lazy_, rest_;  ///< position of the laziest motion; periods since it moved
  JointVector free_;         ///< of its first motion: it may have begun half a quantum nearer
};

}  // namespace palpate::stability
