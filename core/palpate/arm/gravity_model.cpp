#include "palpate/arm/gravity_model.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace palpate::arm {
namespace {

void check(const Field& field, Eigen::Index joints) {
  const auto d = static_cast<Eigen::Index>(field.joints.size());
  for (const int joint : field.joints) {
    if (joint < 0 || joint >= joints) {
      throw std::invalid_argument("a field of joint " + std::to_string(joint) + ": the arm's joints are 0 to " +
                                  std::to_string(joints - 1));
    }
  }
  const bool sized = d > 0 && field.centres.cols() == d && field.length.size() == d;
  if (!sized || !field.centres.allFinite() || !(field.length.array() > 0.0).all()) {
    throw std::invalid_argument("a field of " + std::to_string(d) + " joints needs finite centres (c, " +
                                std::to_string(d) + ") and " + std::to_string(d) + " lengths above zero; got (" +
                                std::to_string(field.centres.rows()) + ", " + std::to_string(field.centres.cols()) +
                                ") and " + std::to_string(field.length.size()));
  }
}

}  // namespace

Eigen::Index GravityTerms::columns(Eigen::Index joints) const noexcept {
  Eigen::Index m = (masses ? 4 * joints : 0) + (degree + 1) * joints;
  for (const Field& field : fields) m += field.centres.rows();
  return m;
}

GravityModel::GravityModel(Eigen::Index joints, GravityTerms terms, Eigen::VectorXd theta)
    : terms_(std::move(terms)), theta_(std::move(theta)) {
  for (const Field& field : terms_.fields) check(field, joints);
  const Eigen::Index m = terms_.columns(joints);
  if (terms_.degree < -1 || theta_.size() != m || !theta_.allFinite()) {
    throw std::invalid_argument("a gravity model of degree " + std::to_string(terms_.degree) + " needs " +
                                std::to_string(m) + " finite parameters; got " + std::to_string(theta_.size()));
  }
  Phi_ = Eigen::MatrixXd::Zero(joints, m);
  phi_ = Eigen::RowVectorXd::Zero(m);
  tau_ = JointVector::Zero(joints);
}

const JointVector& GravityModel::holding(const JointVector& q, const GravityRegressor& masses) noexcept {
  columns(q, masses);
  tau_.noalias() = Phi_ * theta_;
  return tau_;
}

double GravityModel::energy(const JointVector& q, const GravityRegressor& masses) noexcept {
  columns(q, masses);
  return phi_.dot(theta_);
}

const Eigen::MatrixXd& GravityModel::columns(const JointVector& q, const GravityRegressor& masses) noexcept {
  Eigen::Index m = 0;
  if (terms_.masses) {
    m = masses.Y.cols();
    Phi_.leftCols(m) = masses.Y;
    phi_.leftCols(m) = masses.P;
  }
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    double power = 1.0;
    for (int k = 0; k <= terms_.degree; ++k, ++m, power *= q[i]) {
      Phi_(i, m) = power;
      phi_[m] = power * q[i] / (k + 1);
    }
  }
  for (const Field& field : terms_.fields) {
    const auto d = static_cast<Eigen::Index>(field.joints.size());
    for (Eigen::Index c = 0; c < field.centres.rows(); ++c, ++m) {
      double squares = 0.0;
      for (Eigen::Index k = 0; k < d; ++k) {
        const double x = (q[field.joints[static_cast<std::size_t>(k)]] - field.centres(c, k)) / field.length[k];
        squares += x * x;
      }
      phi_[m] = std::exp(-0.5 * squares);
      for (Eigen::Index k = 0; k < d; ++k) {
        const int joint = field.joints[static_cast<std::size_t>(k)];
        Phi_(joint, m) = -phi_[m] * (q[joint] - field.centres(c, k)) / (field.length[k] * field.length[k]);
      }
    }
  }
  return Phi_;
}

}  // namespace palpate::arm
