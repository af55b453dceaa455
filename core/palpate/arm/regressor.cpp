#include "palpate/arm/regressor.hpp"

#include <pinocchio/algorithm/regressor.hpp>

namespace palpate::arm {

Eigen::MatrixXd torque_regressor(const pinocchio::Model& model, pinocchio::Data& data, const Eigen::VectorXd& q,
                                 const Eigen::VectorXd& v, const Eigen::VectorXd& a) {
  return pinocchio::computeJointTorqueRegressor(model, data, q, v, a);
}

}  // namespace palpate::arm
