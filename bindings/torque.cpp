#include "palpate/torque/torque.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>

#include <optional>
#include <string>

#include "bindings.hpp"
#include "convert.hpp"
#include "palpate/torque/cartesian.hpp"
#include "types.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using torque::FrictionOptions;
using torque::LawOptions;
using torque::LimitOptions;
using torque::Mode;
using torque::Options;
using Vector = Eigen::VectorXd;

std::string mode_name(const Options& o) { return o.mode == Mode::full ? "full" : "paper"; }

void set_mode(Options& o, const std::string& name) {
  if (name != "full" && name != "paper") {
    throw std::invalid_argument("torque mode must be 'full' or 'paper' (first three joints only); got '" + name + "'");
  }
  o.mode = name == "full" ? Mode::full : Mode::paper;
}

/// `model` is the controller's arm; F_H_L (6,) the wrench to render on the hand; F_cell_L (3,) the load cell's force.
std::pair<LeaderCommand, unsigned> step(torque::Torque& self, arm::Arm& model, const VectorArg& q, const VectorArg& v,
                                        const Vec6& F, const std::optional<Vec3>& F_cell_L, bool fresh) {
  LeaderState leader;
  leader.q = joint_vector(q, "q", model.n());
  leader.v = joint_vector(v, "v", model.n());
  leader.has_load_cell = F_cell_L.has_value();
  leader.F_cell_L = F_cell_L.value_or(Vec3::Zero());
  LeaderCommand out(model.n());
  model.dynamics(leader.q, leader.v);
  const unsigned status = self.step(model, {leader, {{F.head<3>(), F.tail<3>()}}, fresh}, out);
  return {std::move(out), status};
}

template <int m>
Tuple<Eigen::MatrixXd, Vector, Vector, bool> cartesian(arm::Arm& model, const VectorArg& q_in, const VectorArg& v_in,
                                                       const std::optional<Vector>& rotor, double heaviest) {
  const JointVector q = joint_vector(q_in, "q", model.n()), v = joint_vector(v_in, "v", model.n());
  const JointVector I =
      rotor ? joint_vector(*rotor, "rotor_inertia", model.n()) : JointVector(JointVector::Zero(model.n()));
  const torque::Cartesian<m> c = torque::cartesian<m>(model.dynamics(q, v), I, model.n(), heaviest);
  return nb::make_tuple(Eigen::MatrixXd(c.Lambda), Vector(c.Gamma_v), Vector(c.eta), c.singular);
}

template <typename Class, typename Struct>
void terms(Class& c, JointVector Struct::* field, const char* name, const char* doc) {
  c.def_prop_ro(name, [field](const Struct& s) -> Vector { return s.*field; }, doc);
}

void bind_command(nb::module_& m) {
  nb::class_<LeaderCommand> command(m, "LeaderCommand", "Torque terms for the leader, kept apart.");
  terms(command, &LeaderCommand::tau_force, "tau_force", "(n,) J^T (F_H_L + F_law_L) [N m]");
  terms(command, &LeaderCommand::tau_gravity, "tau_gravity", "(n,) holds the arm up [N m]");
  terms(command, &LeaderCommand::tau_platform, "tau_platform", "(n,) joint-4 controller [N m]");
  terms(command, &LeaderCommand::tau_friction, "tau_friction", "(n,) compensates friction [N m]");
  terms(command, &LeaderCommand::tau_limits, "tau_limits", "(n,) soft stops [N m]");
  command
      .def_prop_ro(
          "tau", [](const LeaderCommand& c) -> Vector { return c.hold() + c.act(); }, "(n,) their sum [N m]")
      .def_prop_ro(
          "F_H_L", [](const LeaderCommand& c) -> Vector { return to_vector(c.F_H_L); }, "(6,) truly rendered [N, N m]")
      .def_prop_ro(
          "F_law_L", [](const LeaderCommand& c) -> Vector { return to_vector(c.F_law_L); },
          "(6,) what the control law adds to it [N, N m]")
      .def_ro("F_neglected", &LeaderCommand::F_neglected, "what it leaves to the hand of the arm's own dynamics [N]");
}

