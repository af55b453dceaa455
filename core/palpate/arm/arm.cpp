#include "palpate/arm/arm.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "palpate/arm/serial.hpp"
#include "palpate/types/cholesky.hpp"

namespace palpate::arm {
namespace {

/// True if a rigid body can have these parameters: its pseudo-inertia is positive definite (Wensing, Kim and Slotine
/// 2018).
bool consistent(const Eigen::Matrix<double, 10, 1>& pi) {
  const double trace = 0.5 * (pi[4] + pi[6] + pi[9]);
  double J[4][4] = {{trace - pi[4], -pi[5], -pi[7], pi[1]},
                    {0.0, trace - pi[6], -pi[8], pi[2]},
                    {0.0, 0.0, trace - pi[9], pi[3]},
                    {0.0, 0.0, 0.0, pi[0]}};
  double x[4] = {};
  return solve_positive(J, x);
}

}  // namespace

Arm::Arm(std::unique_ptr<Mechanism> mechanism) : mechanism_(std::move(mechanism)) {
  const Eigen::Index rows = n();
  zero_ = result_ = v_ = spring_.along = JointVector::Zero(rows);
  state_ = {JointMatrix::Zero(rows, rows), zero_, zero_, {}, Jacobian::Zero(6, rows), Vec6::Zero()};
  work_ = state_;
  update(zero_, zero_);
}

Arm Arm::from_urdf(const std::string& xml, const std::string& base_frame, const std::string& tip_frame) {
  return Arm(serial_arm(xml, base_frame, tip_frame));
}

Arm::Arm(const Arm& other)
    : mechanism_(other.mechanism_->clone()),
      spring_(other.spring_),
      along_{},
      identified_(other.identified_),
      regressor_(other.regressor_),
      zero_(other.zero_),
      result_(other.result_),
      v_(other.v_),
      state_(other.state_),
      work_(other.work_) {
  std::copy_n(other.along_, kLanes, along_);
}

Arm& Arm::operator=(const Arm& other) {
  if (this != &other) *this = Arm(other);
  return *this;
}

void Arm::update(const JointVector& q, const JointVector& v) noexcept {
  mechanism_->kinematics(q, state_.X_0T, state_.J);
  v_ = v;
}

const Dynamics& Arm::dynamics(const JointVector& q, const JointVector& v) noexcept {
  mechanism_->dynamics(q, v, state_);
  v_ = v;
  return state_;
}

std::vector<Pose> Arm::link_poses(const JointVector& q) {
  update(q, zero_);
  std::vector<Pose> poses(link_names().size());
  for (std::size_t i = 0; i < poses.size(); ++i) poses[i] = link_pose(static_cast<int>(i));
  return poses;
}

Twist Arm::twist() const noexcept {
  const Vec6 V = state_.J.lazyProduct(v_);
  return {V.head<3>(), V.tail<3>()};
}

const JointVector& Arm::gravity(const JointVector& q) noexcept {
  mechanism_->dynamics(q, zero_, work_);
  return work_.G;
}

JointVector Arm::elastic(const JointVector& q) noexcept {
  if (identified_) return holding(q) - gravity(q);
  if (spring_.torque == 0.0) return zero_;
  return -spring_.torque * std::cos(spring_.along.dot(q)) * spring_.along;
}

void Arm::elastic(const JointVector& q, Lanes& tau) noexcept {
  if (identified_) return pad(elastic(q), tau);
  if (spring_.torque == 0.0) {
    std::fill_n(tau, kLanes, 0.0);
    return;
  }
  double even = 0.0, odd = 0.0;
  for (int k = 0; k < kLanes; k += 2) {
    even += along_[k] * lanes(q)[k];
    odd += along_[k + 1] * lanes(q)[k + 1];
  }
  const double scale = -spring_.torque * std::cos(even + odd);
  for (int k = 0; k < kLanes; ++k) tau[k] = scale * along_[k];
}

JointVector Arm::holding(const JointVector& q) noexcept {
  if (identified_) return identified_->holding(q, gravity_regressor(q));
  return gravity(q) + elastic(q);
}

JointVector Arm::holding(const JointVector& q, const JointVector& G) noexcept {
  if (identified_) return identified_->holding(q, gravity_regressor(q));
  return G + elastic(q);
}

double Arm::elastic_energy(const JointVector& q) noexcept {
  if (identified_) return identified_->energy(q, gravity_regressor(q)) - potential_energy(q);
  return -spring_.torque * std::sin(spring_.along.dot(q));
}

const GravityRegressor& Arm::gravity_regressor(const JointVector& q) noexcept {
  mechanism_->gravity_regressor(q, regressor_);
  return regressor_;
}

void Arm::set_gravity_model(GravityTerms terms, Eigen::VectorXd theta) {
  if (terms.masses && moments().size() == 0) {
    throw std::invalid_argument("this device has no gravity regressor: a gravity model of it cannot have masses");
  }
  identified_.emplace(n(), std::move(terms), std::move(theta));
}

void Arm::set_counterbalance(const Counterbalance& spring) {
  if (spring.along.size() != n() || !spring.along.allFinite() || !std::isfinite(spring.torque)) {
    throw std::runtime_error("a counterbalance needs a finite torque [N m] and " + std::to_string(n()) +
                             " finite numbers along, one per joint; got " + std::to_string(spring.torque) +
                             " N m and " + std::to_string(spring.along.size()) + " numbers");
  }
  spring_ = spring;
  pad(spring.along, along_);
}

const JointVector& Arm::inverse_dynamics(const JointVector& q, const JointVector& v, const JointVector& a) noexcept {
  mechanism_->inverse_dynamics(q, v, a, work_, result_);
  return result_;
}

const JointVector& Arm::bias(const JointVector& q, const JointVector& v) noexcept {
  return inverse_dynamics(q, v, zero_);
}

const JointMatrix& Arm::mass_matrix(const JointVector& q) noexcept {
  mechanism_->dynamics(q, zero_, work_);
  return work_.M;
}

Arm Arm::with_scaled_masses(const JointVector& scale) const {
  if (scale.size() != n() || !(scale.array() > 0.0).all()) {
    throw std::runtime_error("with_scaled_masses needs " + std::to_string(n()) +
                             " factors above zero, one per moving link; got " + std::to_string(scale.size()) +
                             " (1 leaves a link as it is)");
  }
  Arm copy(*this);
  copy.mechanism_->scale_masses(scale);
  return copy;
}

Arm Arm::with_inertial_parameters(const Eigen::VectorXd& pi) const {
  const Eigen::Index size = inertial_parameters().size();
  if (size == 0) throw std::runtime_error("this device is not made of links: it has no inertial parameters");
  if (pi.size() != size || !pi.allFinite()) {
    throw std::runtime_error("pi needs " + std::to_string(size) + " finite numbers, ten per moving link; got " +
                             std::to_string(pi.size()));
  }
  for (Eigen::Index link = 0; 10 * link < size; ++link) {
    if (!consistent(pi.segment<10>(10 * link))) {
      throw std::runtime_error("pi of the link after joint '" + joint_names()[static_cast<std::size_t>(link)] +
                               "' is no body's: its pseudo-inertia is not positive definite");
    }
  }
  Arm copy(*this);
  copy.mechanism_->set_inertial_parameters(pi);
  copy.spring_.torque = 0.0;
  copy.identified_.reset();
  return copy;
}

}  // namespace palpate::arm
