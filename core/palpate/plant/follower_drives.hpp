// A follower whose joints are moved by drives with torques, so that contacts of the tool act on the joints:
//   M a + C v + G + friction = tau + J^T F,   tau = C v + G + D (w^2 (q_goal - q) - 2 zeta w v),   |tau| <= tau_max
// with D the inertia that each drive sees. The servo is that of the kinematic follower, with a body. Between two goals
// the set point moves in a straight line, in as much time as passed between the last two goals.
#pragma once

#include "palpate/arm/arm.hpp"
#include "palpate/plant/dry_friction.hpp"
#include "palpate/plant/encoders.hpp"

namespace palpate::plant {

/// Properties of the hardware, at the joints.
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
  /// Takes a new goal, `period` after the previous one [s].
  void aim(const JointVector& q_goal, double period) noexcept;
  /// One servo period. F_T_B: wrench of the environment on the tip, in the base B.
  void step(double dt, const Wrench& F_T_B) noexcept;

  [[nodiscard]] const JointVector& q() const noexcept { return q_; }      ///< true positions [rad, m]
  [[nodiscard]] const JointVector& v() const noexcept { return v_; }      ///< true velocities [rad/s, m/s]
  [[nodiscard]] const JointVector& tau() const noexcept { return tau_; }  ///< drive torques of the last period [N m, N]
  [[nodiscard]] const Encoders& encoders() const noexcept { return encoders_; }
  [[nodiscard]] const Pose& tip() const noexcept { return arm_.tip(); }  ///< X_BT at q()
  [[nodiscard]] Twist twist() const noexcept { return arm_.twist(); }    ///< twist of the tip, in B

 private:
  arm::Arm arm_;
  DriveOptions options_;
  double w_, zeta_;
  Encoders encoders_;
  DryFriction friction_;
  JointVector q_, v_, tau_;
  JointVector goal_, goal_v_;  ///< set point on its line to the newest goal, and its velocity
  double left_ = 0.0;          ///< time until the set point reaches the goal [s]
};

}  // namespace palpate::plant
