// Stage `torque`: joint torques that render a force and hold the arm's own weight (READINGS 3, Eq 13 in joint space).
#pragma once

#include "palpate/arm/arm.hpp"
#include "palpate/types/arms.hpp"

namespace palpate::torque {

enum class Mode { full, paper };  ///< paper: first three joints only, wrist torques exactly zero (section 2.3)

struct Options {
  Mode mode = Mode::full;
  double gravity_gain = 1.0;   ///< 0 switches gravity compensation off
  double platform_gain = 0.5;  ///< joint-4 controller of the dVRK, 0..1: 7-joint arms in full mode; it needs a gimbal
};

/// tau = tau_force + tau_gravity + tau_platform, with
///   full:  tau_force = J^T F;      paper: tau_force[0..2] = J_33^T f with the wrist centre's Jacobian, and every
///   term of the wrist joints is exactly zero (the hand holds the wrist).
/// `model` is the controller's, updated at q, v by the caller.
class Torque {
 public:
  /// Throws std::invalid_argument naming the option, its value and the mend.
  Torque(Options options, JointVector tau_max);
  /// F_H_L: wrench to render on the hand in L. Returns true when a drive limit was reached: then the force is scaled
  /// down as a whole, its direction kept, and out.F_H_L is what is truly rendered. Gravity has the first claim.
  bool step(arm::Arm& model, const JointVector& q, const JointVector& v, const Wrench& F_H_L,
            LeaderCommand& out) noexcept;

 private:
  Options options_;
  JointVector tau_max_;
};

}  // namespace palpate::torque
