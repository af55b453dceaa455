#include "dvrk/camera_teleop.hpp"

#include <cmath>

namespace palpate::dvrk {
namespace {

constexpr double kDistanceStiffness = 150.0;  // [N/m] of the spring that keeps the distance of the hands
constexpr double kScale = 1.0;                // insertion of the endoscope per displacement of the hands [-]
constexpr double kApart = 0.01;               // [m] smallest distance between the hands

Vec3 friction(const Vec3& v) noexcept { return Vec3(-10.0, -10.0, -40.0).cwiseProduct(v); }  // [N] at v [m/s]

/// Angle from a to b about the unit vector n, after projection onto the plane perpendicular to n [rad].
double turned(const Vec3& a, const Vec3& b, const Vec3& n) noexcept {
  const Vec3 from = a - n * n.dot(a), to = b - n * n.dot(b);
  return std::atan2(n.dot(from.cross(to)), from.dot(to));
}

}  // namespace

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
  wanted_ = enable;
  if (!enable) following_ = false;
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
  following_ = true;
}

void CameraTeleop::push(SimulatedArm& mtm, const Vec3& p_goal) const noexcept {
  const ArmState& state = mtm.state();
  const Vec3 f = kDistanceStiffness * (p_goal - state.measured_cp.p) + friction(state.measured_cv.v);
  mtm.controller().body_set_cf_orientation_absolute(true);
  mtm.controller().body_servo_cf({f, Vec3::Zero()});
}

void CameraTeleop::run() noexcept {
  if (!wanted_) return;
  if (!following_) return begin();
  for (SimulatedArm* arm : {mtml_, mtmr_, ecm_}) {
    if (!arm->ready()) {
      following_ = false;
      return;
    }
  }
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
  const double in = kScale * (first_.C.norm() - now.C.norm()), roll = -turned(first_.up, now.up, Vec3::UnitZ());
  const double turn = roll + q_first_[3];
  JointVector q = q_first_;
  q[0] += pan * std::cos(turn) - tilt * std::sin(turn);
  q[1] += tilt * std::cos(turn) + pan * std::sin(turn);
  q[2] += in;
  q[3] += roll;
  ecm_->controller().servo_jp(q, {});
}

}  // namespace palpate::dvrk
