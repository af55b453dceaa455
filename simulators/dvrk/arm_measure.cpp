// What an arm tells: joints, poses, velocities and wrenches, in the frames of the real one.
#include "dvrk/arm.hpp"

namespace palpate::dvrk {
namespace {

Jacobian turned(const Mat3& R, const Jacobian& J) noexcept {
  Jacobian turned_J(6, J.cols());
  for (Eigen::Index k = 0; k < J.cols(); ++k) {
    turned_J.col(k).head<3>() = R * J.col(k).head<3>();
    turned_J.col(k).tail<3>() = R * J.col(k).tail<3>();
  }
  return turned_J;
}

/// Columns are then velocities of the point of the tip's body that passes the base's origin.
Jacobian about_base(const Jacobian& J, const Vec3& p) noexcept {
  Jacobian about = J;
  for (Eigen::Index k = 0; k < J.cols(); ++k) about.col(k).head<3>() += p.cross(J.col(k).tail<3>());
  return about;
}

Twist velocity(const Jacobian& J, const JointVector& v) noexcept {
  const Vec6 V = J * v;
  return {V.head<3>(), V.tail<3>()};
}

Twist turned(const Mat3& R, const Twist& V) noexcept { return {R * V.v, R * V.w}; }

/// The wrench that the joint torques amount to: least squares of J^T F = tau, as the real one's pseudoinverse.
Wrench wrench_of(const Jacobian& J, const JointVector& tau) noexcept {
  Mat6 A = J * J.transpose();
  A.diagonal().array() += 1e-9;
  const Vec6 b = J * tau, F = A.ldlt().solve(b);
  return {F.head<3>(), F.tail<3>()};
}

}  // namespace

void Arm::measure() noexcept {
  const JointState& body = body_->measured();
  state_.t = voice_.t();
  state_.joints_valid = is_joint_ready();
  state_.cartesian_valid = is_cartesian_ready();
  state_.orientation_locked = locked_;
  state_.gripper.q[0] = pinch_;
  state_.jaw_valid = spec_.kind == ArmKind::psm && is_cartesian_ready();
  state_.jaw_measured_js = instrument_.measured();
  state_.jaw_setpoint_js = instrument_.setpoint();
  state_.F_hand = {base_frame_.R * body_->F_hand().f, base_frame_.R * body_->F_hand().t};
  if (!state_.joints_valid) {
    const JointVector zero = JointVector::Zero(n_);
    state_.measured_js = state_.setpoint_js = {zero, zero, zero};
    state_.gravity_compensation = zero;
    return;
  }
  state_.measured_js = body;
  state_.setpoint_js = body;
  for (Eigen::Index k = 0; order_.on && k < n_; ++k) {
    if (order_.by_torque[static_cast<std::size_t>(k)]) {
      state_.setpoint_js.v[k] = 0.0;  // in torque control the setpoint is where the joint is
    } else {
      state_.setpoint_js.q[k] = order_.q[k];
      state_.setpoint_js.v[k] = order_.v[k];
    }
  }
  const bool use = gravity_compensation_ && spec_.has_gravity_model;
  state_.gravity_compensation = use ? model_.holding(body.q) : JointVector::Zero(n_);
  if (state_.cartesian_valid) measure_cartesian();
}

void Arm::measure_cartesian() noexcept {
  model_.update(state_.setpoint_js.q, state_.setpoint_js.v);
  state_.local_setpoint_cp = model_.tip();
  state_.setpoint_cp = base_frame_ * model_.tip();

  model_.update(state_.measured_js.q, state_.measured_js.v);
  const Pose& X = model_.tip();
  state_.local_measured_cp = X;
  state_.measured_cp = base_frame_ * X;
  state_.body_jacobian = turned(X.R.transpose(), model_.jacobian());
  state_.spatial_jacobian = about_base(model_.jacobian(), X.p);

  // Both velocities by the Jacobian of where the arm is, as the real one's.
  state_.local_measured_cv = velocity(state_.body_jacobian, state_.measured_js.v);
  state_.measured_cv = turned(state_.measured_cp.R, state_.local_measured_cv);
  state_.local_setpoint_cv = velocity(state_.body_jacobian, state_.setpoint_js.v);
  state_.setpoint_cv = turned(state_.setpoint_cp.R, state_.local_setpoint_cv);

  const JointVector& tau = state_.measured_js.tau;
  const Wrench F_tip = wrench_of(state_.body_jacobian, tau);
  const Mat3& R = state_.measured_cp.R;
  state_.measured_cf = {R * F_tip.f, R * F_tip.t};
  state_.body_measured_cf = absolute_ ? state_.measured_cf : F_tip;
  state_.spatial_measured_cf = wrench_of(state_.spatial_jacobian, tau);
}

}  // namespace palpate::dvrk