void bind_options(nb::module_& m) {
  nb::class_<Options> options(m, "TorqueOptions", "Torques that render a force and hold the arm's own weight.");
  options.def(nb::init<>())
      .def_rw("law", &Options::law, "'stiffness' (the paper's), 'impedance' or 'admittance'")
      .def_prop_rw("mode", &mode_name, &set_mode, "'full', or 'paper': first three joints, wrist torques zero")
      .def_rw("force_gain", &Options::force_gain, "0 switches tau_force off")
      .def_rw("gravity_gain", &Options::gravity_gain, "0 switches gravity compensation off")
      .def_rw("platform_gain", &Options::platform_gain, "joint-4 controller, 0..1 (7-joint MTMs, full mode)")
      .def_rw("friction", &Options::friction)
      .def_rw("limits", &Options::limits)
      .def_rw("laws", &Options::laws)
      .def_rw("law_cap", &Options::law_cap, "most that a law may add to the rendered force [N]")
      .def_rw("fast_force", &Options::fast_force, "more neglected inertia than this is told: too_fast [N]");
  joint_field(options, "rotor_inertia", &Options::rotor_inertia, "(n,) of the controller's model [kg m^2]");

  nb::class_<FrictionOptions> friction(m, "FrictionOptions", "Friction compensation; it never drives the arm.");
  friction.def(nb::init<>())
      .def_rw("gain", &FrictionOptions::gain, "0 switches it off, 0..1")
      .def_rw("dead_band", &FrictionOptions::dead_band, "none below this speed [rad/s, m/s]")
      .def_rw("full_speed", &FrictionOptions::full_speed, "whole from this speed on [rad/s, m/s]");
  joint_field(friction, "coulomb", &FrictionOptions::coulomb, "(n,) of the controller's model [N m]");
  joint_field(friction, "viscous", &FrictionOptions::viscous, "(n,) of the controller's model [N m s/rad]");

  nb::class_<LimitOptions>(m, "LimitOptions", "Soft stops before the joint limits.")
      .def(nb::init<>())
      .def_rw("gain", &LimitOptions::gain, "share of the drive's limit at the joint's limit; 0 switches it off")
      .def_rw("margin", &LimitOptions::margin, "share of the joint's range");

  nb::class_<LawOptions>(m, "LawOptions", "Of the control laws.")
      .def(nb::init<>())
      .def_rw("shape_inertia", &LawOptions::shape_inertia, "impedance: the handle weighs virtual_mass")
      .def_rw("virtual_mass", &LawOptions::virtual_mass, "[kg]")
      .def_rw("virtual_damping", &LawOptions::virtual_damping, "admittance [N s/m]")
      .def_rw("servo_bandwidth", &LawOptions::servo_bandwidth, "of admittance's position loop [Hz]");
}

}  // namespace

void bind_torque(nb::module_& m) {
  bind_command(m);
  bind_options(m);
  nb::class_<torque::Torque>(m, "Torque", "Joint torques of one control law, within the drive limits.")
      .def(
          "__init__",
          [](torque::Torque* self, const Options& options, const VectorArg& tau_max, double dt) {
            new (self) torque::Torque(options, joint_vector(tau_max, "tau_max"), dt);
          },
          "options"_a, "tau_max"_a, "dt"_a = 1e-3)
      .def("step", &step, "model"_a, "q"_a, "v"_a, "F_H_L"_a, "F_cell_L"_a = nb::none(), "fresh"_a = true,
           "(LeaderCommand, status bits) that render F_H_L (6,); F_cell_L (3,): force of the arm on the hand.");
  m.def("cartesian_place", &cartesian<3>, "model"_a, "q"_a, "v"_a, "rotor_inertia"_a = nb::none(), "heaviest"_a = 20.0,
        "(Lambda (3,3), Gamma v (3,), eta (3,), singular) of the tip's place (Eqs 2-5).");
  m.def("cartesian", &cartesian<6>, "model"_a, "q"_a, "v"_a, "rotor_inertia"_a = nb::none(), "heaviest"_a = 20.0,
        "(Lambda (6,6), Gamma v (6,), eta (6,), singular) of the tip's place and orientation (Eqs 2-5).");
}

}  // namespace palpate::bindings
