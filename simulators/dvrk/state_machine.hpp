// The state machine of an arm: power, calibration, homing, engaging a tool, pause and fault, with the texts of the real
// component. It decides when the controller runs.
//
//   state_machine.cpp    commands and transitions
//   state_phases.cpp     the servo period in each phase
#pragma once

#include "dvrk/arm_context.hpp"
#include "dvrk/controller.hpp"

namespace palpate::dvrk {

/// Power, homing, pause and fault of an arm.
class StateMachine {
 public:
  /// Keeps the addresses of both.
  StateMachine(ArmContext& arm, Controller& controller) : arm_(arm), controller_(controller) {}

  void start() noexcept;                            ///< publishes the first states
  void command(std::string_view command) noexcept;  ///< a state command, such as enable, home or pause
  void fault(const Text& words) noexcept;           ///< reports an error and goes to the state FAULT
  void run(double dt) noexcept;                     ///< one servo period

  [[nodiscard]] bool homed() const noexcept { return phase_ == Phase::homed; }

 private:
  enum class Phase : unsigned char { disabled, powering, enabled, calibrating, homing, homed, paused, fault, engaging };
  static std::string_view name_of(Phase phase) noexcept;

  void publish() const noexcept;
  void set_desired(Phase phase) noexcept;
  void enter(Phase phase) noexcept;
  void begin(Phase phase) noexcept;
  void resume() noexcept;
  void unhome() noexcept;
  void power(bool on) noexcept;

  void run_calibrating() noexcept;
  void run_homing(double dt) noexcept;
  void run_homed(double dt) noexcept;
  void engage() noexcept;
  void run_engaging(double dt) noexcept;
  void check_tracking() noexcept;

  ArmContext& arm_;
  Controller& controller_;
  Phase phase_ = Phase::disabled, desired_ = Phase::disabled;
  Phase paused_phase_ = Phase::disabled, paused_desired_ = Phase::disabled;
  double in_phase_ = 0.0;  ///< time since the phase was entered [s]
  bool settling_ = false;  ///< homing holds an arm that was falling until it rests
  int engaging_ = 0;       ///< number of motions of a tool's disks started so far
};

}  // namespace palpate::dvrk
