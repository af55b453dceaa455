// One period of a teleop: wait for the arms, align the MTM, follow.
#include <cmath>

#include "dvrk/teleop.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::dvrk {
namespace {

constexpr double kReadyTimeout = 60.0;  // [s] timeout for homing the arms
constexpr double kAlignPeriod = 0.01;   // [s] between two goals for the MTM
constexpr double kRemind = 2.0;         // [s] between two warnings about alignment or readiness

double angle(const Mat3& R) noexcept { return rotation_vector(R).norm(); }

Mat3 normalised(const Mat3& R) noexcept { return Eigen::Quaterniond(R).normalized().toRotationMatrix(); }

}  // namespace

void Teleop::run(double t, double dt) noexcept {
  publisher_.at(t);
  state_.t = t;
  in_phase_ += dt;
  since_goal_ += dt;
  check_arms();
  switch (phase_) {
    case Phase::disabled:
      if (desired_ != Phase::disabled) enter(Phase::setting_arms_state);
      break;
    case Phase::setting_arms_state:
      wait_for_arms();
      break;
    case Phase::aligning_mtm:
      align();
      break;
    case Phase::enabled:
      if (desired_ != Phase::enabled) {
        set_following(false);
        enter(desired_);
      } else if (!clutched_ && mtm_->state().cartesian_valid && psm_->state().cartesian_valid) {
        follow();
        follow_jaw(dt);
      }
      break;
  }
}

// Ends the teleoperation after an error of an arm, if an arm is no longer ready, or on command.
void Teleop::check_arms() noexcept {
  for (auto [arm, seen] : {std::pair{mtm_, &mtm_errors_}, std::pair{psm_, &psm_errors_}}) {
    const bool has_new_error = arm->errors() != *seen;
    *seen = arm->errors();
    if (!has_new_error || phase_ == Phase::disabled) continue;
    Text words("received from arm [");
    words << arm->spec().name << ": " << arm->last_error().view() << "]";
    error(words);
  }
  if (desired_ == Phase::disabled && phase_ != Phase::disabled) {
    set_following(false);
    state_.desired_state = name_of(desired_);
    return enter(Phase::disabled);
  }
  if (phase_ == Phase::disabled || phase_ == Phase::setting_arms_state) return;
  if (!psm_->ready()) error("PSM is not in state \"ENABLED\" anymore");
  if (!mtm_->ready()) error("MTM is not in state \"READY\" anymore");
}

void Teleop::wait_for_arms() noexcept {
  if (psm_->ready() && mtm_->ready()) return enter(Phase::aligning_mtm);
  if (in_phase_ <= kReadyTimeout) return;
  if (!psm_->ready()) error("timed out while setting up PSM state");
  if (!mtm_->ready()) error("timed out while setting up MTM state");
}

// Turns the MTM to the orientation of the PSM. The operator shows readiness by pinching or rolling the gripper.
void Teleop::align() noexcept {
  const Mat3 R_goal = psm_->state().setpoint_cp.R;
  if (!clutched_ && spec_.align_MTM && since_goal_ > kAlignPeriod) {
    since_goal_ = 0.0;
    mtm_->controller().move_cp({R_goal, mtm_->state().setpoint_cp.p});
  }
  if (desired_ == Phase::aligning_mtm) return;
  state_.alignment_offset = mtm_->state().measured_cp.R.transpose() * R_goal;
  const double off = spec_.align_MTM ? angle(state_.alignment_offset) : 0.0;
  if (!active_) watch_operator();
  if (off <= spec_.orientation_tolerance && active_) {
    if (desired_ == Phase::enabled) enter(Phase::enabled);
    return;
  }
  if (in_phase_ <= kRemind) return;
  in_phase_ = 0.0;
  if (off < spec_.orientation_tolerance) return publisher_.message(Topic::warning, "pinch/twist MTM gripper a bit");
  Text words("unable to align MTM, angle error is ");
  words << off * 180.0 / std::numbers::pi << " (deg)";
  publisher_.message(Topic::warning, words);
}

void Teleop::watch_operator() noexcept {
  const double gripper = mtm_->state().gripper.q[0];
  gripper_min_ = std::min(gripper_min_, gripper);
  gripper_max_ = std::max(gripper_max_, gripper);
  const Vec3 y_psm = psm_->state().setpoint_cp.R.col(1), y_mtm = mtm_->state().measured_cp.R.col(1);
  const double roll = std::acos(std::clamp(y_psm.dot(y_mtm), -1.0, 1.0));
  roll_min_ = std::min(roll_min_, roll);
  roll_max_ = std::max(roll_max_, roll);
  const double pinched = gripper_max_ - gripper_min_, rolled = roll_max_ - roll_min_;
  active_ = pinched >= spec_.gripper_threshold || rolled >= spec_.roll_threshold ||
            pinched + rolled > 0.8 * (spec_.gripper_threshold + spec_.roll_threshold);
}

void Teleop::follow() noexcept {
  if (F_user_valid_) mtm_->controller().body_servo_cf(F_user_);  // no timeout: it acts until the next transition
  const ArmState& mtm = mtm_->state();
  Pose goal = X_psm0_;
  Twist V;
  if (!spec_.translation_locked) {
    goal.p += spec_.scale * (mtm.measured_cp.p - X_mtm0_.p);
    V.v = spec_.scale * mtm.measured_cv.v;  // only the linear velocity is fed forward
  }
  if (!spec_.rotation_locked) goal.R = normalised(mtm.measured_cp.R * R_offset0_);
  psm_->controller().servo_cp(goal, V);
}

// Moves the jaw according to a rate-limited copy of the gripper angle (limited_gripper_).
void Teleop::follow_jaw(double dt) noexcept {
  const double gap = mtm_->state().gripper.q[0] - limited_gripper_;
  if (std::abs(gap) < spec_.jaw_caught_up) jaw_caught_up_ = true;
  const double reach = (jaw_caught_up_ ? spec_.jaw_rate : spec_.jaw_rate_after_clutch) * dt;
  limited_gripper_ += std::clamp(gap, -reach, reach);
  double jaw = jaw_of(limited_gripper_);
  if (jaw < psm_->instrument().q_min()) {
    jaw = psm_->instrument().q_min();
    limited_gripper_ = gripper_of(jaw);
  }
  psm_->controller().jaw_servo_jp(jaw);
}

}  // namespace palpate::dvrk
