// Operating state of an arm: power, homing, pause and fault, with the words of the real component.
#include <array>
#include <cmath>

#include "dvrk/arm.hpp"

namespace palpate::dvrk {
namespace {

constexpr double kSettle = 0.4;          // [s] of holding an arm that was falling, before it is moved
constexpr double kHomingPatience = 2.0;  // [s] after the trajectory to homing has ended
constexpr double kPastCannula = 0.025;   // [m] of insertion: a tool that is so deep is engaged as it is
constexpr Eigen::Index kDisks = 3;       // joint from which on a PSM's are moved by the disks of its tool
constexpr std::array<double, 3> kEngage{-std::numbers::pi / 6, std::numbers::pi / 6, 0.0};  // OURS: its motions [rad]
constexpr double kHomingTolerance = 4.0 * std::numbers::pi / 180.0;                         // [rad]

/// Which commands an operating state knows. DISABLED knows those of ENABLED as well, as the real one does.
bool knows(State state, std::string_view command) noexcept {
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

std::string_view Arm::name_of(Phase phase) noexcept {
  constexpr std::array<std::string_view, 9> kNames{
      "DISABLED", "POWERING", "ENABLED",      "CALIBRATING_ENCODERS_FROM_POTS", "HOMING", "HOMED",
      "PAUSED",   "FAULT",    "ENGAGING_TOOL"};
  return kNames[static_cast<std::size_t>(phase)];
}

bool Arm::is_homed() const noexcept {
  const bool tool = spec_.kind == ArmKind::psm && instrument_.tool_present();
  return powered_ && biased_ && (!tool || instrument_.engaged());
}

bool Arm::is_cartesian_ready() const noexcept {
  return is_joint_ready() && (spec_.kind != ArmKind::psm || instrument_.engaged());
}

bool Arm::ready() const noexcept { return phase_ == Phase::homed && operating_.is_homed; }

void Arm::state_events() const noexcept {
  voice_.text(Topic::current_state, name_of(phase_));
  voice_.text(Topic::desired_state, name_of(desired_));
  voice_.operating(operating_);
}

void Arm::operating(State state, bool is_busy) noexcept {
  operating_ = {state, is_homed(), is_busy};
  state_.operating_state = operating_;
  voice_.operating(operating_);
}

void Arm::busy(bool is_busy) noexcept {
  if (operating_.is_busy != is_busy || operating_.is_homed != is_homed()) operating(operating_.state, is_busy);
}

void Arm::error(const Text& words) noexcept {
  ++errors_;
  last_error_ = words;
  voice_.words(Topic::error, words);
}

void Arm::fault(const Text& words) noexcept {
  error(words);
  set_desired(Phase::fault);
}

void Arm::state_command(std::string_view command) noexcept {
  constexpr std::array<std::string_view, 6> kCommands{"enable", "disable", "home", "unhome", "pause", "resume"};
  Text words;
  if (std::find(kCommands.begin(), kCommands.end(), command) == kCommands.end()) {
    words << command << " doesn't seem to be a valid state_command (enable, disable, home, unhome, pause or resume)";
    return voice_.words(Topic::warning, words);
  }
  if (!knows(operating_.state, command)) {
    words << "command \"" << command << "\" is not supported in state \"" << dvrk::name_of(operating_.state) << " ("
          << name_of(phase_) << ")\"";
    return voice_.words(Topic::warning, words);
  }
  if (command == "enable") return set_desired(Phase::enabled);
  if (command == "disable") return set_desired(Phase::disabled);
  if (command == "home") return set_desired(Phase::homed);
  if (command == "pause") return set_desired(Phase::paused);
  if (command == "unhome") return unhome();
  desired_ = paused_desired_;
  enter(paused_phase_);
}

void Arm::unhome() noexcept {
  biased_ = false;
  instrument_.release();
  operating(operating_.state, operating_.is_busy);
}

void Arm::set_desired(Phase phase) noexcept {
  const Phase before = desired_;
  desired_ = phase;
  state_events();
  Text words("desired state ");
  words << name_of(phase);
  voice_.words(Topic::status, words);
  if (phase == Phase::paused && phase_ != Phase::paused) {
    paused_phase_ = phase_;
    paused_desired_ = before;
  }
  const bool direct = phase == Phase::disabled || phase == Phase::paused || phase == Phase::fault;
  if (direct && phase_ != phase) enter(phase);
  if (phase == Phase::homed && phase_ == Phase::homed && !biased_) enter(Phase::calibrating);
}

void Arm::power(bool on) noexcept {
  powered_ = on;
  settling_ = false;
  order_.on = false;
  space_ = Space::undefined;
  if (mode_ == Mode::trajectory && path_.active()) stop_move(false);
  mode_ = Mode::undefined;
  locked_ = false;
}

void Arm::enter(Phase phase) noexcept {
  if (phase_ == Phase::homed) set_mode(Space::undefined, Mode::undefined);  // the joints keep to their last order
  phase_ = phase;
  in_phase_ = 0.0;
  switch (phase) {
    case Phase::disabled:
      power(false);
      operating(State::DISABLED, false);
      break;
    case Phase::powering:
      power(false);
      operating(State::DISABLED, true);
      voice_.words(Topic::status, "power requested");
      break;
    case Phase::enabled:
      power(true);
      operating(State::ENABLED, false);
      break;
    case Phase::calibrating:
      operating(State::ENABLED, true);
      if (biased_) voice_.words(Topic::status, "encoders have already been calibrated, skipping");
      break;
    case Phase::homing:
      operating(State::ENABLED, true);
      set_mode(Space::joint, Mode::trajectory);
      settling_ = true;
      order_positions(body_->measured().q, JointVector::Zero(n_), JointVector::Zero(n_));
      break;
    case Phase::homed:
      operating(State::ENABLED, false);
      mode_ = Mode::undefined;
      space_ = Space::undefined;
      order_positions(order_.on ? order_.q : body_->measured().q, JointVector::Zero(n_), JointVector::Zero(n_));
      break;
    case Phase::engaging:
      operating(State::ENABLED, true);
      set_mode(Space::joint, Mode::trajectory);
      engaging_ = 0;
      break;
    case Phase::paused:
      operating(State::PAUSED, false);
      break;
    case Phase::fault:
      power(false);
      operating(State::FAULT, false);
      break;
  }
  state_events();
  Text words("current state ");
  words << name_of(phase_);
  voice_.words(Topic::status, words);
}

void Arm::run_phase(double dt) noexcept {
  in_phase_ += dt;
  switch (phase_) {
    case Phase::disabled:
      if (desired_ != Phase::disabled) enter(Phase::powering);
      break;
    case Phase::powering:
      if (in_phase_ < spec_.power_time) break;
      voice_.words(Topic::status, "power on");
      enter(Phase::enabled);
      break;
    case Phase::enabled:
      if (desired_ != Phase::enabled) enter(Phase::calibrating);
      break;
    case Phase::calibrating:
      if (!biased_ && in_phase_ < spec_.bias_time) break;
      if (!biased_) voice_.words(Topic::status, "encoders biased using potentiometer values");
      biased_ = true;
      enter(Phase::homing);
      break;
    case Phase::homing:
      run_homing(dt);
      check_tracking();
      break;
    case Phase::homed:
      if (spec_.kind == ArmKind::psm && biased_) engage();
      if (phase_ != Phase::homed) break;
      busy(operating_.is_busy);  // is_homed may have changed
      control(dt);
      check_tracking();
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

// A tool that came after homing is turned to and fro until its disks catch, unless it is past the cannula already.
void Arm::engage() noexcept {
  if (!instrument_.waits()) return;
  if (!instrument_.fresh()) return instrument_.engage(voice_);
  if (body_->measured().q[kDisks - 1] < kPastCannula) return enter(Phase::engaging);
  voice_.words(Topic::status, "tool tip is outside the cannula, assuming it doesn't need to \"engage\"");
  instrument_.engage(voice_);
}

void Arm::run_engaging(double dt) noexcept {
  if (!instrument_.waits()) return enter(Phase::homed);  // it was taken out
  if (path_.active()) {
    path_.step(dt);
    return order_positions(path_.q(), path_.v(), JointVector::Zero(n_));
  }
  if (engaging_ == static_cast<int>(kEngage.size())) {
    instrument_.engage(voice_);
    return enter(Phase::homed);
  }
  JointVector goal = order_.q;
  goal.tail(n_ - kDisks).setConstant(kEngage[static_cast<std::size_t>(engaging_)]);
  path_.start(order_.q, JointVector::Zero(n_), goal, ratio_v_ * spec_.v_max, ratio_a_ * spec_.a_max);
  Text words("engaging tool ");
  words << static_cast<long>(++engaging_) << " of " << static_cast<long>(kEngage.size());
  voice_.words(Topic::status, words);
}

void Arm::run_homing(double dt) noexcept {
  if (settling_) {
    if (in_phase_ < kSettle) return;
    settling_ = false;
    path_.start(order_.q, JointVector::Zero(n_), spec_.home, ratio_v_ * spec_.v_max, ratio_a_ * spec_.a_max);
  }
  if (path_.active()) {
    path_.step(dt);
    order_positions(path_.q(), path_.v(), JointVector::Zero(n_));
    in_phase_ = 0.0;  // patience begins when the trajectory has ended
    return;
  }
  if (((spec_.home - body_->measured().q).cwiseAbs().array() < kHomingTolerance).all()) return enter(Phase::homed);
  if (in_phase_ > kHomingPatience) fault("unable to reach home position during calibration on pots");
}

// Position control that loses its goal stops with a fault, as the real PID's check of measured against setpoint.
void Arm::check_tracking() noexcept {
  if (!order_.on || settling_) return;
  const JointVector& q = body_->measured().q;
  for (Eigen::Index k = 0; k < n_; ++k) {
    if (order_.by_torque[static_cast<std::size_t>(k)] || mode_ == Mode::effort) continue;
    if (std::abs(order_.q[k] - q[k]) <= spec_.tracking_error[k]) continue;
    Text words("received [");
    words << spec_.name << "-PID: measured to setpoint position error is too large on joint "
          << model_.joint_names()[static_cast<std::size_t>(k)] << ", setpoint " << order_.q[k] << ", measured " << q[k]
          << "]";
    return fault(words);
  }
}

}  // namespace palpate::dvrk
