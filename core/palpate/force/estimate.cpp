#include "palpate/force/estimate.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "palpate/types/cholesky.hpp"

// Joint vectors are combined in plain loops: each Eigen expression of several terms takes half a second to compile.
namespace palpate::force {
namespace {

constexpr double kStep = 1e-4;     // [s] step of the central difference for dM/dt v; its error is of second order
constexpr double kGap = 0.1;       // [s] longest interval between two states that the observer integrates over
constexpr double kDamping = 1e-6;  // regularisation of the least squares, whose weighted lever arms are about 1
constexpr double kPlausibleFactor = 10.0;  // multiple of a drive's limit beyond which a measurement is implausible

bool all_finite(const JointVector& x) noexcept {
  return std::all_of(x.data(), x.data() + x.size(), [](double value) { return std::isfinite(value); });
}

bool all_positive(const JointVector& x) noexcept {
  return std::all_of(x.data(), x.data() + x.size(), [](double value) { return value > 0.0; });
}

/// True if |x_k| <= bound_k for all joints: a comparison with NaN is false.
bool is_within(const JointVector& x, const JointVector& bound) noexcept {
  return x.size() == bound.size() && std::equal(x.data(), x.data() + x.size(), bound.data(),
                                                [](double value, double most) { return std::abs(value) <= most; });
}

/// q + step v (n,).
JointVector moved(const JointVector& q, const JointVector& v, double step) noexcept {
  JointVector out = q;
  for (Eigen::Index k = 0; k < out.size(); ++k) out[k] += step * v[k];
  return out;
}

/// M v (n,).
JointVector product(const JointMatrix& M, const JointVector& v) noexcept {
  JointVector out = JointVector::Zero(v.size());
  for (Eigen::Index j = 0; j < M.cols(); ++j) {
    for (Eigen::Index i = 0; i < M.rows(); ++i) out[i] += M(i, j) * v[j];
  }
  return out;
}

JointMatrix diagonal(const JointVector& values) {
  JointMatrix M = JointMatrix::Zero(values.size(), values.size());
  for (Eigen::Index k = 0; k < values.size(); ++k) M(k, k) = values[k];
  return M;
}

JointVector scaled(double factor, JointVector values) noexcept {
  for (double& value : values) value *= factor;
  return values;
}

JointVector reciprocal(JointVector values) noexcept {
  for (double& value : values) value = 1.0 / value;
  return values;
}

JointVector sized(const JointVector& values, Eigen::Index n, const char* name, bool positive) {
  if (values.size() == 0) return JointVector::Zero(n);
  const bool negative = std::any_of(values.data(), values.data() + values.size(), [](double x) { return x < 0.0; });
  if (values.size() != n || !all_finite(values) || (positive && negative)) {
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
  return product(model_.mass_matrix(q), v);
}

const JointVector& MomentumObserver::step(const JointVector& q, const JointVector& v, const JointVector& tau,
                                          double dt) noexcept {
  const JointVector p_links = momentum(q, v), p_drives = product(drive_inertia_, v);
  const JointVector p_ahead = momentum(moved(q, v, kStep), v), p_behind = momentum(moved(q, v, -kStep), v);
  const JointVector bias = model_.bias(q, v), elastic = model_.elastic(q);
  for (Eigen::Index k = 0; k < r_.size(); ++k) {
    const double p = p_links[k] + p_drives[k], dM_v = (p_ahead[k] - p_behind[k]) / (2.0 * kStep);
    const double p_dot = tau[k] + dM_v - bias[k] - elastic[k];
    if (started_) {  // implicit step: r at the end of the step appears on both sides
      integral_[k] += 0.5 * dt * (p_dot_[k] + p_dot);
      r_[k] = k_ / (1.0 + k_ * dt) * (p - integral_[k]);
      integral_[k] += dt * r_[k];
    } else {
      r_[k] = 0.0;
      integral_[k] = p;
    }
    p_dot_[k] = p_dot;
  }
  started_ = true;
  if (!all_finite(r_) || !all_finite(p_dot_)) {
    reset();
    r_.setZero();
  }
  return r_;
}

Estimate::Estimate(const arm::Arm& model, EstimateOptions options)
    : options_(checked(std::move(options), model.n())),
      observer_(with_links(model, options_.links), diagonal(options_.rotor_inertia), options_.bandwidth),
      weight_(reciprocal(model.tau_max())),
      slip_(scaled(options_.slip_speed, model.v_max())),
      tau_bound_(scaled(kPlausibleFactor, model.tau_max())),
      v_bound_(scaled(kPlausibleFactor, model.v_max())) {
  if (!all_finite(weight_) || !all_positive(slip_)) {
    throw std::invalid_argument(
        "estimating a force needs the follower's effort and velocity limits: give them in its URDF");
  }
}

bool Estimate::is_plausible(const FollowerState& s) const noexcept {
  return is_within(s.tau, tau_bound_) && is_within(s.v, v_bound_);
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
  JointVector tau = s.tau;
  for (Eigen::Index k = 0; k < tau.size(); ++k) {
    const double coulomb = options_.coulomb[k] * std::tanh(s.v[k] / slip_[k]);
    tau[k] -= options_.viscous[k] * s.v[k] + options_.offset[k] + options_.spring[k] * s.q[k] + coulomb;
  }
  const JointVector& r = observer_.step(s.q, s.v, tau, dt);

  arm.update(s.q, s.v);
  double N[3][3] = {{kDamping, 0.0, 0.0}, {0.0, kDamping, 0.0}, {0.0, 0.0, kDamping}}, b[3] = {};
  for (Eigen::Index k = 0; k < r.size(); ++k) {
    const double* J_k = arm.jacobian().data() + 6 * k;  // the column of joint k, of which the linear rows come first
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) N[i][j] += weight_[k] * weight_[k] * J_k[i] * J_k[j];
      b[i] += weight_[k] * weight_[k] * J_k[i] * r[k];
    }
  }
  solve_positive(N, b);
  const Vec3 F(b[0], b[1], b[2]);
  const double size = F.norm();
  if (size > options_.dead_band) F_T_B_ = (1.0 - options_.dead_band / size) * F;
  return F_T_B_;
}

}  // namespace palpate::force
