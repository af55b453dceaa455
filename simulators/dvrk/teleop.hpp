// Teleoperation of a PSM by an MTM, at 1 kHz, with the state machine and the laws of the real component
// (mtsTeleOperationPSM):
//   p_PSM = p_PSM0 + scale (p_MTM - p_MTM0),   R_PSM = R_MTM R_offset,   R_offset = R_MTM0^T R_PSM0
// The reference poses (index 0) are taken whenever following begins, so that the PSM does not jump.
#pragma once

#include "dvrk/arm.hpp"

namespace palpate::dvrk {

/// Teleoperation of a PSM by an MTM.
class Teleop {
 public:
  /// Keeps the addresses of the arms. Throws std::invalid_argument naming the invalid option.
  Teleop(const TeleopSpec& spec, SimulatedArm& mtm, SimulatedArm& psm, Address at, Outbox& out);

  void start() noexcept;                                  ///< publishes the first states
  bool apply(const Command& command) noexcept;            ///< applies a command; false if a teleop has no such verb
  void run(double t, double dt) noexcept;                 ///< one period of dt, which ends at t [s]
  void clutch(int button) noexcept;                       ///< 0 released, 1 pressed, 2 tapped
  void state_command(std::string_view command) noexcept;  ///< enable, disable or align_MTM
  void set_scale(double scale) noexcept;

  [[nodiscard]] const Text& name() const noexcept { return publisher_.name(); }
  [[nodiscard]] const TeleopState& state() const noexcept { return state_; }

 private:
  enum class Phase : unsigned char { disabled, setting_arms_state, aligning_mtm, enabled };
  static std::string_view name_of(Phase phase) noexcept;

  void set_desired(Phase phase) noexcept;
  void enter(Phase phase) noexcept;
  void enter_enabled() noexcept;
  void check_arms() noexcept;
  void wait_for_arms() noexcept;
  void align() noexcept;
  void watch_operator() noexcept;
  void follow() noexcept;
  void follow_jaw(double dt) noexcept;
  void set_following(bool following) noexcept;
  void press_clutch() noexcept;
  void store_reference_poses() noexcept;
  void lock_rotation(bool lock) noexcept;
  void set_align(bool align) noexcept;
  void error(const Text& words) noexcept;
  [[nodiscard]] double jaw_of(double gripper) const noexcept;
  [[nodiscard]] double gripper_of(double jaw) const noexcept;

  TeleopSpec spec_;
  SimulatedArm *mtm_, *psm_;
  EventPublisher publisher_;
  TeleopState state_;
  Phase phase_ = Phase::disabled, desired_ = Phase::disabled;
  double in_phase_ = 0.0, since_goal_ = 0.0;
  int mtm_errors_ = 0, psm_errors_ = 0;
  bool clutched_ = false, back_from_clutch_ = false;
  bool active_ = false, active_before_clutch_ = false;  ///< active: the operator has shown readiness
  double roll_min_ = 0.0, roll_max_ = 0.0, gripper_min_ = 0.0, gripper_max_ = 0.0;
  Pose X_mtm0_, X_psm0_;
  Mat3 R_offset0_ = Mat3::Identity();
  Wrench F_user_;  ///< following/mtm/body/servo_cf
  bool F_user_valid_ = false;
  double limited_gripper_ = 0.0;  ///< rate-limited gripper angle, which the jaw follows [rad]
  bool jaw_caught_up_ = false;
};

}  // namespace palpate::dvrk
