#include "dvrk/inverse.hpp"

#include <cmath>
#include <numbers>

#include "palpate/types/ldlt.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::dvrk {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr Eigen::Index kPlatform = 3, kPitch = 4, kYaw = 5, kRoll = 6;  // joint indices of an MTM's gimbal
constexpr double kGoodPosition = 1e-5, kGoodOrientation = 1e-4;         // [m, rad]
constexpr double kInfeasible = 1e9;

double clamp(double x, double low, double high) noexcept { return std::min(std::max(x, low), high); }

arm::IkOptions options(int iterations) noexcept {
  arm::IkOptions o;
  o.max_iterations = iterations;
  o.position_tolerance = 1e-7;
  o.orientation_tolerance = 1e-6;
  return o;
}

bool good(const arm::Arm& model, const arm::IkResult& found) noexcept {
  return found.position_error < kGoodPosition && (!model.orients() || found.orientation_error < kGoodOrientation);
}

/// Sets the last three joints of an MTM in q such that its handle has the orientation R, by the Euler angles
///   R_4H = Rz(q5) Ry(q6 - pi/2) Rz(q7 + pi/2),   q6 within +-pi/4, so that sin(q6 - pi/2) < 0.
/// Returns |q6|, which is 0 for the most open gimbal; kInfeasible if a joint is outside its limits.
double gimbal(arm::Arm& model, const Mat3& R, JointVector& q) noexcept {
  const double roll = q[kRoll];
  q.tail<3>().setZero();
  model.update(q, JointVector::Zero(q.size()));
  Mat3 R_4H_at_zero;
  R_4H_at_zero << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  const Mat3 M = R_4H_at_zero * model.tip().R.transpose() * R;
  q[kYaw] = 0.5 * kPi - std::acos(clamp(M(2, 2), -1.0, 1.0));
  q[kPitch] = std::atan2(-M(1, 2), -M(0, 2));
  if (q[kPitch] < model.q_min()[kPitch]) q[kPitch] += 2.0 * kPi;
  const double turned = std::atan2(-M(2, 1), M(2, 0)) - 0.5 * kPi;
  q[kRoll] = turned + 2.0 * kPi * std::nearbyint((roll - turned) / (2.0 * kPi));
  for (Eigen::Index k = kPitch; k <= kRoll; ++k) {
    if (q[k] < model.q_min()[k] || q[k] > model.q_max()[k]) return kInfeasible;
  }
  return std::abs(q[kYaw]);
}

/// An initial guess for an MTM: the platform angle that opens the gimbal most without a large motion.
JointVector open_gimbal(arm::Arm& model, const Mat3& R, const JointVector& q) noexcept {
  constexpr int kSteps = 24;
  JointVector best = q;
  double least = kInfeasible;
  for (int k = 0; k <= kSteps; ++k) {
    JointVector trial = q;
    trial[kPlatform] = model.q_min()[kPlatform] +
                       (model.q_max()[kPlatform] - model.q_min()[kPlatform]) * k / static_cast<double>(kSteps);
    const double cost = gimbal(model, R, trial) + 0.2 * std::abs(trial[kPlatform] - q[kPlatform]) +
                        0.1 * std::abs(trial[kRoll] - q[kRoll]);
    if (cost < least) {
      least = cost;
      best = trial;
    }
  }
  return best;
}

/// Inverse kinematics by damped Newton steps from q, without joint limits.
JointVector unlimited(arm::Arm& model, const Pose& X_0T, JointVector q) noexcept {
  constexpr double kLength = 0.1, kDamping = 0.02, kMostStep = 0.4;  // [m] equivalent to 1 rad; [-]; [rad]
  const JointVector rest = JointVector::Zero(q.size());
  for (int k = 0; k < 12; ++k) {
    model.update(q, rest);
    Vec6 e;
    e << (X_0T.p - model.tip().p) / kLength, rotation_vector(X_0T.R * model.tip().R.transpose());
    Jacobian J = model.jacobian();
    J.topRows<3>() /= kLength;
    if (!model.orients()) {
      e.tail<3>().setZero();
      J.bottomRows<3>().setZero();
    }
    if (e.squaredNorm() < 1e-14) break;
    Mat6 A = J * J.transpose();
    A.diagonal().array() += 1e-12 + kDamping * e.squaredNorm();
    const Vec6 y = solve_ldlt(A, e);
    double longest = kMostStep;
    for (Eigen::Index j = 0; j < q.size(); ++j) longest = std::max(longest, std::abs(J.col(j).dot(y)));
    for (Eigen::Index j = 0; j < q.size(); ++j) q[j] += kMostStep / longest * J.col(j).dot(y);
  }
  return q;
}

}  // namespace

// As on the real arms, the solution ignores the joint limits and is clipped afterwards, so that it does not flip to
// another configuration at a limit.
double inverse_near(arm::Arm& model, ArmKind kind, const Pose& X_0T, JointVector& q) noexcept {
  if (kind == ArmKind::mtm) {
    const double opened = q[kPlatform] + q[kYaw] * std::cos(q[kPitch]);
    q[kPlatform] = clamp(opened, model.q_min()[kPlatform], model.q_max()[kPlatform]);
  }
  const JointVector found = unlimited(model, X_0T, q);
  if (found.allFinite()) q = found.cwiseMax(model.q_min()).cwiseMin(model.q_max());
  model.update(q, JointVector::Zero(q.size()));
  return (X_0T.p - model.tip().p).norm();
}

bool inverse_anywhere(arm::Arm& model, ArmKind kind, const Pose& X_0T, const JointVector& home,
                      JointVector& q) noexcept {
  constexpr int kStarts = 9;
  for (int start = 0; start < kStarts; ++start) {
    JointVector trial = start % 2 == 0 ? q : home;
    if (kind == ArmKind::mtm) {
      if (start < 2) trial = open_gimbal(model, X_0T.R, trial);
    } else if (start > 1 && trial.size() > kPlatform) {
      const int quarters = start / 2 - 2;
      trial[kPlatform] = quarters * 0.5 * kPi;  // initial guesses for a PSM's roll, in quarter turns
    }
    arm::IkResult found = model.ik(X_0T, trial, options(60));
    if (kind == ArmKind::mtm && !good(model, found)) {  // the solution has moved the forearm: open the gimbal again
      trial = open_gimbal(model, X_0T.R, trial);
      found = model.ik(X_0T, trial, options(60));
    }
    if (!good(model, found)) continue;
    q = trial;
    return true;
  }
  return false;
}

}  // namespace palpate::dvrk
