// A delta robot: three driven arms, three rods (each a parallelogram), and a platform that only translates.
#pragma once

#include "palpate/arm/mechanism.hpp"

namespace palpate::arm {

/// Base frame: the three hips lie on a circle in the plane z = 0, the platform hangs below (z < 0). Arm i stands at the
/// azimuth i 120 degrees, u_i = (cos, sin, 0); q_i is its angle below that plane. With a = base_radius -
/// platform_radius, its elbow, moved by the platform's radius towards the axis, and its rod, are
///
///   e_i = (a + upper cos q_i) u_i - upper sin q_i z         s_i = p - e_i,   |s_i| = rod
///
/// Forward kinematics: the lower of the two points at distance `rod` from e_1, e_2, e_3. Inverse kinematics: a
/// quadratic equation for each arm, solved with the elbows outwards. With b_i = de_i/dq_i, S = [s_i^T] and D = diag(s_i
/// . b_i), differentiating |s_i|^2 gives S p' = D q', J = S^-1 D.
///
/// Dynamics (Codourey 1998): each rod is represented by two point masses, half of its mass at the elbow and half at the
/// platform. Mass and centre of mass are exact, and so is gravity; only the rotational inertia of the rods is
/// approximate.
///
///   M = I 1 + m_p J^T J,  I = (upper_mass / 3 + rod_mass / 2) upper^2,  m_p = platform_mass + 3 rod_mass / 2
///
/// The model is a Lagrangian system: energy is conserved and M' - 2C is skew-symmetric.
///
/// Parameters: base_radius, platform_radius, upper, rod [m]; upper_mass, rod_mass (the pair of one arm),
/// platform_mass [kg]; torque_max [N m]; optional speed_max [rad/s], q_min, q_max [rad].
[[nodiscard]] std::unique_ptr<Mechanism> make_delta(const Parameters& parameters);

}  // namespace palpate::arm
