// Stage `torque`: joint torques that render a force and hold the arm's own weight (READINGS 3, Eq 13 in joint space).
#pragma once

#include "palpate/arm/arm.hpp"
#include "palpate/types/arms.hpp"

namespace palpate::torque {

enum class Mode { full, paper };  ///< paper: first three joints only, wrist torques exactly zero (section 2.3)

struct Options {
  Mode mode = Mode::full;
  double gravity_gain = 1.0;   ///< 0 switches gravity compensation off
  double platform_gain = 0.5;  ///< joint-4 null-space controller of the dVRK, 0..1
};

/// tau = tau_force + tau_gravity + tau_platform. `model` is the controller's, updated at q, v by the caller.
class Torque {
 public:
  Torque(Options options, JointVector tau_max);
  /// F_H_L: wrench to render on the hand in L. Returns true when a drive limit was reached (clamped, reported).
  bool step(arm::Arm& model, const JointVector& q, const JointVector& v, const Wrench& F_H_L,
            LeaderCommand& out) noexcept;

 private:
  Options options_;
  JointVector tau_max_;
};

}  // namespace palpate::torque
