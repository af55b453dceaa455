#include "dvrk/setup_joints.hpp"

#include <array>
#include <numbers>

namespace palpate::dvrk {
namespace {

constexpr double kLink = 0.4;                                  // [m] length of each of the two horizontal links
constexpr double kLift = 0.4, kTurn = 0.9 * std::numbers::pi;  // [m], [rad] range to both sides
constexpr double kSpeed = 0.1, kTurnSpeed = 0.5;               // [m/s], [rad/s] of move_jp, which simulates a person

JointVector joints(double lift, double turn) noexcept {
  JointVector x = JointVector::Constant(SetupJoints::kJoints, turn);
  x[0] = lift;
  return x;
}

Text name_of(const ArmContext& arm) noexcept {
  Text name("SUJ/");
  name << arm.spec.name;
  return name;
}

/// Rotation by an angle [rad] about an axis through the point p.
Pose about(const Vec3& axis, const Vec3& p, double angle) noexcept {
  const Mat3 R = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  return {R, p - R * p};
}

}  // namespace

Pose setup_motion(const JointVector& q) noexcept {
  const Vec3 elbow(kLink, 0.0, 0.0), wrist(2.0 * kLink, 0.0, 0.0);
  return Pose{Mat3::Identity(), q[0] * Vec3::UnitZ()} * about(Vec3::UnitZ(), Vec3::Zero(), q[1]) *
         about(Vec3::UnitZ(), elbow, q[2]) * about(Vec3::UnitZ(), wrist, q[3]) * about(Vec3::UnitY(), wrist, q[4]) *
         about(Vec3::UnitX(), wrist, q[5]);
}

SetupJoints::SetupJoints(ArmContext& arm, Address at, Outbox& out)
    : arm_(arm),
      publisher_(at, name_of(arm), out),
      X_CB0_(arm.base_frame),
      X_CB_(arm.base_frame),
      q_(JointVector::Zero(kJoints)) {
  place();
}

void SetupJoints::start() noexcept { set(State::DISABLED, false); }

bool SetupJoints::apply(const Command& c) noexcept {
  if (c.verb == Verb::setup_state_command) {
    state_command(c.text.view());
    return true;
  }
  if (c.verb != Verb::setup_servo_jp && c.verb != Verb::setup_move_jp) return false;
  move(c);
  return true;
}

void SetupJoints::move(const Command& c) noexcept {
  const JointVector most = joints(kLift, kTurn);
  const JointVector& goal = c.position;
  if (goal.size() != kJoints || !goal.allFinite() || (goal.cwiseAbs().array() > most.array()).any()) {
    return publisher_.message(Topic::warning,
                              "refused: the setup joints take 6 numbers, a lift within 0.4 m and "
                              "five angles within 2.82 rad");
  }
  if (now_.state != State::ENABLED) {
    return publisher_.message(Topic::warning, "refused: the brakes are on, send state_command enable");
  }
  if (c.verb == Verb::setup_servo_jp) {
    path_.stop();
    q_ = goal;
    return place();
  }
  const JointVector speed = joints(kSpeed, kTurnSpeed);
  path_.start(q_, path_.active() ? path_.v() : JointVector(JointVector::Zero(kJoints)), goal, speed, speed);
  set(now_.state, true);
}

void SetupJoints::run(double t, double dt) noexcept {
  publisher_.at(t);
  if (!path_.active()) return;
  path_.step(dt);
  q_ = path_.q();
  place();
  if (!path_.active()) set(now_.state, false);
}

// The real setup joints have potentiometers, and their positions are known in every state.
void SetupJoints::state_command(std::string_view command) noexcept {
  if (command == "enable" || command == "home") {
    now_.is_homed = now_.is_homed || command == "home";
    return set(State::ENABLED, path_.active());
  }
  if (command == "disable") {
    path_.stop();
    return set(State::DISABLED, false);
  }
  if (command == "unhome") {
    now_.is_homed = false;
    return set(now_.state, now_.is_busy);
  }
  Text words(command);
  words << " doesn't seem to be a valid state_command of the setup joints (enable, disable, home or unhome)";
  publisher_.message(Topic::warning, words);
}

void SetupJoints::set_reference(const Pose& X_RC, std::string_view name) noexcept {
  X_RC_ = X_RC;
  arm_.state.reference = name;
  place();
}

void SetupJoints::set_base_frame(const Pose& X_RB) noexcept {
  X_CB0_ = setup_motion(q_).inverse() * X_RC_.inverse() * X_RB;
  arm_.base_frame = X_RB;
  X_CB_ = X_RC_.inverse() * X_RB;
  place();
}

void SetupJoints::place() noexcept {
  const bool moved = !q_.isZero(0.0), referred = !arm_.state.reference.empty();
  X_CB_ = moved ? setup_motion(q_) * X_CB0_ : X_CB0_;  // exactly the given frame while nothing has moved
  arm_.base_frame = referred ? X_RC_ * X_CB_ : X_CB_;
  ArmState& state = arm_.state;
  state.setup_js.q = q_;
  state.setup_js.v = path_.active() ? path_.v() : JointVector(JointVector::Zero(kJoints));
  state.setup_js.tau = JointVector::Zero(kJoints);
  state.setup_cp = arm_.base_frame;
  state.local_setup_cp = X_CB_;
}

void SetupJoints::set(State state, bool is_busy) noexcept {
  now_.state = state;
  now_.is_busy = is_busy;
  publisher_.operating(now_);
}

}  // namespace palpate::dvrk
