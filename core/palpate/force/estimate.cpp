#include "palpate/force/estimate.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace palpate::force {
namespace {

constexpr double kStep = 1e-4;     // [s] step of the central difference for dM/dt v; its error is of second order
constexpr double kGap = 0.1;       // [s] longest interval between two states that the observer integrates over
constexpr double kDamping = 1e-6;  // regularisation of the least squares, whose weighted lever arms are about 1
constexpr double kPlausibleFactor = 10.0;  // multiple of a drive's limit beyond which a measurement is implausible

JointVector sized(const JointVector& values, Eigen::Index n, const char* name, bool positive) {
  if (values.size() == 0) return JointVector::Zero(n);
  if (values.size() != n || !values.allFinite() || (positive && values.minCoeff() < 0.0)) {
    throw std::invalid_argument("estimate " + std::string(name) + " needs " + std::to_string(n) +
                                " finite entries, one per joint" + (positive ? ", none below zero" : "") + "; got " +
                                std::to_string(values.size()));
  }
  return values;
}

arm::Arm with_links(const arm::Arm& model, const Eigen::VectorXd& links) {
  return links.size() == 0 ? model : model.with_inertial_parameters(links);
}

EstimateOptions checked(EstimateOptions o, Eigen::Index n) {
  o.rotor_inertia = sized(o.rotor_inertia, n, "rotor_inertia", true);
  o.coulomb = sized(o.coulomb, n, "coulomb", true);
  o.viscous = sized(o.viscous, n, "viscous", true);
  o.offset = sized(o.offset, n, "offset", false);
  o.spring = sized(o.spring, n, "spring", false);
  if (!(o.dead_band >= 0.0 && o.slip_speed > 0.0)) {
    throw std::invalid_argument("estimate dead_band must be at least 0 N and slip_speed above 0; got " +
                                std::to_string(o.dead_band) + " N and " + std::to_string(o.slip_speed));
  }
  return o;
}

}  // namespace

MomentumObserver::MomentumObserver(arm::Arm model, JointMatrix drive_inertia, double bandwidth)
    : model_(std::move(model)), drive_inertia_(std::move(drive_inertia)), k_(2.0 * std::numbers::pi * bandwidth) {
  const Eigen::Index n = model_.n();
  if (drive_inertia_.rows() != n || drive_inertia_.cols() != n) {
    throw std::invalid_argument("drive_inertia must have shape (" + std::to_string(n) + ", " + std::to_string(n) +
                                "); got (" + std::to_string(drive_inertia_.rows()) + ", " +
                                std::to_string(drive_inertia_.cols()) + ")");
  }
  if (!(bandwidth > 0.0 && bandwidth <= 1000.0)) {
    throw std::invalid_argument("the observer's bandwidth must lie between 0 and 1000 Hz, for example 20; got " +
                                std::to_string(bandwidth) + " Hz");
  }
  r_ = integral_ = p_dot_ = JointVector::Zero(n);
}

JointVector MomentumObserver::momentum(const JointVector& q, const JointVector& v) noexcept {
  return model_.mass_matrix(q) * v;
}

const JointVector& MomentumObserver::step(const JointVector& q, const JointVector& v, const JointVector& tau,
                                          double dt) noexcept {
  const JointVector p = momentum(q, v) + drive_inertia_ * v;
  const JointVector dM_v = (momentum(q + kStep * v, v) - momentum(q - kStep * v, v)) / (2.0 * kStep);
  const JointVector p_dot = tau + dM_v - model_.bias(q, v) - model_.elastic(q);
  if (!started_) {
    started_ = true;
    r_.setZero();
    integral_ = p;
  } else {  // implicit step: r at the end of the step appears on both sides
    integral_ += 0.5 * dt * (p_dot_ + p_dot);
    r_ = k_ / (1.0 + k_ * dt) * (p - integral_);
    integral_ += dt * r_;
  }
  p_dot_ = p_dot;
  if (!r_.allFinite() || !p_dot_.allFinite()) {
    reset();
    r_.setZero();
  }
  return r_;
}

Estimate::Estimate(const arm::Arm& model, EstimateOptions options)
    : options_(checked(std::move(options), model.n())),
      observer_(with_links(model, options_.links), options_.rotor_inertia.asDiagonal().toDenseMatrix(),
                options_.bandwidth),
      weight_(model.tau_max().cwiseInverse()),
      slip_(options_.slip_speed * model.v_max()),
      tau_bound_(kPlausibleFactor * model.tau_max()),
      v_bound_(kPlausibleFactor * model.v_max()) {
  if (!weight_.allFinite() || !(slip_.array() > 0.0).all()) {
    throw std::invalid_argument(
        "estimating a force needs the follower's effort and velocity limits: give them in its URDF");
  }
}

bool Estimate::is_plausible(const FollowerState& s) const noexcept {  // a comparison with NaN is false: NaN is rejected
  return s.tau.size() == tau_bound_.size() && s.v.size() == v_bound_.size() &&
         (s.tau.array().abs() <= tau_bound_.array()).all() && (s.v.array().abs() <= v_bound_.array()).all();
}

const Vec3& Estimate::step(const FollowerState& s) noexcept {
  F_T_B_.setZero();
  arm::Arm& arm = observer_.model();
  if (!is_plausible(s)) {
    observer_.reset();
    return F_T_B_;
  }
  const double dt = s.t - t_;
  t_ = s.t;
  if (!(dt >= 0.0 && dt <= kGap)) observer_.reset();
  JointVector tau = s.tau - options_.viscous.cwiseProduct(s.v) - options_.offset - options_.spring.cwiseProduct(s.q);
  for (Eigen::Index k = 0; k < tau.size(); ++k) tau[k] -= options_.coulomb[k] * std::tanh(s.v[k] / slip_[k]);
  const JointVector& r = observer_.step(s.q, s.v, tau, dt);

  arm.update(s.q, s.v);
  Mat3 N = kDamping * Mat3::Identity();
  Vec3 b = Vec3::Zero();
  for (Eigen::Index k = 0; k < r.size(); ++k) {
    const Vec3 lever = weight_[k] * arm.jacobian().col(k).head<3>();
    N += lever * lever.transpose();
    b += lever * (weight_[k] * r[k]);
  }
  const Vec3 F = N.llt().solve(b);
  const double size = F.norm();
  if (size > options_.dead_band) F_T_B_ = (1.0 - options_.dead_band / size) * F;
  return F_T_B_;
}

}  // namespace palpate::force
