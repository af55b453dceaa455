#include "dvrk/state_machine.hpp"

#include <algorithm>
#include <array>

namespace palpate::dvrk {
namespace {

/// True if an operating state accepts the command. DISABLED accepts those of ENABLED, as on the real arm.
bool accepts(State state, std::string_view command) noexcept {
  if (command == "disable" || command == "unhome") return true;
  switch (state) {
    case State::DISABLED:
    case State::ENABLED:
      return command == "enable" || command == "home" || command == "pause";
    case State::PAUSED:
      return command == "pause" || command == "resume";
    case State::FAULT:
      break;
  }
  return false;
}

}  // namespace

std::string_view StateMachine::name_of(Phase phase) noexcept {
  constexpr std::array<std::string_view, 9> kNames{
      "DISABLED", "POWERING", "ENABLED",      "CALIBRATING_ENCODERS_FROM_POTS", "HOMING", "HOMED",
      "PAUSED",   "FAULT",    "ENGAGING_TOOL"};
  return kNames[static_cast<std::size_t>(phase)];
}

void StateMachine::start() noexcept {
  arm_.set_operating(State::DISABLED, false);
  set_desired(Phase::disabled);
}

void StateMachine::publish() const noexcept {
  arm_.publisher.text(Topic::current_state, name_of(phase_));
  arm_.publisher.text(Topic::desired_state, name_of(desired_));
  arm_.publisher.operating(arm_.state.operating_state);
}

void StateMachine::fault(const Text& words) noexcept {
  arm_.error(words);
  set_desired(Phase::fault);
}

void StateMachine::command(std::string_view command) noexcept {
  constexpr std::array<std::string_view, 6> kCommands{"enable", "disable", "home", "unhome", "pause", "resume"};
  const State state = arm_.state.operating_state.state;
  Text words;
  if (std::find(kCommands.begin(), kCommands.end(), command) == kCommands.end()) {
    words << command << " doesn't seem to be a valid state_command (enable, disable, home, unhome, pause or resume)";
    return arm_.warning(words);
  }
  if (!accepts(state, command)) {
    words << "command \"" << command << "\" is not supported in state \"" << dvrk::name_of(state) << " ("
          << name_of(phase_) << ")\"";
    return arm_.warning(words);
  }
  if (command == "enable") return set_desired(Phase::enabled);
  if (command == "disable") return set_desired(Phase::disabled);
  if (command == "home") return set_desired(Phase::homed);
  if (command == "pause") return set_desired(Phase::paused);
  if (command == "unhome") return unhome();
  resume();
}

void StateMachine::resume() noexcept {
  desired_ = paused_desired_;
  enter(paused_phase_);
}

void StateMachine::unhome() noexcept {
  arm_.biased = false;
  arm_.instrument.release();
  const OperatingState& now = arm_.state.operating_state;
  arm_.set_operating(now.state, now.is_busy);
}

void StateMachine::set_desired(Phase phase) noexcept {
  const Phase before = desired_;
  desired_ = phase;
  publish();
  Text words("desired state ");
  words << name_of(phase);
  arm_.status(words);
  if (phase == Phase::paused && phase_ != Phase::paused) {
    paused_phase_ = phase_;
    paused_desired_ = before;
  }
  const bool direct = phase == Phase::disabled || phase == Phase::paused || phase == Phase::fault;
  if (direct && phase_ != phase) enter(phase);
  if (phase == Phase::homed && phase_ == Phase::homed && !arm_.biased) enter(Phase::calibrating);
}

void StateMachine::power(bool on) noexcept {
  arm_.powered = on;
  settling_ = false;
  controller_.reset();
}

void StateMachine::enter(Phase phase) noexcept {
  if (phase_ == Phase::homed) controller_.set_mode(Space::undefined, Mode::undefined);  // the servos keep their order
  phase_ = phase;
  in_phase_ = 0.0;
  controller_.block(phase == Phase::engaging);
  begin(phase);
  publish();
  Text words("current state ");
  words << name_of(phase_);
  arm_.status(words);
}

void StateMachine::begin(Phase phase) noexcept {
  switch (phase) {
    case Phase::disabled:
      power(false);
      return arm_.set_operating(State::DISABLED, false);
    case Phase::powering:
      power(false);
      arm_.set_operating(State::DISABLED, true);
      return arm_.status("power requested");
    case Phase::enabled:
      power(true);
      return arm_.set_operating(State::ENABLED, false);
    case Phase::calibrating:
      arm_.set_operating(State::ENABLED, true);
      if (arm_.biased) arm_.status("encoders have already been calibrated, skipping");
      return;
    case Phase::homing:
      arm_.set_operating(State::ENABLED, true);
      controller_.set_mode(Space::joint, Mode::trajectory);
      settling_ = true;
      return controller_.order_rest(arm_.body->measured().q, false);
    case Phase::homed:
      arm_.set_operating(State::ENABLED, false);
      return controller_.rest();
    case Phase::engaging:
      arm_.set_operating(State::ENABLED, true);
      controller_.set_mode(Space::joint, Mode::trajectory);
      engaging_ = 0;
      return;
    case Phase::paused:
      return arm_.set_operating(State::PAUSED, false);
    case Phase::fault:
      power(false);
      return arm_.set_operating(State::FAULT, false);
  }
}

}  // namespace palpate::dvrk
