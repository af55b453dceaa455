// Force without a sensor: what the environment does to an arm, from the torques of its drives.
#pragma once

#include "palpate/arm/arm.hpp"
#include "palpate/types/arms.hpp"

namespace palpate::force {

/// Generalised momentum observer (De Luca, Albu-Schaeffer, Haddadin and Hirzinger, IROS 2006):
///
///   p = (M(q) + I_d) v,   r = k (p - p_0 - int (tau + dM/dt v - C v - G - E + r) dt),   dr/dt = k (J^T F - r)
///
/// so that r follows the joint torque of the environment as a first-order filter would, without accelerations. E is
/// the counterbalance. Joint coordinates; everything noexcept is allocation free.
class MomentumObserver {
 public:
  /// drive_inertia: I_d (n, n), of the rotors, seen at the joints [kg m^2, kg]; bandwidth: k / 2 pi [Hz].
  /// Throws std::invalid_argument naming the option, its value and the mend.
  MomentumObserver(arm::Arm model, JointMatrix drive_inertia, double bandwidth);

  /// Forgets; the next step starts at r = 0.
  void reset() noexcept { started_ = false; }
  /// dt [s] after the last sample, implicit: stable for any. tau: of the drives on the joints, what friction eats taken
  /// off [N m, N]. Returns r (n,); zero, and begins anew, where numbers are not finite.
  const JointVector& step(const JointVector& q, const JointVector& v, const JointVector& tau, double dt) noexcept;
  [[nodiscard]] arm::Arm& model() noexcept { return model_; }

 private:
  [[nodiscard]] JointVector momentum(const JointVector& q, const JointVector& v) noexcept;

  arm::Arm model_;
  JointMatrix drive_inertia_;
  double k_;
  bool started_ = false;
  JointVector r_, integral_, push_;
};

struct EstimateOptions {
  double bandwidth = 20.0;   ///< of the observer [Hz]
  double dead_band = 0.0;    ///< forces below it are not told: friction that the model does not know [N]
  double slip_speed = 0.01;  ///< of the drives' speed limits: dry friction is full above it [-]
  // Of the drives, at the joints; zero when left out: tau = ... + coulomb sign(v) + viscous v + offset + spring q
  JointVector rotor_inertia, coulomb, viscous, offset, spring;
  Eigen::VectorXd links;  ///< identified inertial parameters (10n,); empty: those of the arm's own model
};

/// The force on the tool tip that explains the observer's torques best: r = J_v^T F, each joint weighed by what its
/// drive can do. The environment is taken to push at the tip, without a moment.
class Estimate {
 public:
  /// Throws std::invalid_argument naming the option, its value and the mend.
  Estimate(const arm::Arm& model, EstimateOptions options);
  void reset() noexcept { observer_.reset(); }
  /// Does the state say torques and velocities, below ten times what the drives can?
  [[nodiscard]] bool believes(const FollowerState& state) const noexcept;
  /// The newest state: F_T_B, of the environment on the tool, in the arm's base [N]. Zero while it is not believed. A
  /// state as old as the last one changes nothing; after a gap longer than 0.1 s it begins anew.
  const Vec3& step(const FollowerState& state) noexcept;

 private:
  EstimateOptions options_;
  MomentumObserver observer_;
  JointVector weight_, slip_, tau_beyond_, v_beyond_;
  double t_ = 0.0;  ///< of the last state [s]
  Vec3 F_T_B_ = Vec3::Zero();
};

}  // namespace palpate::force
