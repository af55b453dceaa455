// The arm's dynamics seen at the handle (Eqs 2-5).
#pragma once

#include "palpate/arm/arm.hpp"

namespace palpate::torque {

/// Lambda a + Gamma v + eta = F - F_e, for the m task axes (3: the handle's place; 6: its turning as well), with
///
///   Lambda = (J M^-1 J^T)^-1        Gamma v = Lambda (J M^-1 C v - J' v)        eta = Lambda J M^-1 G
///
/// Where J has an inverse these are Eqs 3-5; a redundant arm (n > m) has no J^-1, and M^-1 J^T Lambda takes its place.
template <int m>
struct Cartesian {
  Eigen::Matrix<double, m, m> Lambda = Eigen::Matrix<double, m, m>::Identity();  ///< [kg, kg m^2]
  Eigen::Matrix<double, m, 1> Gamma_v = Eigen::Matrix<double, m, 1>::Zero();     ///< [N, N m]
  Eigen::Matrix<double, m, 1> eta = Eigen::Matrix<double, m, 1>::Zero();         ///< [N, N m]
  bool singular = false;  ///< a direction weighed more than the heaviest that is believed, and was damped
};

/// Of the first `joints` joints, the others held. rotor: added to the diagonal of M (n,).
/// A direction heavier than `heaviest` [kg] (rotation: times 0.1 m squared) is one in which the arm can hardly move:
/// Lambda's eigenvalue is cut there, as a damped inverse does, and `singular` says so.
template <int m>
[[nodiscard]] Cartesian<m> cartesian(const arm::Dynamics& d, const JointVector& rotor, Eigen::Index joints,
                                     double heaviest) noexcept;

}  // namespace palpate::torque
