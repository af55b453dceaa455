#include "dvrk/camera_teleop.hpp"

#include <array>
#include <cmath>

namespace palpate::dvrk {
namespace {

constexpr double kDistanceStiffness = 150.0;  // [N/m] of the spring that keeps the distance of the hands
constexpr double kApart = 0.01;               // [m] smallest distance between the hands

Vec3 friction(const Vec3& v) noexcept { return Vec3(-10.0, -10.0, -40.0).cwiseProduct(v); }  // [N] at v [m/s]

/// Angle from a to b about the unit vector n, after projection onto the plane perpendicular to n [rad].
double turned(const Vec3& a, const Vec3& b, const Vec3& n) noexcept {
  const Vec3 from = a - n * n.dot(a), to = b - n * n.dot(b);
  return std::atan2(n.dot(from.cross(to)), from.dot(to));
}

Text joined(const SimulatedArm& mtml, const SimulatedArm& mtmr, const SimulatedArm& ecm) noexcept {
  Text name(mtml.spec().name);
  name << "_" << mtmr.spec().name << "_" << ecm.spec().name;
  return name;
}

}  // namespace

CameraTeleop::CameraTeleop(SimulatedArm& mtml, SimulatedArm& mtmr, SimulatedArm& ecm, Outbox& out)
    : mtml_(&mtml), mtmr_(&mtmr), ecm_(&ecm), publisher_({Kind::camera_teleop, 0}, joined(mtml, mtmr, ecm), out) {}

std::string_view CameraTeleop::name_of(Phase phase) noexcept {
  constexpr std::array<std::string_view, 3> kNames{"DISABLED", "SETTING_ARMS_STATE", "ENABLED"};
  return kNames[static_cast<std::size_t>(phase)];
}

void CameraTeleop::start() noexcept {
  publisher_.text(Topic::teleop_desired_state, name_of(Phase::disabled));
  publisher_.text(Topic::teleop_current_state, name_of(phase_));
  publisher_.value(Topic::scale, scale_);
  set_following(false);
}

bool CameraTeleop::apply(const Command& c) noexcept {
  if (c.verb == Verb::camera_set_scale) {
    set_scale(c.value);
    return true;
  }
  if (c.verb != Verb::camera_state_command) return false;
  if (c.text == "enable" || c.text == "disable") {
    enable(c.text == "enable");
    return true;
  }
  Text words(c.text.view());
  words << " doesn't seem to be a valid state_command (enable or disable)";
  publisher_.message(Topic::warning, words);
  return true;
}

void CameraTeleop::set_scale(double scale) noexcept {
  if (!(scale > 0.0) || !std::isfinite(scale) || scale > 1e3) {
    Text words("set_scale, scale must be above 0 and finite, received ");
    words << scale;
    return publisher_.message(Topic::warning, words);
  }
  scale_ = scale;
  if (following_) {  // the endoscope goes on from where it is
    first_ = image();
    q_first_ = ecm_->state().setpoint_js.q;
  }
  publisher_.value(Topic::scale, scale);
}

void CameraTeleop::set_following(bool following) noexcept {
  following_ = following;
  publisher_.flag(Topic::following, following);
}

void CameraTeleop::enter(Phase phase) noexcept {
  if (phase == phase_) return;
  phase_ = phase;
  if (following_) set_following(false);
  publisher_.text(Topic::teleop_current_state, name_of(phase));
  Text words("current state is ");
  words << name_of(phase);
  publisher_.message(Topic::status, words);
}

// The forces on the MTMs end, and they keep their orientation until the pedal is released.
void CameraTeleop::clutch(int button) noexcept {
  if (button > 1) return;
  clutched_ = button == 1;
  if (phase_ != Phase::enabled) return;
  if (!clutched_) return enter(Phase::setting_arms_state);
  set_following(false);
  for (SimulatedArm* mtm : {mtml_, mtmr_}) mtm->controller().body_servo_cf({});
}

CameraTeleop::Image CameraTeleop::image() const noexcept {
  const Vec3 p_left = mtml_->state().measured_cp.p, p_right = mtmr_->state().measured_cp.p;
  Image now;
  const Vec3 across = p_right - p_left;
  now.C = 0.5 * (p_left + p_right);
  now.up = across.cross(now.C);
  now.valid = across.norm() > kApart && now.C.norm() > kApart && now.up.norm() > kApart * kApart;
  if (!now.valid) return now;
  now.up.normalize();
  now.side = now.C.cross(now.up).normalized();
  now.w = 0.5 * now.side.dot(across);
  now.d = 0.5 * now.C.normalized().dot(across);
  return now;
}

void CameraTeleop::enable(bool enable) noexcept {
  if (wanted_ != enable)
    publisher_.text(Topic::teleop_desired_state, name_of(enable ? Phase::enabled : Phase::disabled));
  wanted_ = enable;
  enter(enable && phase_ != Phase::disabled ? phase_ : enable ? Phase::setting_arms_state : Phase::disabled);
}

void CameraTeleop::begin() noexcept {
  for (SimulatedArm* arm : {mtml_, mtmr_, ecm_}) {
    if (!arm->ready()) return;
  }
  for (SimulatedArm* mtm : {mtml_, mtmr_}) {
    mtm->controller().use_gravity_compensation(true);
    mtm->controller().body_set_cf_orientation_absolute(true);
    mtm->controller().body_servo_cf({});
    mtm->controller().lock_orientation(mtm->state().measured_cp.R);
  }
  first_ = image();
  q_first_ = ecm_->state().setpoint_js.q;
  enter(Phase::enabled);
  if (!clutched_) set_following(true);
}

void CameraTeleop::push(SimulatedArm& mtm, const Vec3& p_goal) const noexcept {
  const ArmState& state = mtm.state();
  const Vec3 f = kDistanceStiffness * (p_goal - state.measured_cp.p) + friction(state.measured_cv.v);
  mtm.controller().body_set_cf_orientation_absolute(true);
  mtm.controller().body_servo_cf({f, Vec3::Zero()});
}

void CameraTeleop::run(double t) noexcept {
  publisher_.at(t);
  if (!wanted_) return;
  if (phase_ == Phase::setting_arms_state) return begin();
  for (SimulatedArm* arm : {mtml_, mtmr_, ecm_}) {
    if (arm->ready()) continue;
    Text words(arm->spec().name);
    words << " is not enabled and homed any more";
    publisher_.message(Topic::warning, words);
    return enter(Phase::setting_arms_state);
  }
  if (!following_) return;
  const Image now = image();
  if (!now.valid || !first_.valid) {  // hands too close together to define an orientation
    for (SimulatedArm* mtm : {mtml_, mtmr_})
      mtm->controller().body_servo_cf({friction(mtm->state().measured_cv.v), Vec3::Zero()});
    return;
  }
  const Vec3 offset = first_.w * now.side + first_.d * now.C.normalized();
  push(*mtml_, now.C - offset);
  push(*mtmr_, now.C + offset);

  // Pan, tilt, insertion and roll from the motion of the midpoint, in the axes of the base frame.
  const double pan = -turned(first_.C, now.C, Vec3::UnitY()), tilt = -turned(first_.C, now.C, Vec3::UnitX());
  const double in = scale_ * (first_.C.norm() - now.C.norm()), roll = -turned(first_.up, now.up, Vec3::UnitZ());
  const double turn = roll + q_first_[3];
  JointVector q = q_first_;
  q[0] += pan * std::cos(turn) - tilt * std::sin(turn);
  q[1] += tilt * std::cos(turn) + pan * std::sin(turn);
  q[2] += in;
  q[3] += roll;
  ecm_->controller().servo_jp(q, {});
}

}  // namespace palpate::dvrk
