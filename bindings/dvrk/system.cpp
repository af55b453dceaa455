// The simulated dVRK as a Python object; components, commands and topics have their names on the bus.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <utility>
#include <vector>

#include "convert.hpp"
#include "dvrk/bindings.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using dvrk::ArmSpec;
using dvrk::System;
using dvrk::SystemSpec;
using dvrk::TeleopSpec;
using System_ = nb::class_<System>;

SystemSpec system_spec(const std::vector<ArmSpec>& arms, const std::vector<TeleopSpec>& teleops,
                       const std::vector<int>& camera) {
  SystemSpec spec;
  spec.arms = arms;
  spec.teleops = teleops;
  if (camera.size() == 3) {
    spec.camera_mtml = camera[0];
    spec.camera_mtmr = camera[1];
    spec.camera_ecm = camera[2];
  }
  return spec;
}

JointVector joints(const VectorArg& numbers) {
  return dvrk::joints({numbers.values.data(), static_cast<std::size_t>(numbers.values.size())});
}

void bind_messages_of(System_& c) {
  c.def(
       "send",
       [](System& s, const std::string& component, const std::string& verb, const nb::object& value,
          const nb::object& velocity) {
         const dvrk::Address to = address(s, component);
         return s.apply(command(to, verb_entry(s, to, verb), value, velocity));
       },
       "component"_a, "verb"_a, "value"_a = nb::none(), "velocity"_a = nb::none(),
       "Sends a command by the name of its topic. Its payload decides the type of value: bool, float, str, int "
       "(button),\n"
       "joints (n,), pose (4,4), rotation (3,3), wrench (6,), or a dict: {pose, twist, wrench}, or the gains of "
       "servo_ci.")
      .def("events", &events, "Takes all events since the last call: [(t, component, topic, value), ..].")
      .def(
          "state", [](const System& s, const std::string& arm) { return arm_state(s.arm(arm_index(s, arm))); }, "arm"_a,
          "Last published state of an arm, by the names of its topics.")
      .def(
          "truth", [](const System& s, const std::string& arm) { return joint_state(s.truth(arm_index(s, arm))); },
          "arm"_a,
          "True joint positions and velocities of a simulated arm and the torques of its drives, for tests and "
          "studies.")
      .def(
          "teleop",
          [](const System& s, const std::string& name) { return teleop_state(s.teleop(teleop_index(s, name))); },
          "name"_a, "Last published state of a teleoperation.");
}

void bind_queries_of(System_& c) {
  c.def(
       "forward_kinematics",
       [](System& s, const std::string& arm, const VectorArg& q) -> std::optional<Matrix4> {
         Pose X;
         if (!s.forward_kinematics(arm_index(s, arm), joints(q), X)) return std::nullopt;
         return to_matrix(X);
       },
       "arm"_a, "q"_a, "Pose (4, 4) of the tip in the arm's base frame; None if q has the wrong length.")
      .def(
          "inverse_kinematics",
          [](System& s, const std::string& arm, const nb::object& X,
             const VectorArg& q_start) -> std::optional<Eigen::VectorXd> {
            JointVector q = joints(q_start);
            if (!s.inverse_kinematics(arm_index(s, arm), raw_pose(X), q)) return std::nullopt;
            return q;
          },
          "arm"_a, "X"_a, "q"_a, "Joint positions (n,) that place the tip at X, searched from q; None: out of reach.")
      .def(
          "joint_position",
          [](System& s, const std::string& arm, const VectorArg& actuators) -> std::optional<Eigen::VectorXd> {
            const JointVector q = s.joint_position(arm_index(s, arm), joints(actuators));
            if (q.size() == 0) return std::nullopt;
            return q;
          },
          "arm"_a, "actuators"_a,
          "Joint positions for actuator positions, including the jaw of a PSM; None if the length is wrong.");
}

}  // namespace

void bind_system(nb::module_& m) {
  System_ c(m, "System", "A simulated dVRK; palpate.simulators.dvrk.system() makes one.");
  c.def(
       "__init__",
       [](System* self, const std::vector<ArmSpec>& arms, const std::vector<TeleopSpec>& teleops,
          const std::vector<int>& camera, bool head_sensor) {
         dvrk::SystemSpec spec = system_spec(arms, teleops, camera);
         spec.head_sensor = head_sensor;
         new (self) System(std::move(spec));
       },
       "arms"_a, "teleops"_a, "camera"_a = std::vector<int>{}, "head_sensor"_a = false,
       "camera: indices of MTML, MTMR and ECM that the camera pedal couples; empty: none. head_sensor: the operator's "
       "presence comes from a head sensor, not from the coag pedal.")
      .def_prop_ro("arms", &System::arms, "Names of the arms, such as MTMR.")
      .def_prop_ro("teleops", &System::teleops, "Names of the teleoperations, such as MTMR_PSM1.")
      .def_prop_ro("t", &System::t, "Time since the simulation began [s].")
      .def_prop_ro_static(
          "tick", [](nb::handle) { return System::kTick; }, "Period of the simulation [s].")
      .def_prop_ro("dropped_events", &System::dropped_events,
                   "Number of events lost because events() was not called in time.")
      .def(
          "step",
          [](System& s, int n) {
            for (int k = 0; k < n; ++k) s.step();
          },
          "n"_a = 1, nb::call_guard<nb::gil_scoped_release>(), "Simulates n ticks of 1/3 ms.");
  bind_messages_of(c);
  bind_queries_of(c);
}

}  // namespace palpate::bindings
