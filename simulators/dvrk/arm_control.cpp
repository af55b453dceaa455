// What an arm orders from its joints in each control mode.
#include "dvrk/arm.hpp"
#include "dvrk/impedance.hpp"
#include "dvrk/inverse.hpp"
#include "palpate/torque/terms.hpp"

namespace palpate::dvrk {
namespace {

constexpr double kReach = 0.1;         // [m] a Cartesian goal so far beyond the limits is refused, not clipped
constexpr double kOverCurrent = 0.1;   // [s] OURS: a torque above a drive's limit is cut; asked for so long, a fault
constexpr Eigen::Index kPlatform = 3;  // joint 4: with it an MTM's gimbal, a PSM's wrist begins

/// J^T F of a Jacobian and a wrench in the same axes.
JointVector transposed(const Jacobian& J, const Wrench& F) noexcept {
  JointVector tau(J.cols());
  for (Eigen::Index k = 0; k < J.cols(); ++k) {
    tau[k] = J.col(k).head<3>().dot(F.f) + J.col(k).tail<3>().dot(F.t);
  }
  return tau;
}

/// Least joint velocities that give the tip V:  J^T (J J^T + eps)^-1 V.
JointVector joint_velocity(const Jacobian& J, const Vec6& V) noexcept {
  Mat6 A = J * J.transpose();
  A.diagonal().array() += 1e-9;
  const Vec6 y = A.ldlt().solve(V);
  return J.transpose() * y;
}

}  // namespace

JointVector Arm::clipped(const JointVector& q) const noexcept {
  return q.cwiseMax(model_.q_min()).cwiseMin(model_.q_max());
}

// Weight is fed forward in every mode but position control on an MTM, as the real one does.
JointVector Arm::feed_forward() const noexcept {
  const bool use =
      gravity_compensation_ && spec_.has_gravity_model && !(spec_.kind == ArmKind::mtm && mode_ == Mode::position);
  return use ? state_.gravity_compensation : JointVector::Zero(n_);
}

void Arm::order_positions(const JointVector& q, const JointVector& v, const JointVector& tau) noexcept {
  order_.on = true;
  order_.by_torque.fill(false);
  order_.q = is_homed() && phase_ != Phase::homing ? clipped(q) : q;
  order_.v = v;
  order_.tau = tau + feed_forward();
}

void Arm::control(double dt) noexcept {
  switch (mode_) {
    case Mode::undefined:
      break;
    case Mode::position:
      if (!new_goal_) break;
      new_goal_ = space_ == Space::cartesian && !servo_pose(dt);
      order_positions(goal_q_, goal_v_, goal_tau_);
      break;
    case Mode::trajectory:
      if (!path_.active()) break;
      path_.step(dt);
      order_positions(path_.q(), path_.v(), JointVector::Zero(n_));
      if (path_.done()) stop_move(true);
      break;
    case Mode::effort:
      run_effort(dt);
      break;
  }
}

// Joint goals of a Cartesian one: position by inverse kinematics, velocity and wrench by the Jacobian. False: the
// wrist, which turns over where it is singular, is on its way yet.
bool Arm::servo_pose(double dt) noexcept {
  JointVector q = goal_pose_ ? state_.setpoint_js.q : state_.measured_js.q;
  bool there = true;
  if (goal_pose_) {
    const JointVector before = q;
    if (inverse_near(model_, spec_.kind, base_frame_.inverse() * goal_X_, q) > kReach) {
      error("unable to solve inverse kinematics (the goal of servo_cp is out of reach)");
      q = before;
    }
    for (Eigen::Index k = kPlatform; k < n_; ++k) {
      const double reach = model_.v_max()[k] * dt;
      there &= std::abs(q[k] - before[k]) <= reach;
      q[k] = std::clamp(q[k], before[k] - reach, before[k] + reach);
    }
  }
  const Mat3 R = state_.measured_cp.R.transpose();  // base frame to tip
  goal_q_ = q;
  goal_v_ = goal_tau_ = JointVector::Zero(n_);
  if (goal_twist_) {
    Vec6 V;
    V << R * bounded(goal_V_.v), R * bounded(goal_V_.w);
    goal_v_ = joint_velocity(state_.body_jacobian, V);
  }
  if (goal_wrench_) {
    goal_tau_ = transposed(state_.body_jacobian, {R * bounded(goal_F_.f), R * bounded(goal_F_.t)});
  }
  return there;
}

// Torque of the wrench that is to act on the handle; it stays until the next one comes, however long.
JointVector Arm::effort(double dt) noexcept {
  if (space_ == Space::joint) {
    const JointVector tau = bounded(servo_tau_);
    watch_current(tau, dt);
    return tau;
  }
  const Wrench sent{bounded(servo_F_.f), bounded(servo_F_.t)};
  if (cf_ == Cf::spatial) {  // and no platform control
    const JointVector tau = transposed(state_.spatial_jacobian, sent);
    watch_current(tau, dt);
    return tau;
  }
  Wrench F = sent;
  if (cf_ == Cf::impedance) {
    F = impedance_wrench(impedance_, state_.measured_cp, state_.measured_cv);
    F = {bounded(F.f), bounded(F.t)};
  }
  if (absolute_) F = {state_.measured_cp.R.transpose() * F.f, state_.measured_cp.R.transpose() * F.t};
  JointVector tau = transposed(state_.body_jacobian, F);
  watch_current(tau, dt);
  if (spec_.kind == ArmKind::mtm) {
    tau[kPlatform] += torque::platform(spec_.platform_gain, state_.measured_js.q, state_.measured_js.v);
  }
  return tau;
}

// The check of currents is what protects an arm in torque control: there is no position to lose.
void Arm::watch_current(const JointVector& tau, double dt) noexcept {
  for (Eigen::Index k = 0; k < n_; ++k) {
    double& over = over_current_[static_cast<std::size_t>(k)];
    over = std::abs(tau[k]) > model_.tau_max()[k] ? over + dt : 0.0;
    if (over <= kOverCurrent) continue;
    over_current_.fill(0.0);
    Text words("received [");
    words << spec_.name << "-IO: requested effort is too large on joint "
          << model_.joint_names()[static_cast<std::size_t>(k)] << ", requested " << tau[k] << ", limit "
          << model_.tau_max()[k] << "]";
    return fault(words);
  }
}

void Arm::run_effort(double dt) noexcept {
  const bool locked = locked_ && space_ == Space::cartesian;
  const JointVector held = order_.q;  // where the gimbal was told to be
  const bool goes_on = locked && order_.on && !order_.by_torque[kPlatform];
  order_.on = true;
  order_.by_torque.fill(true);
  order_.q = body_->measured().q;
  order_.v = JointVector::Zero(n_);
  const JointVector tau = effort(dt);
  if (phase_ == Phase::fault) return;
  order_.tau = tau + feed_forward();
  if (!locked) return;
  if (goes_on) order_.q.tail(n_ - kPlatform) = held.tail(n_ - kPlatform);
  hold_orientation(dt);
}

// The gimbal's joints in position control, on their way to the locked orientation at the handle's place of now.
void Arm::hold_orientation(double dt) noexcept {
  JointVector q = state_.measured_js.q;
  q.tail(n_ - kPlatform) = order_.q.tail(n_ - kPlatform);
  const double platform = q[kPlatform];
  const double error = model_.ik({R_locked_, state_.local_measured_cp.p}, q).orientation_error;
  if (error > 0.1) q.tail(n_ - kPlatform) = order_.q.tail(n_ - kPlatform);
  q[kPlatform] = std::isfinite(q[kPlatform]) ? q[kPlatform] : platform;
  for (Eigen::Index k = kPlatform; k < n_; ++k) {
    const double reach = ratio_v_ * spec_.v_max[k] * dt;
    order_.by_torque[static_cast<std::size_t>(k)] = false;
    order_.q[k] += std::clamp(q[k] - order_.q[k], -reach, reach);
    order_.tau[k] = feed_forward()[k];
  }
}

}  // namespace palpate::dvrk
