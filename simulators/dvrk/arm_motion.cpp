// Commands of motion and of force, as the real component takes them: control space and mode, goals, refusals.
#include <array>
#include <cmath>

#include "dvrk/arm.hpp"
#include "dvrk/inverse.hpp"

namespace palpate::dvrk {
namespace {

constexpr double kQuiet = 2.0;              // [s] between two refusals that are told
constexpr double kCannula = 0.045 - 0.002;  // [m] from the remote centre, less the buffer to begin with

}  // namespace

bool Arm::ready_for(std::string_view method, Space space) noexcept {
  const bool can = space == Space::joint ? is_joint_ready() : is_cartesian_ready();
  if (operating_.state == State::ENABLED && can && phase_ != Phase::engaging) {
    refused_ = 0;
    told_refusal_ = -kQuiet;
    return true;
  }
  if (voice_.t() - told_refusal_ >= kQuiet) {
    Text words(method);
    words << ", arm not ready";
    if (refused_ > 1) words << " (" << static_cast<long>(refused_) << " errors)";
    voice_.words(Topic::warning, words);
    told_refusal_ = voice_.t();
  }
  ++refused_;
  return false;
}

bool Arm::past_cannula() noexcept {
  if (spec_.cannula_link < 0) return true;
  model_.update(body_->measured().q, body_->measured().v);
  return model_.link_pose(spec_.cannula_link).p.norm() >= kCannula;
}

bool Arm::set_mode(Space space, Mode mode) noexcept {
  if (space == space_ && mode == mode_) return true;
  if (space == Space::cartesian && space_ != space && !past_cannula()) {
    if (!told_cannula_) {
      voice_.words(Topic::warning, "tool/endoscope needs to be inserted past the cannula to switch to cartesian space");
    }
    told_cannula_ = true;
    return false;
  }
  told_cannula_ = false;
  if (space != space_ && space != Space::cartesian) locked_ = false;
  space_ = space;
  if (mode != mode_) {
    const bool from_position = mode_ == Mode::position;
    if (mode_ == Mode::trajectory && path_.active()) stop_move(false);
    mode_ = mode;
    if (mode == Mode::position || mode == Mode::trajectory) {
      locked_ = false;
      new_goal_ = false;
      goal_q_ = state_.setpoint_js.q;
      goal_v_ = from_position ? state_.measured_js.v : JointVector::Zero(n_);
    } else if (mode == Mode::effort) {
      servo_tau_.setZero();
    }
  }
  constexpr std::array<std::string_view, 3> kSpaces{"UNDEFINED_SPACE", "JOINT_SPACE", "CARTESIAN_SPACE"};
  constexpr std::array<std::string_view, 4> kModes{"UNDEFINED_MODE", "POSITION_MODE", "TRAJECTORY_MODE", "EFFORT_MODE"};
  Text words("control ");
  words << kSpaces[static_cast<std::size_t>(space_)] << "/" << kModes[static_cast<std::size_t>(mode_)];
  voice_.words(Topic::status, words);
  return true;
}

void Arm::hold() noexcept {
  if (!ready_for("hold", Space::joint)) return;
  set_mode(Space::joint, Mode::position);
  goal_q_ = state_.setpoint_js.q;
  goal_v_ = goal_tau_ = JointVector::Zero(n_);
  new_goal_ = true;
}

void Arm::servo_jp(const JointVector& q, const JointVector& v) noexcept {
  if (!ready_for("servo_jp", Space::joint)) return;
  set_mode(Space::joint, Mode::position);
  goal_q_ = clipped(q);
  goal_v_ = v.size() == n_ ? v : JointVector::Zero(n_);
  goal_tau_ = JointVector::Zero(n_);
  new_goal_ = true;
}

void Arm::servo_jr(const JointVector& dq) noexcept {
  if (!ready_for("servo_jr", Space::joint)) return;
  set_mode(Space::joint, Mode::position);
  if (!new_goal_) goal_q_ = state_.setpoint_js.q;
  goal_q_ = clipped(goal_q_ + dq);
  goal_v_ = goal_tau_ = JointVector::Zero(n_);
  new_goal_ = true;
}

void Arm::servo_cp(const Pose& X, const Twist& V) noexcept {
  if (!ready_for("servo_cp", Space::cartesian) || !set_mode(Space::cartesian, Mode::position)) return;
  goal_X_ = X;
  goal_V_ = V;
  goal_pose_ = true;
  goal_twist_ = !V.v.isZero(0.0) || !V.w.isZero(0.0);
  goal_wrench_ = false;
  new_goal_ = true;
}

void Arm::servo_cr(const Pose& dX) noexcept {
  const bool going_on = new_goal_ && space_ == Space::cartesian && mode_ == Mode::position;
  const Pose from = going_on ? goal_X_ : state_.setpoint_cp;
  Pose X{dX.R * from.R, from.p + dX.p};
  X.R = Eigen::Quaterniond(X.R).normalized().toRotationMatrix();
  servo_cp(X, {});
}

void Arm::servo_cs(const Command& c) noexcept {
  if (!ready_for("servo_cs", Space::cartesian)) return;
  if (!c.pose_is_valid && !c.twist_is_valid) {  // a wrench alone, about the tip in base axes, or nothing: no force
    const Wrench F = c.wrench_is_valid ? c.F : Wrench{};
    const Mat3 R = absolute_ ? Mat3::Identity() : Mat3(state_.measured_cp.R.transpose());
    return body_servo_cf({R * F.f, R * F.t});
  }
  if (!set_mode(Space::cartesian, Mode::position)) return;
  goal_X_ = c.X;
  goal_V_ = c.V;
  goal_F_ = c.F;
  goal_pose_ = c.pose_is_valid;
  goal_twist_ = c.twist_is_valid;
  goal_wrench_ = c.wrench_is_valid;
  new_goal_ = true;
}

void Arm::servo_jf(const JointVector& tau) noexcept {
  if (!ready_for("servo_jf", Space::joint)) return;
  set_mode(Space::joint, Mode::effort);
  servo_tau_ = tau;
}

void Arm::free() noexcept {
  if (!ready_for("free", Space::joint)) return;
  servo_jf(JointVector::Zero(n_));
  locked_ = false;
}

void Arm::body_servo_cf(const Wrench& F) noexcept { servo_cf("body_servo_cf", Cf::body, F); }

void Arm::servo_cf(std::string_view method, Cf cf, const Wrench& F) noexcept {
  if (!ready_for(method, Space::cartesian) || !set_mode(Space::cartesian, Mode::effort)) return;
  if ((cf == Cf::spatial) != (cf_ == Cf::spatial)) {
    voice_.words(Topic::status, cf == Cf::spatial ? "effort cartesian WRENCH_SPATIAL" : "effort cartesian WRENCH_BODY");
  }
  cf_ = cf;
  servo_F_ = F;
  if (cf == Cf::impedance) absolute_ = true;  // and leaves it so, as the real one
}

void Arm::lock_orientation(const Mat3& R) noexcept {
  locked_ = true;
  R_locked_ = base_frame_.R.transpose() * R;
  voice_.flag(Topic::orientation_locked, locked_);
}

void Arm::unlock_orientation() noexcept {
  locked_ = false;
  voice_.flag(Topic::orientation_locked, locked_);
}

void Arm::move_jp(const JointVector& q) noexcept {
  if (!ready_for("move_jp", Space::joint)) return;
  set_mode(Space::joint, Mode::trajectory);
  start_move(q);
}

void Arm::move_jr(const JointVector& dq) noexcept {
  if (!ready_for("move_jr", Space::joint)) return;
  set_mode(Space::joint, Mode::trajectory);
  start_move((path_.active() ? path_.goal() : state_.setpoint_js.q) + dq);
}

void Arm::move_cp(const Pose& X) noexcept {
  if (!ready_for("move_cp", Space::cartesian) || !set_mode(Space::cartesian, Mode::trajectory)) return;
  JointVector q = state_.measured_js.q;
  if (inverse_anywhere(model_, spec_.kind, base_frame_.inverse() * X, spec_.home, q)) return start_move(q);
  error("unable to solve inverse kinematics (the goal of move_cp is out of reach)");
  stop_move(false);
}

// From where the joints are told to be now; a move that is under way goes over into the new one.
void Arm::start_move(const JointVector& goal) noexcept {
  const bool on_the_way = path_.active();
  const JointVector q = on_the_way ? path_.q() : goal_q_, v = on_the_way ? path_.v() : goal_v_;
  path_.start(q, v, clipped(goal), ratio_v_ * spec_.v_max, ratio_a_ * spec_.a_max);
  busy(true);
}

void Arm::stop_move(bool reached) noexcept {
  if (path_.active() || reached) goal_q_ = path_.q();
  goal_v_ = JointVector::Zero(n_);
  path_.stop();
  voice_.flag(Topic::goal_reached, reached);
  busy(instrument_.moving());
}

void Arm::set_ratio(Verb verb, double ratio) noexcept {
  const char* const name = verb == Verb::set_ratio     ? "trajectory_j_set_ratio"
                           : verb == Verb::set_ratio_v ? "trajectory_j_set_ratio_v"
                                                       : "trajectory_j_set_ratio_a";
  if (!(ratio > 0.0 && ratio <= 1.0)) {
    Text words(name);
    words << ", ratio must be within ]0;1], received " << ratio;
    return voice_.words(Topic::warning, words);
  }
  if (verb != Verb::set_ratio_a) voice_.value(Topic::ratio_v, ratio_v_ = ratio);
  if (verb != Verb::set_ratio_v) voice_.value(Topic::ratio_a, ratio_a_ = ratio);
  voice_.value(Topic::ratio, ratio_v_ == ratio_a_ ? ratio_v_ : 0.0);
  if (path_.active()) start_move(path_.goal());
}

void Arm::jaw(const Command& c) noexcept {
  const bool move = c.verb == Verb::jaw_move_jp;
  if (c.verb == Verb::jaw_servo_jp) return jaw_servo_jp(c.position[0]);
  if (!ready_for(move ? "jaw_move_jp" : "jaw_servo_jf", Space::cartesian)) return;
  if (!move) {
    instrument_.servo_jf(c.effort[0]);
    return busy(path_.active());
  }
  instrument_.move_jp(c.position[0], ratio_v_, ratio_a_);
  busy(true);
}

void Arm::jaw_servo_jp(double q) noexcept {
  if (!ready_for("jaw_servo_jp", Space::cartesian)) return;
  instrument_.servo_jp(q);
  busy(path_.active());  // a move of the jaw that was on its way has ended here
}

}  // namespace palpate::dvrk
