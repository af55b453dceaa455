// Inverse kinematics of Arm: damped Newton (Levenberg-Marquardt) steps within the joint limits.
#include <algorithm>
#include <cmath>

#include "palpate/arm/arm.hpp"
#include "palpate/types/cholesky.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::arm {
namespace {

constexpr double kAtLimit = 1e-9;       // [rad, m] a joint that is nearer to its limit is held there
constexpr double kBend = 1e-6;          // [rad, m] step of the differences of a gradient
constexpr double kLeastPivot = 1e-9;    // [-] added to the curvature: motions that do not move the tip are free
constexpr double kErrorDamping = 0.02;  // damping per squared error (Sugihara 2011: full steps close to the goal)
constexpr double kMaxStep = 0.6;        // largest joint step of one iteration [rad, or 0.1 m]
constexpr double kArrived = 1e-12;      // [rad, m] a smaller step of the joints ends the search

using Error = Vec6;  // position over IkOptions::length, then rotation vector, both in base axes

Error error_to(const Pose& goal, const Pose& tip, double length) noexcept {
  Error e;
  e << (goal.p - tip.p) / length, rotation_vector(goal.R * tip.R.transpose());
  return e;
}

/// The shortest step of the free joints, dq = J^T (J J^T + lambda I)^-1 e. Zero if rounding has made the matrix
/// singular.
JointVector least_step(const Jacobian& J, const Vec6& e, double lambda) noexcept {
  const Eigen::Index n = J.cols();
  double A[6][6] = {}, y[6];
  for (Eigen::Index k = 0; k < n; ++k) {
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) A[i][j] += J(i, k) * J(j, k);
    }
  }
  for (int i = 0; i < 6; ++i) {
    A[i][i] += lambda;
    y[i] = e[i];
  }
  JointVector dq = JointVector::Zero(n);
  if (!solve_positive(A, y)) return dq;
  for (Eigen::Index k = 0; k < n; ++k) {
    for (int i = 0; i < 6; ++i) dq[k] += J(i, k) * y[i];
  }
  return dq;
}

/// Step that reduces e within the joint limits. The joint that would exceed its limit most is stopped there first, and
/// the others take over its share.
JointVector bounded_step(Jacobian J, Vec6 e, double lambda, const JointVector& q, const JointVector& q_min,
                         const JointVector& q_max) noexcept {
  JointVector stopped = JointVector::Zero(q.size());
  for (Eigen::Index pass = 0;; ++pass) {
    const JointVector dq = least_step(J, e, lambda);
    const JointVector bounded = (q + dq).cwiseMax(q_min).cwiseMin(q_max) - q;
    Eigen::Index worst = 0;
    const double excess = (bounded - dq).cwiseAbs().maxCoeff(&worst);
    if (excess < 1e-15 || pass + 1 == q.size()) return stopped + bounded;
    stopped[worst] = bounded[worst];
    e -= J.col(worst) * bounded[worst];
    J.col(worst).setZero();
  }
}

}  // namespace

IkResult Arm::ik(const Pose& X_0T_goal, JointVector& q, const IkOptions& options) noexcept {
  IkResult result;
  const JointVector rest = JointVector::Zero(n());
  mechanism_->closed_form(X_0T_goal.p, q);  // the loop below checks the result and refines it
  q = q.cwiseMax(q_min()).cwiseMin(q_max()).eval();
  for (;; ++result.iterations) {
    update(q, rest);
    Error e = error_to(X_0T_goal, tip(), options.length);
    if (!orients()) e.tail<3>().setZero();
    result.position_error = e.head<3>().norm() * options.length;
    result.orientation_error = e.tail<3>().norm();
    result.converged = result.position_error <= options.position_tolerance &&
                       result.orientation_error <= options.orientation_tolerance;
    if (result.converged || result.iterations >= options.max_iterations || !e.allFinite()) return result;
    Jacobian J = jacobian();
    J.topRows<3>() /= options.length;
    if (!orients()) J.bottomRows<3>().setZero();
    result.damping = options.damping * options.damping + kErrorDamping * e.squaredNorm();
    JointVector dq = bounded_step(J, e, result.damping, q, q_min(), q_max());
    const double largest = dq.cwiseAbs().maxCoeff();
    if (largest > kMaxStep) dq *= kMaxStep / largest;
    q = (q + dq).cwiseMax(q_min()).cwiseMin(q_max()).eval();
    result.step = std::min(largest, kMaxStep);
    if (largest < kArrived) return result;
  }
}

// The joints q minimise f = 1/2 |error|^2 over those that are not at a limit. With the gradient g of f they satisfy
// g(q, goal) = 0, so dq = -(dg/dq)^-1 dg/dgoal d goal, and the tip moves by J dq.
Mat6 Arm::nearest_derivative(const Pose& X_0T_goal, const JointVector& q, double length) noexcept {
  const JointVector rest = JointVector::Zero(n());
  const auto free = [&](Eigen::Index k) { return q[k] - q_min()[k] > kAtLimit && q_max()[k] - q[k] > kAtLimit; };
  const auto gradient = [&](const JointVector& at) -> JointVector {
    update(at, rest);
    Error e = error_to(X_0T_goal, tip(), length);
    e.head<3>() /= length;
    if (!orients()) e.tail<3>().setZero();
    return -jacobian().transpose() * e;
  };
  double A[kMaxJoints][kMaxJoints] = {}, x[kMaxJoints];
  for (Eigen::Index k = 0; k < kMaxJoints; ++k) {
    if (k >= n() || !free(k)) {
      A[k][k] = 1.0;
      continue;
    }
    const JointVector step = kBend * JointVector::Unit(n(), k);
    const JointVector bend = (gradient(q + step) - gradient(q - step)) / (2.0 * kBend);
    for (Eigen::Index i = 0; i <= k; ++i) A[i][k] = free(i) ? bend[i] : 0.0;
    A[k][k] += kLeastPivot;
  }
  update(q, rest);
  Mat6 by_goal = Mat6::Zero();
  by_goal.topLeftCorner<3, 3>().diagonal().setConstant(1.0 / (length * length));
  if (orients())
    by_goal.bottomRightCorner<3, 3>() = rotation_vector_derivative(rotation_vector(X_0T_goal.R * tip().R.transpose()));
  Mat6 out = Mat6::Zero();
  for (int c = 0; c < 6; ++c) {
    double solved[kMaxJoints][kMaxJoints];
    std::copy(&A[0][0], &A[0][0] + kMaxJoints * kMaxJoints, &solved[0][0]);
    for (Eigen::Index k = 0; k < kMaxJoints; ++k)
      x[k] = k < n() && free(k) ? jacobian().col(k).dot(by_goal.col(c)) : 0.0;
    if (!solve_positive(solved, x)) return Mat6::Zero();
    for (Eigen::Index k = 0; k < n(); ++k) out.col(c) += x[k] * jacobian().col(k);
  }
  return out.allFinite() ? out : Mat6::Zero();
}

}  // namespace palpate::arm
