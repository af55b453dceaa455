// Bounds of the torque on the operator's fingers, for leaders whose gripper has a motor.
#pragma once

#include <algorithm>
#include <cmath>

#include "palpate/types/require.hpp"

namespace palpate::stability {

/// Limits the torque to a cap, and its rate so that it takes kRise from zero to the cap.
class GripperLimiter {
 public:
  /// cap: largest torque [N m]; 0: the gripper has no motor. dt: period of the cycle [s]. Throws std::invalid_argument.
  GripperLimiter(double cap, double dt) : cap_(cap), step_(cap * dt / kRise) {
    require("stability", cap >= 0.0 && std::isfinite(cap), "gripper_cap", cap, "must be 0 N m (no motor) or more");
  }
  /// The torque to command in this tick, for the wanted torque [N m]. It is finite for any input.
  double step(double wanted) noexcept {
    const double goal = std::isfinite(wanted) ? std::clamp(wanted, -cap_, cap_) : 0.0;
    return torque_ += std::clamp(goal - torque_, -step_, step_);
  }

 private:
  static constexpr double kRise = 0.05;  // [s]
  double cap_, step_, torque_ = 0.0;
};

}  // namespace palpate::stability
