// Estimate of the environment's force on an arm from the torques of its drives, without a force sensor.
#pragma once

#include "palpate/arm/arm.hpp"
#include "palpate/types/arms.hpp"

namespace palpate::force {

/// Generalised momentum observer (De Luca, Albu-Schaeffer, Haddadin and Hirzinger, IROS 2006):
///
///   p = (M(q) + I_d) v,   r = k (p - p_0 - int (tau + dM/dt v - C v - G - E + r) dt),   dr/dt = k (J^T F - r)
///
/// The residual r is the joint torque of the environment, J^T F, after a first-order low-pass filter; the observer
/// needs no accelerations. E is the torque of the counterbalance. All quantities are in joint coordinates. All noexcept
/// functions are free of allocation.
class MomentumObserver {
 public:
  /// drive_inertia: inertia I_d of the rotors, reflected to the joints (n, n) [kg m^2, kg]. bandwidth: k / 2 pi [Hz].
  /// Throws std::invalid_argument with the name of the option, its value and the remedy.
  MomentumObserver(arm::Arm model, JointMatrix drive_inertia, double bandwidth);

  /// Discards the state of the observer. The next step starts with r = 0.
  void reset() noexcept { started_ = false; }
  /// Integrates one sample, dt [s] after the previous one, by an implicit step that is stable for every dt. tau: drive
  /// torques at the joints minus the joint friction (n,) [N m, N]. Returns r (n,) [N m, N]. If a number is not finite,
  /// r is zero and the observer restarts.
  const JointVector& step(const JointVector& q, const JointVector& v, const JointVector& tau, double dt) noexcept;
  /// The arm model of the observer. Its state may be updated between steps.
  [[nodiscard]] arm::Arm& model() noexcept { return model_; }

 private:
  [[nodiscard]] JointVector momentum(const JointVector& q, const JointVector& v) noexcept;

  arm::Arm model_;
  JointMatrix drive_inertia_;
  double k_;
  bool started_ = false;
  JointVector r_, integral_, p_dot_;
};

/// Options of the force estimate. Joint vectors hold one value per joint (n,), or are empty for zero.
struct EstimateOptions {
  double bandwidth = 20.0;   ///< bandwidth of the observer [Hz]
  double dead_band = 0.0;    ///< reduces the estimate, which is zero below it: covers friction that is not modelled [N]
  double slip_speed = 0.01;  ///< Coulomb friction is nearly full above this fraction of a drive's speed limit [-]
  // Drive parameters at the joints, of tau = ... + coulomb sign(v) + viscous v + offset + spring q.
  JointVector rotor_inertia, coulomb, viscous, offset, spring;
  Eigen::VectorXd links;  ///< identified inertial parameters (10 n,); empty: those of the arm model
};

/// Force on the tool tip that fits the observer's joint torques best in the least-squares sense: r = J_v^T F, with each
/// joint weighted by the inverse of its drive limit. Assumes that the environment acts at the tip and without a moment.
class Estimate {
 public:
  /// Throws std::invalid_argument with the name of the option, its value and the remedy.
  Estimate(const arm::Arm& model, EstimateOptions options);
  /// Discards the state of the observer.
  void reset() noexcept { observer_.reset(); }
  /// Returns true if the state has torques and velocities for all joints, and all of them are below ten times the drive
  /// limits.
  [[nodiscard]] bool is_plausible(const FollowerState& state) const noexcept;
  /// Processes the newest follower state. Returns F_T_B, the force of the environment on the tool in the arm's base
  /// frame B [N]. The force is zero for a state that is_plausible() rejects. A state with the same time stamp as the
  /// last one has no effect. A gap of more than 0.1 s between time stamps restarts the observer.
  const Vec3& step(const FollowerState& state) noexcept;

 private:
  EstimateOptions options_;
  MomentumObserver observer_;
  JointVector weight_, slip_, tau_bound_, v_bound_;
  double t_ = 0.0;  ///< time stamp of the last state [s]
  Vec3 F_T_B_ = Vec3::Zero();
};

}  // namespace palpate::force
