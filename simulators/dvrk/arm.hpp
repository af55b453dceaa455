// One arm of the simulated dVRK, with the operating states, control modes and commands of the real component
// (sawIntuitiveResearchKit 2.4). An arm is composed of three parts around a simulated body:
//
//   StateMachine   power, homing, pause and fault
//   Controller     what the arm orders from its joint servos
//   Reporter       what the arm publishes
#pragma once

#include <numbers>
#include <optional>

#include "dvrk/arm_context.hpp"
#include "dvrk/controller.hpp"
#include "dvrk/gripper.hpp"
#include "dvrk/reporter.hpp"
#include "dvrk/setup_joints.hpp"
#include "dvrk/state_machine.hpp"

namespace palpate::dvrk {

/// A simulated arm.
class SimulatedArm {
 public:
  /// Throws std::invalid_argument naming the arm, the option and the remedy.
  SimulatedArm(ArmSpec spec, Address at, Outbox& out);
  SimulatedArm(const SimulatedArm&) = delete;
  SimulatedArm& operator=(const SimulatedArm&) = delete;

  void start() noexcept;                        ///< publishes the first states
  bool apply(const Command& command) noexcept;  ///< applies a command; false if the arm has no such verb
  void run(double t, double dt) noexcept;       ///< one servo period of dt, which ends at t [s]
  void step(double dt) noexcept;                ///< advances the simulated body; called more often than run()

  [[nodiscard]] Controller& controller() noexcept { return controller_; }
  /// The setup joints that carry the arm; nullptr for an MTM.
  [[nodiscard]] SetupJoints* setup() noexcept { return setup_ ? &*setup_ : nullptr; }
  void state_command(std::string_view command) noexcept { states_.command(command); }

  [[nodiscard]] const ArmSpec& spec() const noexcept { return context_.spec; }
  [[nodiscard]] arm::Arm& model() noexcept { return context_.model; }
  /// The published state.
  [[nodiscard]] const ArmState& state() const noexcept { return context_.state; }
  /// True joint positions and velocities, and the torques of the drives.
  [[nodiscard]] JointState truth() const noexcept { return context_.body->truth(); }
  [[nodiscard]] const Instrument& instrument() const noexcept { return context_.instrument; }
  /// Pose of the arm's own base in the frame of measured_cp.
  [[nodiscard]] const Pose& base_frame() const noexcept { return context_.base_frame; }
  /// True if the arm is enabled and homed.
  [[nodiscard]] bool ready() const noexcept { return states_.homed() && state().operating_state.is_homed; }
  [[nodiscard]] int errors() const noexcept { return context_.errors; }  ///< number of errors reported so far
  [[nodiscard]] const Text& last_error() const noexcept { return context_.last_error; }

 private:
  static constexpr double kGripperOpen = std::numbers::pi / 3.0;  ///< angle of a released gripper [rad]

  bool apply_hardware(const Command& command) noexcept;
  bool apply_hand(const Command& command) noexcept;
  void press_clutch(int button) noexcept;
  void set_endoscope_type(const Text& type) noexcept;

  ArmContext context_;
  std::optional<SetupJoints> setup_;
  Controller controller_;
  StateMachine states_;
  Reporter reporter_;
  Gripper gripper_;
  Surroundings around_;
  double pinch_ = kGripperOpen;  ///< angle of the gripper [rad]
};

}  // namespace palpate::dvrk
