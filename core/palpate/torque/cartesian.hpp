// Dynamics of the arm in task space, at the handle (Eqs 2-5).
#pragma once

#include "palpate/arm/arm.hpp"

namespace palpate::torque {

/// Task-space dynamics Lambda a + Gamma v + eta = F - F_e for m task axes (3: position of the handle; 6: position and
/// orientation):
///
///   Lambda = (J M^-1 J^T)^-1        Gamma v = Lambda (J M^-1 C v - dJ/dt v)        eta = Lambda J M^-1 G
///
/// For an invertible J these are Eqs 3-5. The Jacobian of a redundant arm (n > m) has no inverse; M^-1 J^T Lambda takes
/// the place of J^-1. All quantities are expressed in the arm's base frame.
template <int m>
struct Cartesian {
  Eigen::Matrix<double, m, m> Lambda = Eigen::Matrix<double, m, m>::Identity();  ///< inertia at the handle [kg, kg m^2]
  Eigen::Matrix<double, m, 1> Gamma_v = Eigen::Matrix<double, m, 1>::Zero();     ///< Coriolis wrench [N, N m]
  Eigen::Matrix<double, m, 1> eta = Eigen::Matrix<double, m, 1>::Zero();         ///< gravity wrench [N, N m]
  bool singular = false;  ///< true if an eigenvalue of Lambda exceeded the bound and was reduced to it
};

/// Task-space dynamics of the first `joints` joints; the other joints are held. d: dynamics of the arm at its present
/// state. rotor: rotor inertia, added to the diagonal of M (n,) [kg m^2, kg]. max_inertia: upper bound of Lambda's
/// eigenvalues [kg]; rotational inertia counts as a mass at a lever arm of 0.1 m. The arm can hardly move in a
/// direction with a larger inertia, so the eigenvalue is reduced to the bound, as a damped inverse does, and `singular`
/// is set.
template <int m>
[[nodiscard]] Cartesian<m> cartesian(const arm::Dynamics& d, const JointVector& rotor, Eigen::Index joints,
                                     double max_inertia) noexcept;

}  // namespace palpate::torque
