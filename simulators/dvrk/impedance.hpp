// Cartesian impedance control of an arm (servo_ci): springs and dampers along the axes of two frames, with separate
// gains for positive and negative errors. The law is that of the real controller (sawControllers
// osaCartesianImpedanceController): force = p err + d vel + bias with NEGATIVE gains; err is reduced by the deadband.
#pragma once

#include "dvrk/messages.hpp"

namespace palpate::dvrk {

/// Wrench on the tip, about the tip in base axes, for a tip at X that moves with V, both in the base frame.
[[nodiscard]] Wrench impedance_wrench(const Impedance& goal, const Pose& X, const Twist& V) noexcept;

}  // namespace palpate::dvrk
