#include "palpate/mapping/mapping.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/require.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::mapping {
namespace {

constexpr double kReturnSpeed = 0.02;  // [m/s] of the tool while a shift is taken back
constexpr double kLongestStep = 3.0;   // [periods] time that one step accounts for at most

/// Reduces the rotation angle of q by `angle` [rad], but not below zero.
Eigen::Quaterniond towards_identity(const Eigen::Quaterniond& q, double angle) {
  const Eigen::AngleAxisd rotation(q);
  return Eigen::Quaterniond(Eigen::AngleAxisd(std::max(rotation.angle() - angle, 0.0), rotation.axis()));
}

}  // namespace

Mapping::Mapping(const Options& options, const Mat3& R_WL, double dt)
    : options_(options), R_WL_(R_WL), dt_(dt), recentring_(options.recentring) {
  require("mapping", options.scale > 0.0 && std::isfinite(options.scale), "scale", options.scale,
          "tool motion per hand motion must be above 0, for example 0.5");
  require("mapping", options.force_scale >= 0.0 && std::isfinite(options.force_scale), "force_scale",
          options.force_scale, "must be 0 or more, for example 1");
  require("mapping", options.align_rate >= 0.0, "align_rate", options.align_rate,
          "must be 0 rad/s (keep the offset) or more");
  require("mapping", options.gripper_max > options.gripper_min, "gripper_max", options.gripper_max,
          "must be above mapping.gripper_min");
  require("mapping", options.jaw_max > options.jaw_min, "jaw_max", options.jaw_max, "must be above mapping.jaw_min");
  require("mapping", std::isfinite(options.jaw_start), "jaw_start", options.jaw_start, "must be an angle in rad");
  require("mapping", options.align_tolerance >= 0.0, "align_tolerance", options.align_tolerance,
          "must be 0 rad (do not wait) or more, for example 0.17");
  require("mapping", options.jaw_rate > 0.0, "jaw_rate", options.jaw_rate, "must be above 0 rad/s, for example 2");
}

ToolGoal Mapping::step(const Input& in) noexcept {
  if (!started_) {
    goal_ = in.X_WT;
    jaw_ = in.jaw;
    started_ = true;
  }
  const bool engaged = in.following && !in.clutch;
  // If the follower did not reach the goal, the tool holds or starts at its measured pose instead.
  if (!in.reached && !(engaged && engaged_)) {
    goal_ = in.X_WT;
    jaw_ = in.jaw;
  }
  const bool other_locks = in.lock_rotation != lock_rotation_ || in.lock_translation != lock_translation_;
  lock_rotation_ = in.lock_rotation;
  lock_translation_ = in.lock_translation;
  pause_asked_ = pause_asked_ || other_locks || (!engaged && in.pause_asked);
  if (engaged && (!engaged_ || other_locks)) {
    anchor(in);
  }
  engaged_ = engaged;
  const double dt = elapsed(in.t);
  if (!engaged) {
    recentring_.pause();
    return {goal_, jaw_, Twist{}, false};
  }

  if (lock_translation_) {
    recentring_.pause();
  } else {
    p_WT0_ += recentring_.step(
        {in.p_LH, options_.scale * in.V_LH.v.norm(), R_WL_, in.F_T_W, in.correction_W, in.reached}, dt);
    if (in.F_T_W.isZero(0.0)) return_by_shift(dt);  // against a force it would be the mapping that pushes
  }
  if (!lock_translation_) goal_.p = p_WT0_ + options_.scale * (in.X_WH.p - p_WH0_);
  if (!lock_rotation_) {
    goal_.R = in.X_WH.R * R_off_.toRotationMatrix();
    const bool free = in.F_T_W.isZero(0.0) && in.t_T_W.isZero(0.0);
    if (free) R_off_ = towards_identity(R_off_, options_.align_rate * dt_);
  }

  const double opening = (in.gripper - options_.gripper_min) / (options_.gripper_max - options_.gripper_min);
  const double jaw = options_.jaw_min + std::clamp(opening, 0.0, 1.0) * (options_.jaw_max - options_.jaw_min);
  const double jaw_step = options_.jaw_rate * dt_;
  jaw_held_ = jaw_held_ && jaw > jaw_;
  if (!jaw_held_) jaw_ += std::clamp(jaw - jaw_, -jaw_step, jaw_step);

  const Vec3 v = lock_translation_ ? Vec3::Zero() : Vec3(options_.scale * (R_WL_ * in.V_LH.v));
  const Vec3 w = lock_rotation_ ? Vec3::Zero() : Vec3(R_WL_ * in.V_LH.w);
  return {goal_, jaw_, {v, w}, true};
}

Vec3 Mapping::force_on_hand(const Vec3& F_T_W) const noexcept {
  return options_.force_scale * (R_WL_.transpose() * F_T_W);
}

Wrench Mapping::wrench_on_hand(const Wrench& F_T_W) const noexcept {
  return {force_on_hand(F_T_W.f), force_on_hand(F_T_W.t) / options_.scale};
}

DampedWrench Mapping::damped_wrench_on_hand(const DampedWrench& on_tool) const noexcept {
  return {wrench_on_hand(on_tool.F), options_.force_scale * options_.scale * (R_WL_.transpose() * on_tool.B * R_WL_)};
}

Vec3 Mapping::hand_position(const Vec3& p_WT) const noexcept { return p_WH0_ + (p_WT - p_WT0_) / options_.scale; }

// Time since the last step [s].
double Mapping::elapsed(double t) noexcept {
  const double passed = std::isfinite(t) && std::isfinite(t_) ? t - t_ : dt_;
  t_ = t;
  return std::clamp(passed, 0.0, kLongestStep * dt_);
}

void Mapping::return_by_shift(double dt) noexcept {
  if (!taking_back_) return;
  const double left = shift_.norm(), step = kReturnSpeed * dt;
  const Vec3 back = left > step ? Vec3(step / left * shift_) : shift_;
  p_WT0_ -= back;
  shift_ -= back;
  taking_back_ = left > step;
}

void Mapping::anchor(const Input& in) noexcept {
  if (anchor_count_ == 0 || pause_asked_) {
    shift_.setZero();
    taking_back_ = false;
  } else {
    shift_ += goal_.p - (p_WT0_ + options_.scale * (in.X_WH.p - p_WH0_));
  }
  pause_asked_ = false;
  p_WH0_ = in.X_WH.p;
  p_WT0_ = goal_.p;
  R_off_ = Eigen::Quaterniond(Mat3(in.X_WH.R.transpose() * goal_.R)).normalized();
  jaw_held_ = options_.ratchet;
  ++anchor_count_;
}

bool Mapping::aligned(const Pose& X_WH, const Pose& X_WT) const noexcept {
  if (options_.align_tolerance == 0.0) return true;
  return angle_axis(X_WH.R.transpose() * X_WT.R).angle() <= options_.align_tolerance;
}

}  // namespace palpate::mapping
