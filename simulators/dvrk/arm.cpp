#include "dvrk/arm.hpp"

#include <algorithm>
#include <array>

#include "dvrk/payload.hpp"

namespace palpate::dvrk {
namespace {

/// Endoscopes of the real component; the last one is mounted at the start. All have the same shape in this simulation.
constexpr std::array<std::string_view, 7> kEndoscopes{"NONE",  "SD_STRAIGHT", "SD_UP",      "SD_DOWN",
                                                      "HD_UP", "HD_DOWN",     "HD_STRAIGHT"};

}  // namespace

SimulatedArm::SimulatedArm(ArmSpec spec, Address at, Outbox& out)
    : context_(std::move(spec), at, out),
      controller_(context_),
      states_(context_, controller_),
      reporter_(context_, controller_) {
  if (this->spec().kind != ArmKind::mtm) setup_.emplace(context_, Address{Kind::setup, at.index}, out);
  reporter_.measure(pinch_);
}

void SimulatedArm::start() noexcept {
  states_.start();
  const EventPublisher& publisher = context_.publisher;
  publisher.value(Topic::ratio, 1.0);
  publisher.value(Topic::ratio_v, 1.0);
  publisher.value(Topic::ratio_a, 1.0);
  if (spec().kind == ArmKind::mtm) publisher.flag(Topic::orientation_locked, false);
  if (spec().kind == ArmKind::ecm) publisher.text(Topic::endoscope_type, kEndoscopes.back());
  if (setup_) setup_->start();
}

void SimulatedArm::step(double dt) noexcept { context_.body->step(dt, around_); }

// The sequence of the real component: measure, run the state machine, order the servos. Commands are applied between
// two periods.
void SimulatedArm::run(double t, double dt) noexcept {
  context_.publisher.at(t);
  if (setup_) setup_->run(t, dt);
  if (!context_.body->truth().q.allFinite()) {
    context_.body->reset(spec().start);
    states_.fault("the simulated joints were not finite: the arm is where it started");
  }
  reporter_.measure(pinch_);
  if (spec().kind == ArmKind::mtm) gripper_.run(pinch_, dt, context_.publisher);
  states_.run(dt);
  if (spec().kind == ArmKind::psm && context_.instrument.run(dt, states_.homed())) controller_.jaw_arrived();
  context_.body->command(controller_.order());
}

bool SimulatedArm::apply(const Command& c) noexcept {
  for (const VerbEntry& entry : verbs()) {
    if (entry.verb != c.verb) continue;
    if (entry.kind != Kind::arm || (entry.arms & static_cast<unsigned>(spec().kind)) == 0) return false;
    const Text refusal = payload_refusal(c, entry, context_.n());
    if (!refusal.empty()) return context_.warning(refusal), true;
    return controller_.apply(c) || apply_hardware(c) || apply_hand(c);
  }
  return false;
}

bool SimulatedArm::apply_hardware(const Command& c) noexcept {
  switch (c.verb) {
    case Verb::state_command:
      state_command(c.text.view());
      return true;
    case Verb::set_base_frame:
      if (setup_) {
        setup_->set_base_frame(c.X);
      } else {
        context_.base_frame = c.X;
      }
      return true;
    case Verb::set_tool_type:
      context_.instrument.set_tool_type(c.text, context_.publisher);
      return true;
    case Verb::emulate_adapter_present:
      context_.instrument.set_adapter_present(c.flag, context_.publisher);
      return true;
    case Verb::emulate_tool_present:
      context_.instrument.set_tool_present(c.flag, context_.publisher);
      return true;
    case Verb::set_endoscope_type:
      set_endoscope_type(c.text);
      return true;
    case Verb::emulate_arm_clutch:
      press_clutch(c.button);
      return true;
    case Verb::emulate_fault:
      states_.fault(c.text.empty() ? Text("emulated fault") : c.text);
      return true;
    default:
      return false;
  }
}

void SimulatedArm::set_endoscope_type(const Text& type) noexcept {
  if (std::find(kEndoscopes.begin(), kEndoscopes.end(), type.view()) == kEndoscopes.end()) {
    Text words("set_endoscope_type: \"");
    words << type.view() << "\" is none of NONE, SD_STRAIGHT, SD_UP, SD_DOWN, HD_STRAIGHT, HD_UP, HD_DOWN";
    return context_.error(words);
  }
  context_.publisher.text(Topic::endoscope_type, type);
}

// The button on the arm: while it is pressed a person moves the arm by hand, then the arm holds where it is.
void SimulatedArm::press_clutch(int button) noexcept {
  context_.publisher.button(Topic::arm_clutch, button);
  if (button > 1) return;
  context_.status(button == 1 ? "arm clutch pressed" : "arm clutch released");
  if (!ready()) return;
  if (button == 1) {
    Command free;
    free.verb = Verb::free;
    controller_.apply(free);
  } else {
    controller_.hold();
  }
}

// Commands of the simulation only: a hand on the handle, and a force on the tool.
bool SimulatedArm::apply_hand(const Command& c) noexcept {
  const Pose& base = context_.base_frame;
  switch (c.verb) {
    case Verb::hand_servo_cp:
      around_.held = true;
      around_.X_hand = base.inverse() * c.X;
      return true;
    case Verb::hand_servo_cf:
    case Verb::tool_servo_cf:
      around_.F = {base.R.transpose() * bounded(c.F.f), base.R.transpose() * bounded(c.F.t)};
      return true;
    case Verb::hand_gripper:
      pinch_ = std::clamp(c.value, 0.0, kGripperOpen);
      return true;
    case Verb::hand_free:
      around_ = {};
      pinch_ = kGripperOpen;
      return true;
    default:
      return false;
  }
}

}  // namespace palpate::dvrk
