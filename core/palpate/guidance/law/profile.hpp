// A force along the constraint's gradient, shared by the laws. The damping never jumps and never reverses the force.
#pragma once

#include <algorithm>

#include "palpate/guidance/fixture.hpp"

namespace palpate::guidance {

/// Violation over which the damping rises from zero to B, so that a moving hand feels no step at the border [m], [rad].
inline constexpr double kDampingRamp = 2e-4, kDampingRampRotational = 5e-3;

/// Force along c.gradient: f - B r s, limited to 0..most, where r is the rate of the gap and s = min(f / (K
/// kDampingRamp), 1). For a rotational constraint the translational part is f without damping. f: spring force or
/// moment [N, N m]; K, B: stiffness and damping in the unit of the constraint, translational or rotational; most:
/// largest force or moment.
inline ConstraintForce force_along(const Constraint& c, const Twist& V_WT, double f, double K, double B,
                                   double most) noexcept {
  ConstraintForce out;
  if (f <= 0.0) return out;
  const double in = K * (c.rotational ? kDampingRampRotational : kDampingRamp);
  const double damping = -B * std::min(f / in, 1.0) * c.rate(V_WT);
  const double sum = std::clamp(f + damping, 0.0, most);
  out.F = {(c.rotational ? f : sum) * c.gradient.f, sum * c.gradient.t};
  return out;
}

}  // namespace palpate::guidance
