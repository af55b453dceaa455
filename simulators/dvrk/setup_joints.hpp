// Setup joints (SUJ) of a PSM or an ECM: the passive column and linkage that places the arm's base beside the patient.
// Where they stand decides measured_cp of the arm, which is told in the frame of the cart or of a reference arm:
//   measured_cp = X_RC X_CB(q) local/measured_cp,   X_CB(q) = T(q) X_CB(0)
// The linkage is ours: a lift, three joints about the vertical, a tilt and a roll. At q = 0 the base stands where the
// specification of the arm has it.
#pragma once

#include "dvrk/arm_context.hpp"
#include "dvrk/trajectory.hpp"

namespace palpate::dvrk {

/// Pose of the carried base relative to its pose at q = 0, in the cart's frame; q: lift [m], then five angles [rad].
[[nodiscard]] Pose setup_motion(const JointVector& q) noexcept;

/// The setup joints of one arm.
class SetupJoints {
 public:
  static constexpr Eigen::Index kJoints = 6;

  SetupJoints(ArmContext& arm, Address at, Outbox& out);

  void start() noexcept;                                  ///< publishes the first states
  bool apply(const Command& command) noexcept;            ///< applies a command; false if it is none of theirs
  void run(double t, double dt) noexcept;                 ///< one period of dt, which ends at t [s]
  void state_command(std::string_view command) noexcept;  ///< enable, disable, home or unhome
  /// Tells measured_cp of the arm in another frame from now on. X_RC: the cart in the reference arm's tip frame.
  void set_reference(const Pose& X_RC, std::string_view name) noexcept;
  /// Takes a base frame that a client has set for the arm.
  void set_base_frame(const Pose& X_RB) noexcept;
  /// Pose of the arm's base in the frame of the cart.
  [[nodiscard]] const Pose& X_CB() const noexcept { return X_CB_; }

 private:
  void move(const Command& command) noexcept;
  void place() noexcept;
  void set(State state, bool is_busy) noexcept;

  ArmContext& arm_;
  EventPublisher publisher_;
  OperatingState now_{State::DISABLED, true, false};
  Pose X_CB0_, X_CB_, X_RC_;  ///< X_CB0_: of the base at q = 0
  JointVector q_;
  Trajectory path_;
};

}  // namespace palpate::dvrk
