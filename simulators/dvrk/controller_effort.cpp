// Torque control.
#include <cmath>

#include "dvrk/controller.hpp"
#include "dvrk/impedance.hpp"
#include "dvrk/joints.hpp"
#include "palpate/torque/terms.hpp"

namespace palpate::dvrk {
namespace {

constexpr double kOverCurrent =
    0.1;  // [s] a torque above its limit for longer is a fault (our value, not the real one)
constexpr double kOrientationError = 0.1;  // [rad] an inverse-kinematics solution with a larger error is not used

}  // namespace

// Joint torques of the commanded torques or wrench. A command has no timeout.
JointVector Controller::effort() const noexcept {
  if (space_ == Space::joint) return bounded(effort_.tau);
  const ArmState& state = arm_.state;
  Wrench F{bounded(effort_.F.f), bounded(effort_.F.t)};
  if (effort_.kind == Cf::spatial) return joint_torque(state.spatial_jacobian, F);
  if (effort_.kind == Cf::impedance) {
    F = impedance_wrench(effort_.impedance, state.measured_cp, state.measured_cv);
    F = {bounded(F.f), bounded(F.t)};
  }
  if (absolute_) F = {state.measured_cp.R.transpose() * F.f, state.measured_cp.R.transpose() * F.t};
  return joint_torque(state.body_jacobian, F);
}

// Checks the requested torques, as the real arm checks its currents: in torque control there is no tracking error to
// check.
Text Controller::current_fault(const JointVector& tau, double dt) noexcept {
  for (Eigen::Index k = 0; k < n_; ++k) {
    double& over = over_current_[static_cast<std::size_t>(k)];
    over = std::abs(tau[k]) > arm_.model.tau_max()[k] ? over + dt : 0.0;
    if (over <= kOverCurrent) continue;
    over_current_.fill(0.0);
    Text words("received [");
    words << arm_.spec.name << "-IO: requested effort is too large on joint "
          << arm_.model.joint_names()[static_cast<std::size_t>(k)] << ", requested " << tau[k] << ", limit "
          << arm_.model.tau_max()[k] << "]";
    return words;
  }
  return {};
}

Text Controller::run_effort(double dt) noexcept {
  const bool locked = locked_ && space_ == Space::cartesian;
  const JointVector ordered = order_.q;
  const bool was_locked = locked && order_.on && !order_.by_torque[kPlatformJoint];
  order_.on = true;
  order_.by_torque.fill(true);
  order_.q = arm_.body->measured().q;
  order_.v = JointVector::Zero(n_);
  JointVector tau = effort();
  const Text fault = current_fault(tau, dt);
  if (!fault.empty()) return fault;
  const ArmState& state = arm_.state;
  if (arm_.spec.kind == ArmKind::mtm && space_ == Space::cartesian && effort_.kind != Cf::spatial) {
    tau[kPlatformJoint] += torque::platform(arm_.spec.platform_gain, state.measured_js.q, state.measured_js.v);
  }
  order_.tau = tau + feed_forward();
  if (!locked) return {};
  if (was_locked) order_.q.tail(n_ - kPlatformJoint) = ordered.tail(n_ - kPlatformJoint);
  hold_orientation(dt);
  return {};
}

// Orders the gimbal's joints by position and at limited speed to the locked orientation at the measured position.
void Controller::hold_orientation(double dt) noexcept {
  JointVector q = arm_.state.measured_js.q;
  q.tail(n_ - kPlatformJoint) = order_.q.tail(n_ - kPlatformJoint);
  const double platform = q[kPlatformJoint];
  const double error = arm_.model.ik({R_locked_, arm_.state.local_measured_cp.p}, q).orientation_error;
  if (error > kOrientationError) q.tail(n_ - kPlatformJoint) = order_.q.tail(n_ - kPlatformJoint);
  q[kPlatformJoint] = std::isfinite(q[kPlatformJoint]) ? q[kPlatformJoint] : platform;
  const JointVector gravity = feed_forward();
  for (Eigen::Index k = kPlatformJoint; k < n_; ++k) {
    const double step = ratio_v_ * arm_.spec.v_max[k] * dt;
    order_.by_torque[static_cast<std::size_t>(k)] = false;
    order_.q[k] += std::clamp(q[k] - order_.q[k], -step, step);
    order_.tau[k] = gravity[k];
  }
}

}  // namespace palpate::dvrk
