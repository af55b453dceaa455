// The extension `_dvrk`: one function for each subject, in the file of that name.
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "dvrk/system.hpp"
#include "types.hpp"

namespace palpate::bindings {

void bind_spec(nanobind::module_& m);
void bind_system(nanobind::module_& m);
void bind_messages(nanobind::module_& m);
void bind_trajectory(nanobind::module_& m);

// names.cpp: components and commands by their names on the bus. An unknown name throws std::invalid_argument.

/// Address of a component, such as "console", "MTMR" or "MTMR_PSM1".
[[nodiscard]] dvrk::Address address(const dvrk::System& system, const std::string& component);
[[nodiscard]] int arm_index(const dvrk::System& system, const std::string& name);
[[nodiscard]] int teleop_index(const dvrk::System& system, const std::string& name);
[[nodiscard]] const dvrk::VerbEntry& verb_entry(const dvrk::System& system, const dvrk::Address& component,
                                                const std::string& name);

// commands.cpp: Python values as payloads. Numbers pass unchecked; the component rejects invalid ones.

[[nodiscard]] Pose raw_pose(const nanobind::object& value);
[[nodiscard]] dvrk::Impedance impedance(const nanobind::dict& gains);
/// A command with the payload that its verb carries; velocity: None, or (n,) [rad/s, m/s].
[[nodiscard]] dvrk::Command command(const dvrk::Address& to, const dvrk::VerbEntry& verb, const nanobind::object& value,
                                    const nanobind::object& velocity);

// states.cpp: states and events as Python values.

using Events = nanobind::typed<nanobind::list, Tuple<double, nanobind::str, nanobind::str, nanobind::any>>;
[[nodiscard]] Fields joint_state(const dvrk::JointState& state);
[[nodiscard]] Fields arm_state(const dvrk::ArmState& state);
[[nodiscard]] Fields teleop_state(const dvrk::TeleopState& state);
/// Takes all events out of the system's queue.
[[nodiscard]] Events events(dvrk::System& system);

}  // namespace palpate::bindings
