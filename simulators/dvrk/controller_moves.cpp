// Point-to-point motions of the joints and of the jaw.
#include "dvrk/controller.hpp"
#include "dvrk/inverse.hpp"

namespace palpate::dvrk {

void Controller::move_jp(const JointVector& q) noexcept {
  if (!ready_for("move_jp", Space::joint)) return;
  set_mode(Space::joint, Mode::trajectory);
  start_move(q);
}

void Controller::move_jr(const JointVector& dq) noexcept {
  if (!ready_for("move_jr", Space::joint)) return;
  set_mode(Space::joint, Mode::trajectory);
  start_move((path_.active() ? path_.goal() : arm_.state.setpoint_js.q) + dq);
}

void Controller::move_cp(const Pose& X) noexcept {
  if (!ready_for("move_cp", Space::cartesian) || !set_mode(Space::cartesian, Mode::trajectory)) return;
  JointVector q = arm_.state.measured_js.q;
  if (inverse_anywhere(arm_.model, arm_.spec.kind, arm_.base_frame.inverse() * X, arm_.spec.home, q)) {
    return start_move(q);
  }
  arm_.error("unable to solve inverse kinematics (the goal of move_cp is out of reach)");
  stop_move(false);
}

// Starts at the present setpoint; an active move blends into the new one.
void Controller::start_move(const JointVector& goal) noexcept {
  const bool moving = path_.active();
  const JointVector q = moving ? path_.q() : goal_.q, v = moving ? path_.v() : goal_.v;
  path_.start(q, v, clipped(goal), ratio_v_ * arm_.spec.v_max, ratio_a_ * arm_.spec.a_max);
  arm_.set_busy(true);
}

void Controller::start_path(const JointVector& goal) noexcept {
  path_.start(order_.q, JointVector::Zero(n_), goal, ratio_v_ * arm_.spec.v_max, ratio_a_ * arm_.spec.a_max);
}

void Controller::stop_move(bool reached) noexcept {
  if (path_.active() || reached) goal_.q = path_.q();
  goal_.v = JointVector::Zero(n_);
  path_.stop();
  arm_.publisher.flag(Topic::goal_reached, reached);
  arm_.set_busy(arm_.instrument.moving());
}

void Controller::set_ratio(Verb verb, double ratio) noexcept {
  const char* const name = verb == Verb::set_ratio     ? "trajectory_j_set_ratio"
                           : verb == Verb::set_ratio_v ? "trajectory_j_set_ratio_v"
                                                       : "trajectory_j_set_ratio_a";
  if (!(ratio > 0.0 && ratio <= 1.0)) {
    Text words(name);
    words << ", ratio must be within ]0;1], received " << ratio;
    return arm_.warning(words);
  }
  if (verb != Verb::set_ratio_a) arm_.publisher.value(Topic::ratio_v, ratio_v_ = ratio);
  if (verb != Verb::set_ratio_v) arm_.publisher.value(Topic::ratio_a, ratio_a_ = ratio);
  arm_.publisher.value(Topic::ratio, ratio_v_ == ratio_a_ ? ratio_v_ : 0.0);
  if (path_.active()) start_move(path_.goal());
}

void Controller::jaw_servo_jp(double q) noexcept {
  if (!ready_for("jaw_servo_jp", Space::cartesian)) return;
  arm_.instrument.servo_jp(q);
  arm_.set_busy(path_.active());  // this command ends an active move of the jaw
}

void Controller::jaw_servo_jf(double tau) noexcept {
  if (!ready_for("jaw_servo_jf", Space::cartesian)) return;
  arm_.instrument.servo_jf(tau);
  arm_.set_busy(path_.active());
}

void Controller::jaw_move_jp(double q) noexcept {
  if (!ready_for("jaw_move_jp", Space::cartesian)) return;
  arm_.instrument.move_jp(q, ratio_v_, ratio_a_);
  arm_.set_busy(true);
}

void Controller::jaw_arrived() noexcept {
  arm_.publisher.flag(Topic::goal_reached, true);
  arm_.set_busy(path_.active());
}

}  // namespace palpate::dvrk
