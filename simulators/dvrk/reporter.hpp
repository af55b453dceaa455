// The reporter of an arm fills the state that the arm publishes: joints, poses, velocities and wrenches, in the frames
// that the real component uses.
#pragma once

#include "dvrk/arm_context.hpp"
#include "dvrk/controller.hpp"

namespace palpate::dvrk {

/// Fills the published state of an arm.
class Reporter {
 public:
  /// Keeps the addresses of both.
  Reporter(ArmContext& arm, const Controller& controller) : arm_(arm), controller_(controller) {}

  /// Updates the published state. gripper: measured angle of an MTM's gripper [rad].
  void measure(double gripper) noexcept;

 private:
  void measure_joints() noexcept;
  void measure_cartesian() noexcept;

  ArmContext& arm_;
  const Controller& controller_;
};

}  // namespace palpate::dvrk
