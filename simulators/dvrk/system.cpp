#include "dvrk/system.hpp"

#include <cstdint>
#include <stdexcept>

#include "dvrk/audio.hpp"
#include "dvrk/console.hpp"
#include "dvrk/coupling.hpp"
#include "dvrk/inverse.hpp"

namespace palpate::dvrk {
namespace {

constexpr int kArmTicks = 2, kTeleopTicks = 3;  // ticks per servo period and per period of a teleop

void check(const SystemSpec& spec) {
  const int n = static_cast<int>(spec.arms.size());
  const auto is = [&](int arm, ArmKind kind) {
    return arm >= 0 && arm < n && spec.arms[static_cast<std::size_t>(arm)].kind == kind;
  };
  for (const TeleopSpec& teleop : spec.teleops) {
    if (is(teleop.mtm, ArmKind::mtm) && is(teleop.psm, ArmKind::psm)) continue;
    throw std::invalid_argument("a dVRK teleop needs the index of an MTM and of a PSM among " + std::to_string(n) +
                                " arms; got " + std::to_string(teleop.mtm) + " and " + std::to_string(teleop.psm));
  }
  if (spec.camera_ecm < 0) return;
  if (!is(spec.camera_mtml, ArmKind::mtm) || !is(spec.camera_mtmr, ArmKind::mtm) ||
      !is(spec.camera_ecm, ArmKind::ecm)) {
    throw std::invalid_argument("the camera's teleop needs the indices of two MTMs and of an ECM; got " +
                                std::to_string(spec.camera_mtml) + ", " + std::to_string(spec.camera_mtmr) + " and " +
                                std::to_string(spec.camera_ecm));
  }
}

}  // namespace

struct System::Impl {
  explicit Impl(SystemSpec spec) : publisher(Address{Kind::system, 0}, "system", out) {
    check(spec);
    std::vector<SimulatedArm*> mtms;
    for (ArmSpec& arm : spec.arms) {
      const Address at{Kind::arm, static_cast<int>(arms.size())};
      arm_names.push_back(arm.name);
      arms.push_back(std::make_unique<SimulatedArm>(std::move(arm), at, out));
      if (arms.back()->spec().kind == ArmKind::mtm) mtms.push_back(arms.back().get());
    }
    std::vector<Teleop*> list;
    for (const TeleopSpec& teleop : spec.teleops) {
      const Address at{Kind::teleop, static_cast<int>(teleops.size())};
      teleops.push_back(std::make_unique<Teleop>(teleop, at_index(teleop.mtm), at_index(teleop.psm), at, out));
      teleop_names.emplace_back(teleops.back()->name().view());
      list.push_back(teleops.back().get());
    }
    if (spec.camera_ecm >= 0) {
      camera = std::make_unique<CameraTeleop>(at_index(spec.camera_mtml), at_index(spec.camera_mtmr),
                                              at_index(spec.camera_ecm), out);
      camera_name = camera->name().view();
    }
    for (const auto& arm : arms) {
      if (arm->spec().kind == ArmKind::ecm && !focus) focus = std::make_unique<EndoscopeFocus>(out);
    }
    console =
        std::make_unique<Console>(std::move(mtms), std::move(list), camera.get(), focus.get(), spec.head_sensor, out);
    publisher.value(Topic::volume, audio.volume());
    for (auto& arm : arms) arm->start();
    for (auto& teleop : teleops) teleop->start();
    if (camera) camera->start();
    if (focus) focus->start();
    console->start();
  }

  SimulatedArm& at_index(int arm) noexcept { return *arms[static_cast<std::size_t>(arm)]; }

  void step() noexcept {
    ++ticks;
    const double now = static_cast<double>(ticks) * kTick;
    publisher.at(now);
    for (auto& arm : arms) {
      arm->step(kTick);
      if (ticks % kArmTicks == 0) arm->run(now, kArmTicks * kTick);
    }
    if (ticks % kTeleopTicks != 0) return;
    console->run(now, kTeleopTicks * kTick);
    for (auto& teleop : teleops) teleop->run(now, kTeleopTicks * kTick);
    if (camera) camera->run(now);
    if (focus) focus->run(now);
    if (reference != nullptr) refer();
  }

  bool apply(const Command& c) noexcept {
    const auto index = static_cast<std::size_t>(c.to.index);
    switch (c.to.kind) {
      case Kind::system:
        return apply_audio(c) || power(c.verb);
      case Kind::console:
      case Kind::footpedals:
        return console->apply(c);
      case Kind::arm:
        return index < arms.size() && arms[index]->apply(c);
      case Kind::teleop:
        return index < teleops.size() && teleops[index]->apply(c);
      case Kind::camera_teleop:
        return camera && camera->apply(c);
      case Kind::focus:
        return focus && focus->apply(c);
      case Kind::setup:
        return index < arms.size() && arms[index]->setup() != nullptr && arms[index]->setup()->apply(c);
      case Kind::setup_cart:
        return c.verb == Verb::set_reference_arm && (set_reference(c.text), true);
    }
    return false;
  }

  bool apply_audio(const Command& c) noexcept {
    if (c.verb == Verb::set_volume) return audio.set_volume(c.value, publisher), true;
    if (c.verb == Verb::beep) return audio.beep(c.position, publisher), true;
    if (c.verb == Verb::string_to_speech) return Audio::say(c.text, publisher), true;
    return false;
  }

  bool power(Verb verb) noexcept {
    const std::string_view command = verb == Verb::power_on    ? "enable"
                                     : verb == Verb::power_off ? "disable"
                                     : verb == Verb::home      ? "home"
                                                               : "";
    if (command.empty()) return false;
    Text words(command);
    words << " requested for every arm";
    publisher.message(Topic::status, words);
    for (auto& arm : arms) {
      arm->state_command(command);
      if (arm->setup() != nullptr) arm->setup()->state_command(command);
    }
    return true;
  }

