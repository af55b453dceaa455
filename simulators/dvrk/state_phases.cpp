// The servo period of an arm in each phase of its state machine.
#include <array>
#include <cmath>
#include <numbers>

#include "dvrk/state_machine.hpp"

namespace palpate::dvrk {
namespace {

constexpr double kSettle = 0.4;         // [s] time for which homing holds an arm that was falling before it moves
constexpr double kHomingTimeout = 2.0;  // [s] after the end of the trajectory to the home position
constexpr double kPastCannula = 0.025;  // [m] insertion from which a tool is engaged without motion of its disks
constexpr Eigen::Index kDisks = 3;      // first joint of a PSM that the disks of its tool drive
constexpr std::array<double, 3> kEngage{-std::numbers::pi / 6, std::numbers::pi / 6,
                                        0.0};                        // [rad] motions of the disks (our values)
constexpr double kHomingTolerance = 4.0 * std::numbers::pi / 180.0;  // [rad]

}  // namespace

void StateMachine::run(double dt) noexcept {
  in_phase_ += dt;
  switch (phase_) {
    case Phase::disabled:
      if (desired_ != Phase::disabled) enter(Phase::powering);
      break;
    case Phase::powering:
      if (in_phase_ < arm_.spec.power_time) break;
      arm_.status("power on");
      enter(Phase::enabled);
      break;
    case Phase::enabled:
      if (desired_ != Phase::enabled) enter(Phase::calibrating);
      break;
    case Phase::calibrating:
      run_calibrating();
      break;
    case Phase::homing:
      run_homing(dt);
      check_tracking();
      break;
    case Phase::homed:
      run_homed(dt);
      break;
    case Phase::engaging:
      run_engaging(dt);
      check_tracking();
      break;
    case Phase::paused:
    case Phase::fault:
      break;
  }
}

void StateMachine::run_calibrating() noexcept {
  if (!arm_.biased && in_phase_ < arm_.spec.bias_time) return;
  if (!arm_.biased) arm_.status("encoders biased using potentiometer values");
  arm_.biased = true;
  enter(Phase::homing);
}

void StateMachine::run_homing(double dt) noexcept {
  if (settling_) {
    if (in_phase_ < kSettle) return;
    settling_ = false;
    controller_.start_path(arm_.spec.home);
  }
  if (controller_.path_active()) {
    controller_.follow_path(dt, false);
    in_phase_ = 0.0;  // the timeout begins when the trajectory has ended
    return;
  }
  const JointVector error = arm_.spec.home - arm_.body->measured().q;
  if ((error.cwiseAbs().array() < kHomingTolerance).all()) return enter(Phase::homed);
  if (in_phase_ > kHomingTimeout) fault("unable to reach home position during calibration on pots");
}

void StateMachine::run_homed(double dt) noexcept {
  if (arm_.spec.kind == ArmKind::psm && arm_.biased) engage();
  if (phase_ != Phase::homed) return;
  arm_.set_busy(arm_.state.operating_state.is_busy);  // publishes a change of is_homed
  const Text reason = controller_.control(dt);
  if (!reason.empty()) return fault(reason);
  check_tracking();
}

// Engages a tool. The disks of a newly mounted tool are turned to and fro, unless the tool is past the cannula already.
void StateMachine::engage() noexcept {
  Instrument& instrument = arm_.instrument;
  if (!instrument.can_engage()) return;
  if (!instrument.newly_mounted()) return instrument.engage(arm_.publisher);
  if (arm_.body->measured().q[kDisks - 1] < kPastCannula) return enter(Phase::engaging);
  arm_.status("tool tip is outside the cannula, assuming it doesn't need to \"engage\"");
  instrument.engage(arm_.publisher);
}

void StateMachine::run_engaging(double dt) noexcept {
  if (!arm_.instrument.can_engage()) return enter(Phase::homed);  // the tool was removed
  if (controller_.path_active()) return controller_.follow_path(dt, arm_.is_homed());
  if (engaging_ == static_cast<int>(kEngage.size())) {
    arm_.instrument.engage(arm_.publisher);
    return enter(Phase::homed);
  }
  JointVector goal = controller_.order().q;
  goal.tail(goal.size() - kDisks).setConstant(kEngage[static_cast<std::size_t>(engaging_)]);
  controller_.start_path(goal);
  Text words("engaging tool ");
  words << static_cast<long>(++engaging_) << " of " << static_cast<long>(kEngage.size());
  arm_.status(words);
}

void StateMachine::check_tracking() noexcept {
  if (settling_) return;
  const Text reason = controller_.tracking_fault();
  if (!reason.empty()) fault(reason);
}

}  // namespace palpate::dvrk
