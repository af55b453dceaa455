// Holding torque of an arm as identified from recordings: linear in its parameters, and the gradient of a potential.
#pragma once

#include <vector>

#include "palpate/arm/mechanism.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::arm {

/// Cables and springs as a smooth potential over some joints:  P = sum_c w_c exp(-|(q_J - z_c) / l|^2 / 2).
struct Field {
  std::vector<int> joints;  ///< indices J of the joints, from zero (d)
  Eigen::MatrixXd centres;  ///< z, (c, d) [rad, m]
  Eigen::VectorXd length;   ///< l, (d) [rad, m]
};

/// Columns of a model, in this order: first moments of the links, powers of each joint, fields.
struct GravityTerms {
  bool masses = true;         ///< Y(q), 4 columns per link (Eqs 10-12)
  int degree = -1;            ///< degree of a polynomial per joint, tau_i = sum_k a_ik q_i^k; -1: no polynomial
  std::vector<Field> fields;  ///< one column per centre

  [[nodiscard]] Eigen::Index columns(Eigen::Index joints) const noexcept;
};

/// tau = Phi(q) theta with Phi = dphi/dq. Each column is the gradient of a potential, so that no closed motion can draw
/// energy from the rendered torque.
class GravityModel {
 public:
  /// Throws std::invalid_argument naming the term and the shape it should have.
  GravityModel(Eigen::Index joints, GravityTerms terms, Eigen::VectorXd theta);

  /// Torque that holds the arm at q [N m]; `masses` is the regressor there. Allocation free.
  const JointVector& holding(const JointVector& q, const GravityRegressor& masses) noexcept;
  /// Potential of the holding torque [J].
  double energy(const JointVector& q, const GravityRegressor& masses) noexcept;
  /// Phi (n, m) at q.
  const Eigen::MatrixXd& columns(const JointVector& q, const GravityRegressor& masses) noexcept;

  [[nodiscard]] const GravityTerms& terms() const noexcept { return terms_; }
  [[nodiscard]] const Eigen::VectorXd& theta() const noexcept { return theta_; }

 private:
  GravityTerms terms_;
  Eigen::VectorXd theta_;
  Eigen::MatrixXd Phi_;
  Eigen::RowVectorXd phi_;
  JointVector tau_;
};

}  // namespace palpate::arm
