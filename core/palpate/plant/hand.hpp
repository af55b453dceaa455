// A hand as a mechanical impedance: a mass on the handle, with a spring and a damper to the intended path.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate::plant {

struct HandOptions {
  double mass = 0.15;                 ///< moves with the handle [kg]
  double damping = 10.0;              ///< to the intended path [N s/m]
  double stiffness = 300.0;           ///< to the intended path [N/m]
  double inertia = 2e-4;              ///< rotational, moves with the handle [kg m^2]
  double rotational_damping = 0.03;   ///< [N m s/rad]
  double rotational_stiffness = 1.5;  ///< [N m/rad]
  double grip_force_max = 15.0;       ///< force above which the hand slips [N]
};

}  // namespace palpate::plant
