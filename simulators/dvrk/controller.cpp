#include "dvrk/controller.hpp"

#include <cmath>
#include <string_view>

#include "dvrk/inverse.hpp"
#include "dvrk/joints.hpp"
#include "palpate/types/ldlt.hpp"

namespace palpate::dvrk {
namespace {

constexpr double kReportPeriod = 2.0;       // [s] between two reports of refused commands
constexpr double kCannula = 0.045 - 0.002;  // [m] from the remote centre: smallest insertion for Cartesian control
constexpr double kReach = 0.1;  // [m] farther beyond the joint limits, a Cartesian goal is refused, not clipped

/// Smallest joint velocities that give the tip V:  J^T (J J^T + eps)^-1 V.
JointVector joint_velocity(const Jacobian& J, const Vec6& V) noexcept {
  Mat6 A = J * J.transpose();
  A.diagonal().array() += 1e-9;
  return J.transpose() * solve_ldlt(A, V);
}

}  // namespace

Controller::Controller(ArmContext& arm) : arm_(arm), n_(arm.n()) {
  const JointVector zero = JointVector::Zero(n_);
  goal_.q = goal_.v = goal_.tau = effort_.tau = zero;
  order_.q = order_.v = order_.tau = zero;
  path_.start(zero, zero, zero, arm.spec.v_max, arm.spec.a_max);
  path_.stop();
}

// ---- control space and mode

bool Controller::ready_for(std::string_view method, Space space) noexcept {
  const bool can = space == Space::joint ? arm_.is_joint_ready() : arm_.is_cartesian_ready();
  if (arm_.state.operating_state.state == State::ENABLED && can && !blocked_) {
    refusals_.count = 0;
    refusals_.reported_at = -kReportPeriod;
    return true;
  }
  if (arm_.publisher.t() - refusals_.reported_at >= kReportPeriod) {
    Text words(method);
    words << ", arm not ready";
    if (refusals_.count > 1) words << " (" << static_cast<long>(refusals_.count) << " errors)";
    arm_.warning(words);
    refusals_.reported_at = arm_.publisher.t();
  }
  ++refusals_.count;
  return false;
}

bool Controller::past_cannula() noexcept {
  if (arm_.spec.cannula_link < 0) return true;
  arm_.model.update(arm_.body->measured().q, arm_.body->measured().v);
  return arm_.model.link_pose(arm_.spec.cannula_link).p.norm() >= kCannula;
}

bool Controller::set_mode(Space space, Mode mode) noexcept {
  if (space == space_ && mode == mode_) return true;
  if (space == Space::cartesian && space_ != space && !past_cannula()) {
    if (!refusals_.cannula_reported) {
      arm_.warning("tool/endoscope needs to be inserted past the cannula to switch to cartesian space");
    }
    refusals_.cannula_reported = true;
    return false;
  }
  refusals_.cannula_reported = false;
  if (space != space_ && space != Space::cartesian) locked_ = false;
  space_ = space;
  if (mode != mode_) enter_mode(mode);
  constexpr std::array<std::string_view, 3> kSpaces{"UNDEFINED_SPACE", "JOINT_SPACE", "CARTESIAN_SPACE"};
  constexpr std::array<std::string_view, 4> kModes{"UNDEFINED_MODE", "POSITION_MODE", "TRAJECTORY_MODE", "EFFORT_MODE"};
  Text words("control ");
  words << kSpaces[static_cast<std::size_t>(space_)] << "/" << kModes[static_cast<std::size_t>(mode_)];
  arm_.status(words);
  return true;
}

void Controller::enter_mode(Mode mode) noexcept {
  const bool from_position = mode_ == Mode::position;
  if (mode_ == Mode::trajectory && path_.active()) stop_move(false);
  mode_ = mode;
  if (mode == Mode::position || mode == Mode::trajectory) {
    locked_ = false;
    goal_.is_new = false;
    goal_.q = arm_.state.setpoint_js.q;
    goal_.v = from_position ? arm_.state.measured_js.v : JointVector::Zero(n_);
  } else if (mode == Mode::effort) {
    effort_.tau.setZero();
  }
}

void Controller::reset() noexcept {
  order_.on = false;
  space_ = Space::undefined;
  if (mode_ == Mode::trajectory && path_.active()) stop_move(false);
  mode_ = Mode::undefined;
  locked_ = false;
}

void Controller::rest() noexcept {
  mode_ = Mode::undefined;
  space_ = Space::undefined;
  order_rest(order_.on ? order_.q : arm_.body->measured().q, arm_.is_homed());
}

// ---- order to the joint servos

JointVector Controller::clipped(const JointVector& q) const noexcept {
  return q.cwiseMax(arm_.model.q_min()).cwiseMin(arm_.model.q_max());
}

// Gravity is fed forward in every mode except position control of an MTM, as on the real arm.
JointVector Controller::feed_forward() const noexcept {
  const bool use = compensates_gravity() && !(arm_.spec.kind == ArmKind::mtm && mode_ == Mode::position);
  return use ? arm_.state.gravity_compensation : JointVector::Zero(n_);
}

void Controller::order_positions(const JointVector& q, const JointVector& v, const JointVector& tau,
                                 bool clip) noexcept {
  order_.on = true;
  order_.by_torque.fill(false);
  order_.q = clip ? clipped(q) : q;
  order_.v = v;
  order_.tau = tau + feed_forward();
}

void Controller::order_rest(const JointVector& q, bool clip) noexcept {
  order_positions(q, JointVector::Zero(n_), JointVector::Zero(n_), clip);
}

void Controller::follow_path(double dt, bool clip) noexcept {
  path_.step(dt);
  order_positions(path_.q(), path_.v(), JointVector::Zero(n_), clip);
}

Text Controller::control(double dt) noexcept {
  switch (mode_) {
    case Mode::undefined:
      break;
    case Mode::position:
      if (!goal_.is_new) break;
      goal_.is_new = space_ == Space::cartesian && !servo_pose(dt);
      order_positions(goal_.q, goal_.v, goal_.tau, arm_.is_homed());
      break;
    case Mode::trajectory:
      if (!path_.active()) break;
      follow_path(dt, arm_.is_homed());
      if (path_.done()) stop_move(true);
      break;
    case Mode::effort:
      return run_effort(dt);
  }
  return {};
}

// Converts a Cartesian goal to joint goals: the pose by inverse kinematics, velocity and wrench by the Jacobian.
// Returns false while the wrist is still turning towards the goal, which near its singularity takes several periods.
bool Controller::servo_pose(double dt) noexcept {
  const ArmState& state = arm_.state;
  JointVector q = goal_.has_pose ? state.setpoint_js.q : state.measured_js.q;
  bool reached = true;
  if (goal_.has_pose) {
    const JointVector before = q;
    if (inverse_near(arm_.model, arm_.spec.kind, arm_.base_frame.inverse() * goal_.X, q) > kReach) {
      arm_.error("unable to solve inverse kinematics (the goal of servo_cp is out of reach)");
      q = before;
    }
    for (Eigen::Index k = kPlatformJoint; k < n_; ++k) {
      const double step = arm_.model.v_max()[k] * dt;
      reached &= std::abs(q[k] - before[k]) <= step;
      q[k] = std::clamp(q[k], before[k] - step, before[k] + step);
    }
  }
  const Mat3 R = state.measured_cp.R.transpose();  // from base axes to tip axes
  goal_.q = q;
  goal_.v = goal_.tau = JointVector::Zero(n_);
  if (goal_.has_twist) {
    Vec6 V;
    V << R * bounded(goal_.V.v), R * bounded(goal_.V.w);
    goal_.v = joint_velocity(state.body_jacobian, V);
  }
  if (goal_.has_wrench) {
    goal_.tau = joint_torque(state.body_jacobian, {R * bounded(goal_.F.f), R * bounded(goal_.F.t)});
  }
  return reached;
}

// Compares measured positions with setpoints, like the PID component of the real system.
Text Controller::tracking_fault() const noexcept {
  if (!order_.on) return {};
  const JointVector& q = arm_.body->measured().q;
  for (Eigen::Index k = 0; k < n_; ++k) {
    if (order_.by_torque[static_cast<std::size_t>(k)] || mode_ == Mode::effort) continue;
    if (std::abs(order_.q[k] - q[k]) <= arm_.spec.tracking_error[k]) continue;
    Text words("received [");
    words << arm_.spec.name << "-PID: measured to setpoint position error is too large on joint "
          << arm_.model.joint_names()[static_cast<std::size_t>(k)] << ", setpoint " << order_.q[k] << ", measured "
          << q[k] << "]";
    return words;
  }
  return {};
}

}  // namespace palpate::dvrk
