// Inverse kinematics of Arm: damped Newton (Levenberg-Marquardt) steps within the joint limits.
#include <algorithm>
#include <cmath>

#include "palpate/arm/arm.hpp"
#include "palpate/types/cholesky.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::arm {
namespace {

constexpr double kLength = 0.1;         // [m] position error equivalent to one radian
constexpr double kErrorDamping = 0.02;  // damping per squared error (Sugihara 2011: full steps close to the goal)
constexpr double kMaxStep = 0.6;        // largest joint step of one iteration [rad, or 0.1 m]

using Error = Vec6;  // position over kLength, then rotation vector, both in base axes

Error error_to(const Pose& goal, const Pose& tip) noexcept {
  Error e;
  e << (goal.p - tip.p) / kLength, rotation_vector(goal.R * tip.R.transpose());
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
    Error e = error_to(X_0T_goal, tip());
    if (!orients()) e.tail<3>().setZero();
    result.position_error = e.head<3>().norm() * kLength;
    result.orientation_error = e.tail<3>().norm();
    result.converged = result.position_error <= options.position_tolerance &&
                       result.orientation_error <= options.orientation_tolerance;
    if (result.converged || result.iterations >= options.max_iterations || !e.allFinite()) return result;
    Jacobian J = jacobian();
    J.topRows<3>() /= kLength;
    if (!orients()) J.bottomRows<3>().setZero();
    result.damping = options.damping * options.damping + kErrorDamping * e.squaredNorm();
    JointVector dq = bounded_step(J, e, result.damping, q, q_min(), q_max());
    const double largest = dq.cwiseAbs().maxCoeff();
    if (largest > kMaxStep) dq *= kMaxStep / largest;
    q = (q + dq).cwiseMax(q_min()).cwiseMin(q_max()).eval();
  }
}

}  // namespace palpate::arm
