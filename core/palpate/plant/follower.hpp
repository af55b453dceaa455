// A simulated follower: position-servoed joints (the dVRK's PSM is), each a limited second-order servo.
#pragma once

#include "palpate/arm/arm.hpp"
#include "palpate/types/arms.hpp"

namespace palpate::plant {

struct FollowerOptions {
  double bandwidth = 30.0;  ///< natural frequency of the joint servos [Hz]; 0 = ideal
  double damping_ratio = 1.0;
  JointVector v_max;         ///< [rad/s, m/s]
  JointVector encoder_step;  ///< [rad, m]; 0 = ideal
  double jaw_v_max = 12.0;   ///< [rad/s]
};

class Follower {
 public:
  Follower(const arm::Arm& model, FollowerOptions options);
  void reset(const JointVector& q, double jaw) noexcept;
  void command(const FollowerCommand& command) noexcept;
  void step(double dt) noexcept;
  [[nodiscard]] const FollowerState& measured() const noexcept;

 private:
  FollowerOptions options_;
  JointVector q_min_, q_max_, q_, v_;
  FollowerCommand command_;
  FollowerState measured_;
  double t_ = 0.0, jaw_ = 0.0;
};

}  // namespace palpate::plant
