#include "palpate/guidance/follower_limits.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/ldlt.hpp"

namespace palpate::guidance {
namespace {

constexpr double kArcPerLag2 = 2.0;  // [1/m] the tool's arc leaves the chord by lag^2 / (8 r), radius r at least 6 cm
constexpr double kMaxArc = 5e-4;     // [m] largest such deviation
constexpr double kSpeedFraction =
    0.9;  // usable fraction of the joints' speeds; the rest covers the linearisation error
constexpr double kDamping =
    1e-3;  // damping of the inverse of the Jacobian, whose rotational rows are scaled by kLength

}  // namespace

void FollowerLimits::begin(const Pose& X_WT, const Input& in) noexcept {
  arc_ = lags() ? std::min(kArcPerLag2 * (X_WT.p - in.tool.X_WT.p).squaredNorm(), kMaxArc) : 0.0;
  if (in.tool.joints == nullptr) return;
  inverse_ = in.tool.joints->J_WT;
  inverse_.bottomRows<3>() *= kLength;
  Mat6 A = Mat6::Zero();
  for (Eigen::Index k = 0; k < inverse_.cols(); ++k) {
    for (int j = 0; j < 6; ++j) {
      for (int i = j; i < 6; ++i) A(i, j) += inverse_(i, k) * inverse_(j, k);
    }
  }
  A.diagonal().array() += kDamping * kDamping;
  solve_ldlt(A, inverse_);
}

// The fraction of a step of the goal that the joints can follow in one period. Beyond it single joints would saturate,
// and the joints would no longer move together.
double FollowerLimits::feasible_fraction(const Vec6& step, const Input& in) const noexcept {
  double share = 1.0;
  if (in.tool.joints == nullptr || inverse_.cols() != in.tool.joints->max_step.size()) return share;
  const JointVector& steps = in.tool.joints->max_step;
  for (Eigen::Index k = 0; k < steps.size(); ++k) {
    const double turn = std::abs(inverse_.col(k).dot(step)), most = kSpeedFraction * steps[k];
    if (turn > most) share = std::min(share, most / turn);
  }
  return share;
}

Pose FollowerLimits::towards(const Pose& X, const Pose& X_goal, double speed_limit, const Input& in) noexcept {
  const double hand = displacement(X_mapped_before_, in.goal.X_WT_goal).norm();
  const Vec6 step = displacement(X, X_goal);
  const double far = step.norm();
  const double most =
      std::min({hand + options_.return_speed * dt_, speed_limit * dt_, far * feasible_fraction(step, in)});
  lag_ = 0.0;
  if (far <= most) return X_goal;
  const Pose reached = displaced(X, most / far * step);
  const Vec3 behind = reached.p - X_goal.p;
  if (speed_limit * dt_ <= most && behind.norm() > 0.0) lag_ = behind.norm(), lag_direction_ = behind / lag_;
  return reached;
}

}  // namespace palpate::guidance