  // The poses of all arms that setup joints carry are told in the tip frame of one of them, or of the cart again.
  void set_reference(const Text& name) noexcept {
    reference = nullptr;
    for (auto& arm : arms) {
      if (arm->setup() != nullptr && name == arm->spec().name) reference = arm.get();
    }
    if (reference == nullptr && !name.empty() && !(name == "Cart")) {
      Text words("SUJ/set_reference_arm can't find ");
      words << name.view() << ": a PSM, the ECM or Cart";
      publisher.message(Topic::warning, words);
    }
    refer();
  }
  void refer() noexcept {
    const Pose X_RC =
        reference == nullptr ? Pose{} : (reference->setup()->X_CB() * reference->state().local_measured_cp).inverse();
    for (auto& arm : arms) {
      if (arm->setup() == nullptr) continue;
      const bool other = reference != nullptr && arm.get() != reference;
      arm->setup()->set_reference(other ? X_RC : Pose{}, other ? std::string_view(reference->spec().name) : "");
    }
  }

  Outbox out;
  EventPublisher publisher;
  Audio audio;
  std::vector<std::string> arm_names, teleop_names;
  std::vector<std::unique_ptr<SimulatedArm>> arms;
  std::vector<std::unique_ptr<Teleop>> teleops;
  std::unique_ptr<CameraTeleop> camera;
  std::unique_ptr<EndoscopeFocus> focus;
  SimulatedArm* reference =
      nullptr;  ///< measured_cp of the other arms is told in its tip frame; nullptr: in the cart's
  std::string camera_name;
  std::unique_ptr<Console> console;
  std::int64_t ticks = 0;
};

System::System(SystemSpec spec) : impl_(std::make_unique<Impl>(std::move(spec))) {}
System::System(System&&) noexcept = default;
System& System::operator=(System&&) noexcept = default;
System::~System() = default;

const std::vector<std::string>& System::arms() const noexcept { return impl_->arm_names; }
const std::vector<std::string>& System::teleops() const noexcept { return impl_->teleop_names; }
std::string System::component_name(const Address& at) const {
  switch (at.kind) {
    case Kind::system:
      return "system";
    case Kind::console:
      return "console";
    case Kind::footpedals:
      return "footpedals";
    case Kind::arm:
      return arms()[static_cast<std::size_t>(at.index)];
    case Kind::teleop:
      return teleops()[static_cast<std::size_t>(at.index)];
    case Kind::camera_teleop:
      return impl_->camera_name;
    case Kind::focus:
      return "endoscope_focus";
    case Kind::setup:
      return "SUJ/" + arms()[static_cast<std::size_t>(at.index)];
    case Kind::setup_cart:
      return "SUJ";
  }
  return {};
}
std::vector<Address> System::components(Kind kind, unsigned arms) const {
  const bool of_arm = kind == Kind::arm || kind == Kind::setup;
  int count = 1;
  if (of_arm) count = static_cast<int>(impl_->arms.size());
  if (kind == Kind::teleop) count = static_cast<int>(impl_->teleops.size());
  if (kind == Kind::camera_teleop) count = impl_->camera ? 1 : 0;
  if (kind == Kind::focus) count = impl_->focus ? 1 : 0;
  if (kind == Kind::setup_cart) count = components(Kind::setup, kEveryArm).empty() ? 0 : 1;
  std::vector<Address> found;
  for (int i = 0; i < count; ++i) {
    if (of_arm && (arms & static_cast<unsigned>(this->kind(i))) == 0) continue;
    if (kind == Kind::setup && impl_->at_index(i).setup() == nullptr) continue;
    found.push_back({kind, i});
  }
  return found;
}
ArmKind System::kind(int arm) const noexcept { return impl_->at_index(arm).spec().kind; }
const std::vector<std::string>& System::joint_names(int arm) const noexcept {
  return impl_->at_index(arm).model().joint_names();
}

void System::step() noexcept { impl_->step(); }
double System::t() const noexcept { return static_cast<double>(impl_->ticks) * kTick; }
bool System::apply(const Command& command) noexcept { return impl_->apply(command); }
bool System::next(Event& event) noexcept { return impl_->out.next(event); }
std::size_t System::dropped_events() const noexcept { return impl_->out.dropped(); }
const ArmState& System::arm(int arm) const noexcept { return impl_->at_index(arm).state(); }
const TeleopState& System::teleop(int teleop) const noexcept {
  return impl_->teleops[static_cast<std::size_t>(teleop)]->state();
}
JointState System::truth(int arm) const noexcept { return impl_->at_index(arm).truth(); }

bool System::forward_kinematics(int arm, const JointVector& q, Pose& cp) noexcept {
  SimulatedArm& a = impl_->at_index(arm);
  if (q.size() != a.model().n() || !q.allFinite()) return false;
  a.model().update(q, JointVector::Zero(q.size()));
  cp = a.base_frame() * a.model().tip();
  return true;
}

bool System::inverse_kinematics(int arm, const Pose& cp, JointVector& q) noexcept {
  SimulatedArm& a = impl_->at_index(arm);
  if (q.size() != a.model().n() || !q.allFinite() || !is_pose(cp)) return false;
  return inverse_anywhere(a.model(), a.spec().kind, a.base_frame().inverse() * cp, a.spec().home, q);
}

JointVector System::joint_position(int arm, const JointVector& actuators) noexcept {
  const ArmSpec& spec = impl_->at_index(arm).spec();
  const JointMatrix A = actuator_coupling(spec);
  return actuators.size() == A.cols() && actuators.allFinite() ? JointVector(A * actuators) : JointVector();
}

}  // namespace palpate::dvrk
