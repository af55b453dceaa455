// Dynamics of a serial arm, linear in its links' inertial parameters. In a file of its own: Pinocchio's template takes
// half a minute to compile.
#pragma once

#include <pinocchio/multibody/data.hpp>
#include <pinocchio/multibody/model.hpp>

namespace palpate::arm {

/// M a + C v + G = Y pi with pi = (m, m c_x, m c_y, m c_z, I_xx, I_xy, I_yy, I_xz, I_yz, I_zz) of each link, about and
/// in the axes of its joint's frame (Pinocchio's order). Not for the cycle: it allocates.
[[nodiscard]] Eigen::MatrixXd torque_regressor(const pinocchio::Model& model, pinocchio::Data& data,
                                               const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                                               const Eigen::VectorXd& a);

}  // namespace palpate::arm
