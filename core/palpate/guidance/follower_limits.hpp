// What the follower can do: its joints' limits, the lag behind its goal, and how fast the goal may move.
#pragma once

#include <algorithm>

#include "palpate/guidance/fixture_state.hpp"
#include "palpate/guidance/follower_model.hpp"

namespace palpate::guidance {

class FollowerLimits {
 public:
  /// dt: period of the cycle [s]. Throws std::invalid_argument naming an option that cannot be.
  FollowerLimits(const Options& options, double dt) : options_(options), dt_(dt), model_(options.servo, dt) {}

  /// A tick begins. X_mapped_before: mapped goal of the tick before.
  void observe(const Vec3& p_WT, const Pose& X_mapped_before) noexcept {
    model_.observe(p_WT);
    X_mapped_before_ = X_mapped_before;
  }
  /// The tick ends with this goal.
  void command(const Vec3& p_goal) noexcept { model_.command(p_goal); }

  /// A correction of the goal starts at X_WT. Inverts the joints' Jacobian.
  void begin(const Pose& X_WT, const Input& in) noexcept;
  /// Adds the rows that keep the joints within their limits: q + J^+ (y - y_tool). Their fixture is -1.
  template <class Add>
  void add_joint_rows(const Input& in, const Add& add) const noexcept;
  /// Distance that the goal keeps from a border: the reserve, and more while the tool is far behind, because its joints
  /// lead it to the goal along an arc [m].
  [[nodiscard]] double standoff() const noexcept { return options_.reserve + arc_; }
  /// True when the tool lags its goal, so that it needs a constraint of its own.
  [[nodiscard]] bool lags() const noexcept { return !model_.follows_at_once(); }
  /// Least distance that the goal has to lie along the gradient of c, ahead of the tool, so that the tool respects c,
  /// evaluated at the tool; `allowed` is the violation allowed [m].
  [[nodiscard]] double lead(const Constraint& c, double allowed) const noexcept {
    return model_.need(c.gap + allowed, c.gradient.f.dot(model_.v()), c.gap_rate_of_fixture);
  }

  /// A goal from X towards X_goal: as fast as the hand moves the mapped goal plus the return speed, but no faster than
  /// speed_limit [m/s] and the joints allow.
  Pose towards(const Pose& X, const Pose& X_goal, double speed_limit, const Input& in) noexcept;
  /// How far a speed limit keeps the goal behind [m], and in which direction.
  [[nodiscard]] double lag() const noexcept { return lag_; }
  [[nodiscard]] const Vec3& lag_direction() const noexcept { return lag_direction_; }

 private:
  static constexpr int kJointRank = 1 << 20;  ///< limits of joints come before every fixture

  [[nodiscard]] double share_of_joints(const Vec6& step, const Input& in) const noexcept;

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
