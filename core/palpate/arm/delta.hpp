// A delta: three driven arms, three rods (each a parallelogram), a platform that translates and never turns.
#pragma once

#include "palpate/arm/mechanism.hpp"

namespace palpate::arm {

/// Base frame: the three hips lie on a circle in the plane z = 0, the platform hangs below (z < 0). Arm i stands at the
/// azimuth i 120 degrees, u_i = (cos, sin, 0); q_i is its angle below that plane. With a = base_radius -
/// platform_radius, its elbow, moved by the platform's radius towards the axis, and its rod, are
///
///   e_i = (a + upper cos q_i) u_i - upper sin q_i z         s_i = p - e_i,   |s_i| = rod
///
/// FK is the lower of the two points at distance `rod` from e_1, e_2, e_3; IK a quadratic for each arm (elbows out).
/// With b_i = de_i/dq_i, S = [s_i^T] and D = diag(s_i . b_i), differentiating |s_i|^2 gives S p' = D q', J = S^-1 D.
///
/// Dynamics, reduced as usual (Codourey 1998): each rod is two point masses, half at the elbow, half at the platform.
/// Mass and centre are exact then, so gravity is; only the rods' own rotational inertia is approximate.
///
///   M = I 1 + m_p J^T J,  I = (upper_mass / 3 + rod_mass / 2) upper^2,  m_p = platform_mass + 3 rod_mass / 2
///
/// It is a Lagrangian system: energy is conserved, M' - 2C is skew.
///
/// Parameters: base_radius, platform_radius, upper, rod [m]; upper_mass, rod_mass (the pair of one arm),
/// platform_mass [kg]; torque_max [N m]; optional speed_max [rad/s], q_min, q_max [rad].
[[nodiscard]] std::unique_ptr<Mechanism> make_delta(const Parameters& parameters);

}  // namespace palpate::arm
