#include "dvrk/console.hpp"

#include <cmath>

namespace palpate::dvrk {
namespace {

constexpr double kTap = 0.2;  // [s] clutch and camera: a shorter press is a tap
constexpr std::size_t kClutch = 0, kCamera = 1, kCoag = 2, kFocusIn = 4, kFocusOut = 5;

std::string_view pedal_name(std::size_t pedal) noexcept {
  constexpr std::array<std::string_view, 6> kNames{"clutch", "camera", "coag", "bicoag", "cam_plus", "cam_minus"};
  return kNames[pedal];
}

}  // namespace

Console::Console(std::vector<SimulatedArm*> mtms, std::vector<Teleop*> teleops, CameraTeleop* camera,
                 EndoscopeFocus* focus, bool head_sensor, Outbox& out)
    : mtms_(std::move(mtms)),
      teleops_(std::move(teleops)),
      selected_(teleops_.size(), true),
      camera_teleop_(camera),
      focus_(focus),
      publisher_({Kind::console, 0}, "console", out),
      pedal_publisher_({Kind::footpedals, 0}, "footpedals", out),
      head_sensor_(head_sensor) {
  for (std::size_t k = 0; k < pedals_.size(); ++k) {
    pedals_[k].topic = static_cast<Topic>(static_cast<std::size_t>(Topic::pedal_clutch) + k);
  }
}

void Console::start() noexcept {
  publisher_.flag(Topic::teleop_enabled, enabled_);
  tell_selection();
  publisher_.value(Topic::teleop_scale, teleops_.empty() ? 0.2 : teleops_[0]->state().scale);
}

bool Console::apply(const Command& c) noexcept {
  switch (c.verb) {
    case Verb::teleop_enable:
      enabled_ = c.flag;
      publisher_.flag(Topic::teleop_enabled, enabled_);
      update();
      return true;
    case Verb::teleop_select:
    case Verb::teleop_unselect:
      select(c.text, c.verb == Verb::teleop_select);
      return true;
    case Verb::teleop_set_scale:
      set_scale(c.value);
      return true;
    case Verb::emulate_operator_present:
      operator_present(c.button);
      return true;
    case Verb::emulate_clutch:
      clutch(c.button);
      return true;
    case Verb::emulate_camera:
      camera(c.button);
      return true;
    case Verb::press_clutch:
    case Verb::press_camera:
    case Verb::press_coag:
    case Verb::press_bicoag:
    case Verb::press_cam_plus:
    case Verb::press_cam_minus:
      press(static_cast<std::size_t>(c.verb) - static_cast<std::size_t>(Verb::press_clutch), c.button);
      return true;
    default:
      return false;
  }
}

// Handles a pedal that is pressed or released. Clutch and camera report a press only after kTap, when it can no longer
// be a tap.
void Console::press(std::size_t pedal, int button) noexcept {
  Pedal& p = pedals_[pedal];
  const bool down = button == 1;
  if (button == 2) return report(pedal, 2);
  if (down == p.down) return;
  p.down = down;
  p.since = pedal_publisher_.t();
  const bool waits = pedal == kClutch || pedal == kCamera;
  if (down) {
    p.reported = !waits;
    if (!waits) report(pedal, 1);
  } else {
    report(pedal, p.reported ? 0 : 2);
  }
}

void Console::run(double t, double) noexcept {
  publisher_.at(t);
  pedal_publisher_.at(t);
  for (std::size_t k = 0; k < pedals_.size(); ++k) {
    Pedal& p = pedals_[k];
    if (!p.down || p.reported || t - p.since < kTap) continue;
    p.reported = true;
    report(k, 1);
  }
}

void Console::report(std::size_t pedal, int button) noexcept {
  pedal_publisher_.button(pedals_[pedal].topic, button);
  Text words(pedal_name(pedal));
  words << (button == 0 ? " released" : button == 1 ? " pressed" : " quick tap");
  if (pedal == kClutch) return clutch(button);
  if (pedal == kCamera) return camera(button);
  if (pedal == kCoag && !head_sensor_) return operator_present(button);
  publisher_.message(Topic::status, words);
  if (focus_ == nullptr || button > 1) return;
  if (pedal == kFocusIn) focus_->focus_in(button == 1);
  if (pedal == kFocusOut) focus_->focus_out(button == 1);
}

void Console::operator_present(int button) noexcept {
  if (button < 2) {
    present_ = button == 1;
    publisher_.message(Topic::status, present_ ? "operator present" : "operator not present");
    update();
  }
  publisher_.button(Topic::operator_present, button);
}

void Console::clutch(int button) noexcept {
  publisher_.message(Topic::status, button == 0   ? "clutch released"
                                    : button == 1 ? "clutch pressed"
                                                  : "clutch quick tap");
  for (Teleop* teleop : teleops_) teleop->clutch(button);
  if (camera_teleop_ != nullptr) camera_teleop_->clutch(button);
  publisher_.button(Topic::clutch, button);
}

void Console::camera(int button) noexcept {
  publisher_.message(Topic::status, button == 0   ? "camera released"
                                    : button == 1 ? "camera pressed"
                                                  : "camera quick tap");
  if (button < 2) camera_ = button == 1;
  update();
  publisher_.button(Topic::camera, button);
}

void Console::select(const Text& name, bool selected) noexcept {
  for (std::size_t k = 0; k < teleops_.size(); ++k) {
    if (teleops_[k]->name() == name.view()) {
      selected_[k] = selected;
      if (!selected) teleops_[k]->state_command("disable");
      psm_running_ = psm_running_ && !selected;  // so that update() starts a newly selected one
      tell_selection();
      return update();
    }
  }
  Text words(selected ? "teleop/select" : "teleop/unselect");
  words << " can't find " << name.view();
  publisher_.message(Topic::warning, words);
}

void Console::tell_selection() noexcept {
  for (std::size_t k = 0; k < teleops_.size(); ++k) {
    publisher_.text(selected_[k] ? Topic::teleop_selected : Topic::teleop_unselected, teleops_[k]->name());
  }
}

void Console::set_scale(double scale) noexcept {
  if (!(scale > 0.0) || !std::isfinite(scale) || scale > 1e3) {
    Text words("teleop/set_scale, scale must be above 0 and finite, received ");
    words << scale;
    return publisher_.message(Topic::warning, words);
  }
  for (Teleop* teleop : teleops_) teleop->set_scale(scale);
  publisher_.value(Topic::teleop_scale, scale);
}

void Console::hold_mtms() noexcept {
  for (SimulatedArm* mtm : mtms_) {
    if (mtm->ready()) mtm->controller().hold();
  }
}

void Console::run_teleops(std::string_view command) noexcept {
  for (std::size_t k = 0; k < teleops_.size(); ++k) teleops_[k]->state_command(selected_[k] ? command : "disable");
}

// Starts and stops the teleoperations. If disabled, none runs; without an operator the MTMs are only aligned; while the
// camera pedal is pressed the camera teleoperation runs, otherwise the teleoperations of the selected PSMs.
void Console::update() noexcept {
  const bool was_running = psm_running_ || camera_running_;
  const bool camera = enabled_ && present_ && camera_ && camera_teleop_ != nullptr;
  const bool psm = enabled_ && present_ && !camera_;
  if (camera_teleop_ != nullptr && camera != camera_running_) {
    camera_teleop_->enable(camera);
    if (!camera) hold_mtms();
  }
  if (!enabled_ || (present_ && camera_)) {
    run_teleops("disable");
  } else if (!present_) {
    run_teleops("align_MTM");
  } else if (!psm_running_) {
    run_teleops("enable");
  }
  psm_running_ = psm;
  camera_running_ = camera;
  if (was_running && !enabled_) hold_mtms();
}

}  // namespace palpate::dvrk
