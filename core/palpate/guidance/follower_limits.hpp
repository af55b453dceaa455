// Limits of the follower: its joints' ranges and speeds, its lag behind the goal, and the speed of the goal.
#pragma once

#include <algorithm>

#include "palpate/guidance/fixture_state.hpp"
#include "palpate/guidance/follower_model.hpp"

namespace palpate::guidance {

/// Keeps the corrected goal within the limits of the follower.
class FollowerLimits {
 public:
  /// options: valid ones (check()). dt: period of the cycle [s].
  FollowerLimits(const Options& options, double dt) : options_(options), dt_(dt), model_(options.servo, dt) {}

  /// Begins a tick. p_WT: measured position [m]. X_mapped_before: mapped goal of the previous tick.
  void observe(const Vec3& p_WT, const Pose& X_mapped_before) noexcept {
    model_.observe(p_WT);
    X_mapped_before_ = X_mapped_before;
  }
  /// Ends a tick with the goal that the follower receives [m].
  void command(const Vec3& p_goal) noexcept { model_.command(p_goal); }

  /// Begins a correction that starts at the previous corrected goal X_WT. Inverts the Jacobian of the joints.
  void begin(const Pose& X_WT, const Input& in) noexcept;
  /// Adds rows to the quadratic program that keep the joints within their limits, by add(a, b, rank) for a . y >= b. At
  /// the goal y the joints are at q + J^+ (y - y_tool), with the measured joints q, the damped inverse J^+ of the
  /// Jacobian and the measured tool y_tool.
  template <class Add>
  void add_joint_rows(const Input& in, const Add& add) const noexcept;
  /// Distance that the goal keeps from a border [m]: the reserve, and more while the tool is far behind, because its
  /// joints move it to the goal along an arc.
  [[nodiscard]] double standoff() const noexcept { return options_.reserve + arc_; }
  /// True if the tool lags its goal, so that it needs a constraint of its own.
  [[nodiscard]] bool lags() const noexcept { return !model_.follows_at_once(); }
  /// Smallest lead of the goal over the tool along the gradient of c with which the tool itself satisfies c [m]. c is
  /// evaluated at the tool; `allowed` is the allowed violation [m].
  [[nodiscard]] double lead(const Constraint& c, double allowed) const noexcept {
    return model_.required_lead(c.gap + allowed, c.gradient.f.dot(model_.v()), c.gap_rate_of_fixture);
  }

  /// Moves the goal from X towards X_goal in one period: at most as fast as the hand moves the mapped goal plus the
  /// return speed, and no faster than speed_limit [m/s] and the joints allow.
  Pose towards(const Pose& X, const Pose& X_goal, double speed_limit, const Input& in) noexcept;
  /// Distance by which a speed limit delays the goal [m], and the unit vector from the desired to the delayed goal.
  [[nodiscard]] double lag() const noexcept { return lag_; }
  [[nodiscard]] const Vec3& lag_direction() const noexcept { return lag_direction_; }

 private:
  static constexpr int kJointRank = 1 << 20;  ///< joint limits rank above every fixture

  [[nodiscard]] double feasible_fraction(const Vec6& step, const Input& in) const noexcept;

  Options options_;
  double dt_;
  FollowerModel model_;
  Pose X_mapped_before_;
  Jacobian inverse_;  ///< joint k moves by inverse_.col(k) . y
  double arc_ = 0.0;  ///< largest deviation of the tool from the straight line to its goal [m]
  double lag_ = 0.0;
  Vec3 lag_direction_ = Vec3::Zero();
};

template <class Add>
void FollowerLimits::add_joint_rows(const Input& in, const Add& add) const noexcept {
  if (in.tool.joints == nullptr) return;
  const ToolJoints& joints = *in.tool.joints;
  const Vec6 from = displacement(in.goal.X_WT_goal, in.tool.X_WT);
  for (Eigen::Index k = 0; k < joints.q.size(); ++k) {
    const Vec6 a = inverse_.col(k);
    add(a, a.dot(from) + std::min(joints.q_min[k] - joints.q[k], 0.0), kJointRank);
    add(-a, -a.dot(from) - std::max(joints.q_max[k] - joints.q[k], 0.0), kJointRank);
  }
}

}  // namespace palpate::guidance
