#include "dvrk/reporter.hpp"

#include "palpate/types/ldlt.hpp"

namespace palpate::dvrk {
namespace {

Jacobian rotated(const Mat3& R, const Jacobian& J) noexcept {
  Jacobian rotated_J(6, J.cols());
  for (Eigen::Index k = 0; k < J.cols(); ++k) {
    rotated_J.col(k).head<3>() = R * J.col(k).head<3>();
    rotated_J.col(k).tail<3>() = R * J.col(k).tail<3>();
  }
  return rotated_J;
}

/// Jacobian of that point of the tip's body which coincides with the origin of the base; p: position of the tip.
Jacobian about_base(const Jacobian& J, const Vec3& p) noexcept {
  Jacobian about = J;
  for (Eigen::Index k = 0; k < J.cols(); ++k) about.col(k).head<3>() += p.cross(J.col(k).tail<3>());
  return about;
}

Twist velocity(const Jacobian& J, const JointVector& v) noexcept {
  const Vec6 V = J * v;
  return {V.head<3>(), V.tail<3>()};
}

Twist rotated(const Mat3& R, const Twist& V) noexcept { return {R * V.v, R * V.w}; }
Wrench rotated(const Mat3& R, const Wrench& F) noexcept { return {R * F.f, R * F.t}; }

/// Wrench equivalent to the joint torques: the least-squares solution of J^T F = tau, like the pseudoinverse of the
/// real component.
Wrench wrench_of(const Jacobian& J, const JointVector& tau) noexcept {
  Mat6 A = J * J.transpose();
  A.diagonal().array() += 1e-9;
  const Vec6 F = solve_ldlt(A, J * tau);
  return {F.head<3>(), F.tail<3>()};
}

}  // namespace

void Reporter::measure(double gripper) noexcept {
  ArmState& state = arm_.state;
  state.t = arm_.publisher.t();
  state.joints_valid = arm_.is_joint_ready();
  state.cartesian_valid = arm_.is_cartesian_ready();
  state.orientation_locked = controller_.orientation_locked();
  state.gripper.q[0] = gripper;
  state.jaw_valid = arm_.spec.kind == ArmKind::psm && arm_.is_cartesian_ready();
  state.jaw_measured_js = arm_.instrument.measured();
  state.jaw_setpoint_js = arm_.instrument.setpoint();
  state.base_frame = arm_.base_frame;
  state.F_hand = rotated(arm_.base_frame.R, arm_.body->F_hand());
  if (state.joints_valid) {
    measure_joints();
    if (state.cartesian_valid) measure_cartesian();
    return;
  }
  const JointVector zero = JointVector::Zero(arm_.n());
  state.measured_js = state.setpoint_js = {zero, zero, zero};
  state.gravity_compensation = zero;
}

void Reporter::measure_joints() noexcept {
  ArmState& state = arm_.state;
  const Order& order = controller_.order();
  state.measured_js = state.setpoint_js = arm_.body->measured();
  for (Eigen::Index k = 0; order.on && k < arm_.n(); ++k) {
    if (order.by_torque[static_cast<std::size_t>(k)]) {
      state.setpoint_js.v[k] = 0.0;  // in torque control the setpoint is the measured position
    } else {
      state.setpoint_js.q[k] = order.q[k];
      state.setpoint_js.v[k] = order.v[k];
    }
  }
  state.gravity_compensation =
      controller_.compensates_gravity() ? arm_.model.holding(state.measured_js.q) : JointVector::Zero(arm_.n());
}

void Reporter::measure_cartesian() noexcept {
  ArmState& state = arm_.state;
  arm_.model.update(state.setpoint_js.q, state.setpoint_js.v);
  state.local_setpoint_cp = arm_.model.tip();
  state.setpoint_cp = arm_.base_frame * arm_.model.tip();

  arm_.model.update(state.measured_js.q, state.measured_js.v);
  const Pose& X = arm_.model.tip();
  state.local_measured_cp = X;
  state.measured_cp = arm_.base_frame * X;
  state.body_jacobian = rotated(X.R.transpose(), arm_.model.jacobian());
  state.spatial_jacobian = about_base(arm_.model.jacobian(), X.p);

  // Both velocities use the Jacobian at the measured joints, as the real component does.
  state.local_measured_cv = velocity(state.body_jacobian, state.measured_js.v);
  state.measured_cv = rotated(state.measured_cp.R, state.local_measured_cv);
  state.local_setpoint_cv = velocity(state.body_jacobian, state.setpoint_js.v);
  state.setpoint_cv = rotated(state.setpoint_cp.R, state.local_setpoint_cv);

  const JointVector& tau = state.measured_js.tau;
  const Wrench F_tip = wrench_of(state.body_jacobian, tau);
  state.measured_cf = rotated(state.measured_cp.R, F_tip);
  state.body_measured_cf = controller_.forces_in_base_axes() ? state.measured_cf : F_tip;
  state.spatial_measured_cf = wrench_of(state.spatial_jacobian, tau);
}

}  // namespace palpate::dvrk
