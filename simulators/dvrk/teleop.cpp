#include "dvrk/teleop.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace palpate::dvrk {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TeleopSpec checked(TeleopSpec s) {
  const auto above = [](const char* name, double x) {
    if (x > 0.0 && std::isfinite(x)) return;
    throw std::invalid_argument("dVRK teleop: " + std::string(name) + " must be above zero and finite; got " +
                                std::to_string(x));
  };
  above("scale", s.scale);
  above("orientation_tolerance", s.orientation_tolerance);
  above("jaw_rate", s.jaw_rate);
  above("jaw_rate_after_clutch", s.jaw_rate_after_clutch);
  above("gripper_max - gripper_zero", s.gripper_max - s.gripper_zero);
  return s;
}

Text joined(const SimulatedArm& mtm, const SimulatedArm& psm) noexcept {
  Text name(mtm.spec().name);
  name << "_" << psm.spec().name;
  return name;
}

}  // namespace

Teleop::Teleop(const TeleopSpec& spec, SimulatedArm& mtm, SimulatedArm& psm, Address at, Outbox& out)
    : spec_(checked(spec)), mtm_(&mtm), psm_(&psm), publisher_(at, joined(mtm, psm), out) {
  state_.scale = spec_.scale;
  state_.current_state = state_.desired_state = name_of(Phase::disabled);
}

std::string_view Teleop::name_of(Phase phase) noexcept {
  constexpr std::array<std::string_view, 4> kNames{"DISABLED", "SETTING_ARMS_STATE", "ALIGNING_MTM", "ENABLED"};
  return kNames[static_cast<std::size_t>(phase)];
}

void Teleop::start() noexcept {
  publisher_.text(Topic::teleop_desired_state, name_of(desired_));
  publisher_.text(Topic::teleop_current_state, name_of(phase_));
  publisher_.value(Topic::scale, spec_.scale);
  publisher_.button(Topic::rotation_locked, spec_.rotation_locked ? 1 : 0);
  publisher_.button(Topic::translation_locked, spec_.translation_locked ? 1 : 0);
  publisher_.flag(Topic::align_MTM, spec_.align_MTM);
  set_following(false);
}

void Teleop::error(const Text& words) noexcept {
  desired_ = Phase::disabled;
  publisher_.message(Topic::error, words);
}

bool Teleop::apply(const Command& c) noexcept {
  switch (c.verb) {
    case Verb::teleop_state_command:
      state_command(c.text.view());
      return true;
    case Verb::set_scale:
      set_scale(c.value);
      return true;
    case Verb::lock_rotation:
      lock_rotation(c.flag);
      return true;
    case Verb::lock_translation:
      spec_.translation_locked = c.flag;
      publisher_.button(Topic::translation_locked, c.flag ? 1 : 0);
      store_reference_poses();
      return true;
    case Verb::set_align_MTM:
      set_align(c.flag);
      return true;
    case Verb::following_mtm_body_servo_cf:
      if (!c.F.f.allFinite() || !c.F.t.allFinite()) {
        publisher_.message(Topic::warning, "following/mtm/body/servo_cf refused: it needs finite numbers");
        return true;
      }
      F_user_ = c.F;
      F_user_valid_ = true;
      return true;
    default:
      return false;
  }
}

void Teleop::state_command(std::string_view command) noexcept {
  if (command == "enable") return set_desired(Phase::enabled);
  if (command == "disable") return set_desired(Phase::disabled);
  if (command == "align_MTM") return set_desired(Phase::aligning_mtm);
  Text words(command);
  words << " doesn't seem to be a valid state_command (enable, disable or align_MTM)";
  publisher_.message(Topic::warning, words);
}

void Teleop::set_desired(Phase phase) noexcept {
  const bool same = phase == desired_;
  desired_ = phase;
  state_.desired_state = name_of(phase);
  publisher_.text(Topic::teleop_desired_state, name_of(phase));
  if (same) return;
  active_ = false;  // the operator has to show readiness again
  Text words("set desired state to ");
  words << name_of(phase);
  publisher_.message(Topic::status, words);
}

void Teleop::set_scale(double scale) noexcept {
  if (!(scale > 0.0) || !std::isfinite(scale) || scale > 1e3) {
    Text words("set_scale, scale must be above 0 and finite, received ");
    words << scale;
    return publisher_.message(Topic::warning, words);
  }
  spec_.scale = state_.scale = scale;
  publisher_.value(Topic::scale, scale);
  store_reference_poses();
}

