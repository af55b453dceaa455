// Components and commands of the simulated dVRK by their names on the bus.
#include <stdexcept>

#include "dvrk/bindings.hpp"

namespace palpate::bindings {

dvrk::Address address(const dvrk::System& system, const std::string& component) {
  if (component == "system") return {dvrk::Kind::system, 0};
  if (component == "console") return {dvrk::Kind::console, 0};
  if (component == "footpedals") return {dvrk::Kind::footpedals, 0};
  for (std::size_t k = 0; k < system.arms().size(); ++k) {
    if (system.arms()[k] == component) return {dvrk::Kind::arm, static_cast<int>(k)};
  }
  for (std::size_t k = 0; k < system.teleops().size(); ++k) {
    if (system.teleops()[k] == component) return {dvrk::Kind::teleop, static_cast<int>(k)};
  }
  std::string names = "system, console, footpedals";
  for (const auto& list : {system.arms(), system.teleops()}) {
    for (const auto& name : list) names += ", " + name;
  }
  for (const dvrk::Kind kind :
       {dvrk::Kind::camera_teleop, dvrk::Kind::setup, dvrk::Kind::setup_cart, dvrk::Kind::focus}) {
    for (const dvrk::Address& at : system.components(kind, dvrk::kEveryArm)) {
      if (system.component_name(at) == component) return at;
      names += ", " + system.component_name(at);
    }
  }
  throw std::invalid_argument("the simulated dVRK has no component '" + component + "'; its components are " + names);
}

namespace {

int index_of(const dvrk::System& system, const std::string& name, dvrk::Kind kind, const char* what) {
  const dvrk::Address at = address(system, name);
  if (at.kind != kind) throw std::invalid_argument("'" + name + "' is not " + what + " of the simulated dVRK");
  return at.index;
}

}  // namespace

int arm_index(const dvrk::System& system, const std::string& name) {
  return index_of(system, name, dvrk::Kind::arm, "an arm");
}

int teleop_index(const dvrk::System& system, const std::string& name) {
  return index_of(system, name, dvrk::Kind::teleop, "a teleop");
}

const dvrk::VerbEntry& verb_entry(const dvrk::System& system, const dvrk::Address& at, const std::string& name) {
  for (const dvrk::VerbEntry& entry : dvrk::verbs()) {
    const bool knows = at.kind != dvrk::Kind::arm || (entry.arms & static_cast<unsigned>(system.kind(at.index))) != 0;
    if (entry.kind == at.kind && entry.name == name && knows) return entry;
  }
  throw std::invalid_argument(system.component_name(at) + " has no command '" + name +
                              "' (palpate._dvrk.verbs() lists them)");
}

}  // namespace palpate::bindings
