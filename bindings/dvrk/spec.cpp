// Options from which a simulated dVRK is built.
#include <nanobind/stl/string.h>

#include <stdexcept>

#include "convert.hpp"
#include "doc.hpp"
#include "dvrk/bindings.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using dvrk::ArmKind;
using dvrk::ArmSpec;
using dvrk::TeleopSpec;

void bind_arm_spec(nb::module_& m) {
  nb::class_<ArmSpec> spec(m, "ArmSpec",
                           "Options of one arm of the simulated dVRK (palpate.simulators.dvrk.arm fills them).");
  spec.def(
          "__init__",
          [](ArmSpec* self, const std::string& name, const std::string& kind, const arm::Arm& model) {
            if (kind != "mtm" && kind != "psm" && kind != "ecm") {
              throw std::invalid_argument("a dVRK arm is an mtm, a psm or an ecm; got '" + kind + "'");
            }
            const ArmKind k = kind == "mtm" ? ArmKind::mtm : kind == "psm" ? ArmKind::psm : ArmKind::ecm;
            new (self) ArmSpec{name, k, model};
          },
          "name"_a, "kind"_a, "model"_a, "kind: 'mtm', 'psm' or 'ecm'; otherwise raises ValueError.")
      .def_ro("name", &ArmSpec::name, "Name of the arm, such as MTMR."_doc)
      .def_rw("dynamic", &ArmSpec::dynamic,
              "True: torques move the joints; False: position servos move them, and torques do not."_doc)
      .def_rw("leader", &ArmSpec::leader, "Drives, friction and encoders of a dynamic arm."_doc)
      .def_rw("follower", &ArmSpec::follower, "Joint servos of an arm that is not dynamic."_doc)
      .def_rw("hand", &ArmSpec::hand, "Impedance of the hand that holds an MTM."_doc)
      .def_rw("has_gravity_model", &ArmSpec::has_gravity_model, "True: use_gravity_compensation has an effect."_doc)
      .def_rw("platform_gain", &ArmSpec::platform_gain,
              "Gain of the platform control on joint 4 of an MTM, 0..1 [-]."_doc)
      .def_prop_rw(
          "base_frame", [](const ArmSpec& s) { return to_matrix(s.base_frame); },
          [](ArmSpec& s, const Matrix4& X) { s.base_frame = to_pose(X, "base_frame"); },
          "Pose (4, 4) of the arm's own base in the frame of measured_cp.")
      .def_rw("cannula_link", &ArmSpec::cannula_link,
              "Index of the link that must be past the cannula for Cartesian control; -1: no check."_doc)
      .def_rw("jaw_min", &ArmSpec::jaw_min, "Smallest angle of the jaw [rad]."_doc)
      .def_rw("jaw_max", &ArmSpec::jaw_max, "Largest angle of the jaw [rad]."_doc)
      .def_rw("jaw_v_max", &ArmSpec::jaw_v_max, "Speed limit of the jaw [rad/s]."_doc)
      .def_rw("jaw_a_max", &ArmSpec::jaw_a_max, "Acceleration limit of the jaw [rad/s^2]."_doc)
      .def_rw("tool_type", &ArmSpec::tool_type, "Tool mounted at power-up; empty: no tool."_doc)
      .def_rw("power_time", &ArmSpec::power_time, "Time from enable to powered [s]."_doc)
      .def_rw("bias_time", &ArmSpec::bias_time, "Time to bias the encoders from the potentiometers [s]."_doc);
  joint_field(spec, "P", &ArmSpec::P, "Proportional gains (n,) of position control [N m/rad, N/m].");
  joint_field(spec, "D", &ArmSpec::D, "Derivative gains (n,) of position control [N m s/rad, N s/m].");
  joint_field(spec, "tracking_error", &ArmSpec::tracking_error,
              "Position error (n,) beyond which an arm faults [rad, m].");
  joint_field(spec, "v_max", &ArmSpec::v_max, "Speed limits (n,) of trajectories [rad/s, m/s].");
  joint_field(spec, "a_max", &ArmSpec::a_max, "Acceleration limits (n,) of trajectories [rad/s^2, m/s^2].");
  joint_field(spec, "start", &ArmSpec::start, "Joint positions (n,) at power-up [rad, m].");
  joint_field(spec, "home", &ArmSpec::home, "Joint positions (n,) after homing [rad, m].");
}

void bind_teleop_spec(nb::module_& m) {
  nb::class_<TeleopSpec>(m, "TeleopSpec", "A teleoperation of a PSM by an MTM; both are indices into the list of arms.")
      .def(nb::init<>())
      .def_rw("mtm", &TeleopSpec::mtm, "Index of the MTM."_doc)
      .def_rw("psm", &TeleopSpec::psm, "Index of the PSM."_doc)
      .def_rw("scale", &TeleopSpec::scale, "Motion scale [-]."_doc)
      .def_rw("align_MTM", &TeleopSpec::align_MTM, "True: the MTM aligns its orientation with the PSM."_doc)
      .def_rw("rotation_locked", &TeleopSpec::rotation_locked, "True: the PSM keeps its orientation."_doc)
      .def_rw("translation_locked", &TeleopSpec::translation_locked, "True: the PSM keeps its position."_doc)
      .def_rw("orientation_tolerance", &TeleopSpec::orientation_tolerance,
              "Largest orientation error at which following may start [rad]."_doc)
      .def_rw("gripper_threshold", &TeleopSpec::gripper_threshold,
              "Range of gripper motion that shows that the operator is ready [rad]."_doc)
      .def_rw("roll_threshold", &TeleopSpec::roll_threshold,
              "Range of roll motion that shows that the operator is ready [rad]."_doc)
      .def_rw("jaw_rate", &TeleopSpec::jaw_rate, "Rate at which the jaw follows the gripper [rad/s]."_doc)
      .def_rw("jaw_rate_after_clutch", &TeleopSpec::jaw_rate_after_clutch,
              "Rate at which the jaw follows the gripper after the clutch, until it has caught up [rad/s]."_doc);
}

}  // namespace

void bind_spec(nb::module_& m) {
  bind_arm_spec(m);
  bind_teleop_spec(m);
}

}  // namespace palpate::bindings
