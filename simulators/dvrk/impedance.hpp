// The arms' own impedance (servo_ci): springs and dampers along the axes of two frames, with gains of their own on
// either side, so that one side may be free. Same law as the real controller's (sawControllers
// osaCartesianImpedanceController): force = p err + d vel + bias with NEGATIVE gains, err less its deadband.
#pragma once

#include "dvrk/messages.hpp"

namespace palpate::dvrk {

/// Wrench on the handle about its tip in base axes, of a tip at X moving with V, both in the base frame.
[[nodiscard]] Wrench impedance_wrench(const Impedance& goal, const Pose& X, const Twist& V) noexcept;

}  // namespace palpate::dvrk
