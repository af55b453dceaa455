// A simulated follower: position-servoed joints (the dVRK's PSM is), each a limited second-order servo
//   qdd = w^2 (q_goal - q) - 2 zeta w qd,   |qd| <= v_max,   q_min <= q <= q_max,
// stepped by its exact solution, so that the result does not depend on the step size. Contacts do not move it; the
// option `driven` adds drives whose torques the contacts act against (follower_drives.hpp).
#pragma once

#include <optional>

#include "palpate/arm/arm.hpp"
#include "palpate/plant/follower_drives.hpp"
#include "palpate/types/arms.hpp"

namespace palpate::plant {

struct FollowerOptions {
  double bandwidth = 30.0;     ///< natural frequency of the joint servos [Hz]; 0 = ideal
  double damping_ratio = 1.0;  ///< 1 = no overshoot
  JointVector v_max;           ///< [rad/s, m/s]
  JointVector encoder_step;    ///< [rad, m]; 0 = ideal
  double jaw_v_max = 12.0;     ///< [rad/s]
  bool driven = false;         ///< joints are moved by drives with torques; contacts of the tool act against them
  DriveOptions drives;         ///< drives of a driven follower
};

class Follower {
 public:
  /// Throws std::invalid_argument naming the option, its value and the remedy.
  Follower(const arm::Arm& model, FollowerOptions options);
  /// Places the follower at rest at q, within the limits.
  void reset(const JointVector& q, double jaw) noexcept;
  /// Takes the newest goal; the servos hold it until the next one. A goal that is not valid or not finite is refused.
  void command(const FollowerCommand& command) noexcept;
  /// One servo period dt [s]. F_T_B: wrench of the environment on the tool, in the base B; it moves a driven follower
  /// only.
  void step(double dt, const Wrench& F_T_B = {}) noexcept;
  /// Drives of a driven follower; null otherwise.
  [[nodiscard]] const FollowerDrives* drives() const noexcept { return drives_ ? &*drives_ : nullptr; }
  [[nodiscard]] const FollowerState& measured() const noexcept;
  [[nodiscard]] const JointVector& v() const noexcept {
    return drives_ ? drives_->v() : v_;
  }  ///< true velocities [rad/s, m/s]

  /// Limits and encoder steps of the joints, zero beyond the last joint.
  struct alignas(64) Joints {
    Lanes v_max, q_min, q_max, step;
  };

 private:
  void discretise(double dt) noexcept;
  void measure() noexcept;

  FollowerOptions options_;
  JointVector q_min_, q_max_, q_, v_;
  std::optional<FollowerDrives> drives_;
  FollowerCommand command_;
  FollowerState measured_;
  Joints joints_;
  double transition_[4]{};  ///< transition matrix of (q - q_goal, qd) over dt_, row by row
  double dt_ = 0.0, t_ = 0.0, jaw_ = 0.0;
  double t_command_ = 0.0;  ///< time of the newest goal [s]
};

}  // namespace palpate::plant
