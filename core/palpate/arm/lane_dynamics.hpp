// The equation of motion M a + bias = tau for a plant, which evaluates it ten thousand times a second: numbers of the
// joints side by side, zero beyond the last joint. Without Eigen, since vector instructions fill it.
#pragma once

#include "palpate/types/lanes.hpp"

namespace palpate::arm {

/// A body that is fixed to the tip, weightless, with the same inertia about every axis.
struct TipBody {
  double mass = 0.0;     ///< [kg]
  double inertia = 0.0;  ///< about the tip [kg m^2]
};

struct alignas(64) LaneDynamics {
  Lanes M[kLanes]{};   ///< inertia with the body at the tip, full and symmetric
  Lanes bias{};        ///< C(q, v) v + G(q)
  Lanes J[6]{};        ///< rows of the tip's Jacobian, linear over angular, in base axes
  double tip[4][4]{};  ///< base to tip X_0T: three columns of R and the origin, each with a fourth number of zero
  Lanes Jdot_v{};      ///< tip acceleration at zero joint acceleration: linear, 0, angular, 0
};

}  // namespace palpate::arm
