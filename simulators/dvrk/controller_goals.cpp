// Servo commands: goals of position control and of torque control, with the semantics of the real component.
#include "dvrk/controller.hpp"

namespace palpate::dvrk {

void Controller::set_goal(const JointVector& q, const JointVector& v) noexcept {
  goal_.q = q;
  goal_.v = v;
  goal_.tau = JointVector::Zero(n_);
  goal_.is_new = true;
}

void Controller::hold() noexcept {
  if (!ready_for("hold", Space::joint)) return;
  set_mode(Space::joint, Mode::position);
  set_goal(arm_.state.setpoint_js.q, JointVector::Zero(n_));
}

void Controller::servo_jp(const JointVector& q, const JointVector& v) noexcept {
  if (!ready_for("servo_jp", Space::joint)) return;
  set_mode(Space::joint, Mode::position);
  set_goal(clipped(q), v.size() == n_ ? v : JointVector::Zero(n_));
}

void Controller::servo_jr(const JointVector& dq) noexcept {
  if (!ready_for("servo_jr", Space::joint)) return;
  set_mode(Space::joint, Mode::position);
  const JointVector from = goal_.is_new ? goal_.q : arm_.state.setpoint_js.q;
  set_goal(clipped(from + dq), JointVector::Zero(n_));
}

void Controller::servo_cp(const Pose& X, const Twist& V) noexcept {
  if (!ready_for("servo_cp", Space::cartesian) || !set_mode(Space::cartesian, Mode::position)) return;
  goal_.X = X;
  goal_.V = V;
  goal_.has_pose = true;
  goal_.has_twist = !V.v.isZero(0.0) || !V.w.isZero(0.0);
  goal_.has_wrench = false;
  goal_.is_new = true;
}

void Controller::servo_cr(const Pose& dX) noexcept {
  const bool pending = goal_.is_new && space_ == Space::cartesian && mode_ == Mode::position;
  const Pose from = pending ? goal_.X : arm_.state.setpoint_cp;
  Pose X{dX.R * from.R, from.p + dX.p};
  X.R = Eigen::Quaterniond(X.R).normalized().toRotationMatrix();
  servo_cp(X, {});
}

void Controller::servo_cs(const Command& c) noexcept {
  if (!ready_for("servo_cs", Space::cartesian)) return;
  if (!c.pose_is_valid &&
      !c.twist_is_valid) {  // only a wrench, about the tip in base axes; zero if that is invalid, too
    const Wrench F = c.wrench_is_valid ? c.F : Wrench{};
    const Mat3 R = absolute_ ? Mat3::Identity() : Mat3(arm_.state.measured_cp.R.transpose());
    return body_servo_cf({R * F.f, R * F.t});
  }
  if (!set_mode(Space::cartesian, Mode::position)) return;
  goal_.X = c.X;
  goal_.V = c.V;
  goal_.F = c.F;
  goal_.has_pose = c.pose_is_valid;
  goal_.has_twist = c.twist_is_valid;
  goal_.has_wrench = c.wrench_is_valid;
  goal_.is_new = true;
}

void Controller::servo_jf(const JointVector& tau) noexcept {
  if (!ready_for("servo_jf", Space::joint)) return;
  set_mode(Space::joint, Mode::effort);
  effort_.tau = tau;
}

void Controller::free() noexcept {
  if (!ready_for("free", Space::joint)) return;
  servo_jf(JointVector::Zero(n_));
  locked_ = false;
}

void Controller::body_servo_cf(const Wrench& F) noexcept { servo_cf("body_servo_cf", Cf::body, F); }

void Controller::servo_cf(std::string_view method, Cf kind, const Wrench& F) noexcept {
  if (!ready_for(method, Space::cartesian) || !set_mode(Space::cartesian, Mode::effort)) return;
  if ((kind == Cf::spatial) != (effort_.kind == Cf::spatial)) {
    arm_.status(kind == Cf::spatial ? "effort cartesian WRENCH_SPATIAL" : "effort cartesian WRENCH_BODY");
  }
  effort_.kind = kind;
  effort_.F = F;
  if (kind == Cf::impedance) absolute_ = true;  // stays set afterwards, as on the real arm
}

void Controller::lock_orientation(const Mat3& R) noexcept {
  locked_ = true;
  R_locked_ = arm_.base_frame.R.transpose() * R;
  arm_.publisher.flag(Topic::orientation_locked, locked_);
}

void Controller::unlock_orientation() noexcept {
  locked_ = false;
  arm_.publisher.flag(Topic::orientation_locked, locked_);
}

}  // namespace palpate::dvrk
