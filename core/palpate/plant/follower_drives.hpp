// A follower whose joints are moved by drives with torques, so that what touches the tool is felt by them:
//   M a + C v + G + friction = tau + J^T F,   tau = C v + G + D (w^2 (q_goal - q) - 2 zeta w v),   |tau| <= tau_max
// with D the inertia that each drive sees: the same servo as the kinematic one, with a body. Goals come in steps, the
// drives go from each to the next in a straight line over as long as the last one took to come.
#pragma once

#include "palpate/arm/arm.hpp"
#include "palpate/plant/dry_friction.hpp"
#include "palpate/plant/encoders.hpp"

namespace palpate::plant {

/// Facts of the hardware, at the joints.
struct DriveOptions {
  JointVector coulomb;        ///< Fc [N m, N]
  JointVector viscous;        ///< Fv [N m s/rad, N s/m]
  JointVector rotor_inertia;  ///< [kg m^2, kg]
};

class FollowerDrives {
 public:
  /// Throws std::invalid_argument naming the option, its value and the remedy.
  FollowerDrives(arm::Arm arm, DriveOptions options, double natural_frequency, double damping_ratio,
                 const JointVector& encoder_step);
  void reset(const JointVector& q) noexcept;
  /// A new goal, `period` after the one before [s].
  void aim(const JointVector& q_goal, double period) noexcept;
  /// One servo period. F_T_B: of the environment on the tip, in the base.
  void step(double dt, const Wrench& F_T_B) noexcept;

  [[nodiscard]] const JointVector& q() const noexcept { return q_; }      ///< truth
  [[nodiscard]] const JointVector& v() const noexcept { return v_; }      ///< truth
  [[nodiscard]] const JointVector& tau() const noexcept { return tau_; }  ///< of the drives in the last period [N m, N]
  [[nodiscard]] const Encoders& encoders() const noexcept { return encoders_; }
  [[nodiscard]] const Pose& tip() const noexcept { return arm_.tip(); }  ///< X_BT at q()
  [[nodiscard]] Twist twist() const noexcept { return arm_.twist(); }    ///< of the tip, in B

 private:
  arm::Arm arm_;
  DriveOptions options_;
  double w_, zeta_;
  Encoders encoders_;
  DryFriction friction_;
  JointVector q_, v_, tau_;
  JointVector goal_, goal_v_;  ///< on the way to the newest goal, and how fast
  double left_ = 0.0;          ///< of that way [s]
};

}  // namespace palpate::plant