void Teleop::lock_rotation(bool lock) noexcept {
  spec_.rotation_locked = lock;
  publisher_.button(Topic::rotation_locked, lock ? 1 : 0);
  if (!lock) {  // the MTM may have been turned, so it has to be aligned again
    set_following(false);
    return enter(Phase::disabled);
  }
  store_reference_poses();
  if (phase_ == Phase::enabled) mtm_->controller().lock_orientation(mtm_->state().measured_cp.R);
}

void Teleop::set_align(bool align) noexcept {
  spec_.align_MTM = align;
  publisher_.flag(Topic::align_MTM, align);
  if (phase_ != Phase::enabled) return;
  set_following(false);
  enter(Phase::disabled);
}

void Teleop::set_following(bool following) noexcept {
  state_.following = following;
  publisher_.flag(Topic::following, following);
  F_user_valid_ = false;  // a transition ends an earlier wrench
}

void Teleop::store_reference_poses() noexcept {
  X_mtm0_ = mtm_->state().measured_cp;
  X_psm0_ = psm_->state().setpoint_cp;
  state_.alignment_offset = R_offset0_ = X_mtm0_.R.transpose() * X_psm0_.R;
}

void Teleop::clutch(int button) noexcept {
  if (button > 1) return;  // a quick tap has no effect
  clutched_ = button == 1;
  if (desired_ != Phase::enabled) return;
  if (clutched_) return press_clutch();
  publisher_.message(Topic::status, "console clutch released");
  back_from_clutch_ = true;
  jaw_caught_up_ = false;
  enter(Phase::setting_arms_state);
}

// While the clutch is pressed, the MTM exerts no force except gravity compensation, and the PSM holds. The orientation
// of the MTM is locked if the teleoperation aligns it.
void Teleop::press_clutch() noexcept {
  active_before_clutch_ = active_;
  set_following(false);
  publisher_.message(Topic::status, "console clutch pressed");
  mtm_->controller().body_servo_cf({});
  mtm_->controller().use_gravity_compensation(true);
  if (spec_.align_MTM || spec_.rotation_locked) {
    mtm_->controller().lock_orientation(mtm_->state().measured_cp.R);
  } else {
    mtm_->controller().unlock_orientation();
  }
  psm_->controller().hold();
}

double Teleop::jaw_of(double gripper) const noexcept {
  const double scale = psm_->instrument().q_max() / (spec_.gripper_max - spec_.gripper_zero);
  return scale * (gripper - spec_.gripper_zero);
}

double Teleop::gripper_of(double jaw) const noexcept {
  const double scale = psm_->instrument().q_max() / (spec_.gripper_max - spec_.gripper_zero);
  return jaw / scale + spec_.gripper_zero;
}

void Teleop::enter(Phase phase) noexcept {
  const bool changed = phase != phase_;
  phase_ = phase;
  in_phase_ = 0.0;
  state_.current_state = name_of(phase);
  if (changed) {
    publisher_.text(Topic::teleop_current_state, name_of(phase));
    Text words("current state is ");
    words << name_of(phase);
    publisher_.message(Topic::status, words);
  }
  switch (phase) {
    case Phase::disabled:
      mtm_->controller().hold();
      break;
    case Phase::setting_arms_state:
      for (SimulatedArm* arm : {psm_, mtm_}) {
        if (arm->state().operating_state.state != State::ENABLED) arm->state_command("enable");
        if (!arm->state().operating_state.is_homed) arm->state_command("home");
      }
      break;
    case Phase::aligning_mtm:
      publisher_.value(Topic::scale, spec_.scale);
      since_goal_ = kInfinity;
      if (!spec_.align_MTM) mtm_->controller().move_cp(mtm_->state().setpoint_cp);
      if (back_from_clutch_) active_ = active_before_clutch_;
      back_from_clutch_ = false;
      roll_min_ = gripper_min_ = kInfinity;
      roll_max_ = gripper_max_ = -kInfinity;
      break;
    case Phase::enabled:
      enter_enabled();
      break;
  }
}

void Teleop::enter_enabled() noexcept {
  store_reference_poses();
  jaw_caught_up_ = false;
  limited_gripper_ = gripper_of(psm_->state().jaw_setpoint_js.q[0]);
  mtm_->controller().use_gravity_compensation(true);
  mtm_->controller().body_servo_cf({});
  if (spec_.rotation_locked) {
    mtm_->controller().lock_orientation(mtm_->state().measured_cp.R);
  } else {
    mtm_->controller().unlock_orientation();
  }
  if (clutched_) return press_clutch();
  set_following(true);
}

}  // namespace palpate::dvrk
