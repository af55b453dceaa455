#include "palpate/torque/torque.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>

#include <optional>
#include <string>

#include "bindings.hpp"
#include "convert.hpp"
#include "doc.hpp"
#include "palpate/torque/cartesian.hpp"
#include "types.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using torque::ControlLawOptions;
using torque::FrictionOptions;
using torque::LimitOptions;
using torque::Mode;

std::string mode_name(const torque::Options& o) { return o.mode == Mode::full ? "full" : "paper"; }

void set_mode(torque::Options& o, const std::string& name) {
  if (name != "full" && name != "paper") {
    throw std::invalid_argument("torque mode must be 'full' or 'paper' (first three joints only); got '" + name + "'");
  }
  o.mode = name == "full" ? Mode::full : Mode::paper;
}

/// Runs one tick. model: the controller's arm; F: wrench F_H_L (6,) to be rendered; F_cell_L (3,): force of the load
/// cell.
std::pair<LeaderCommand, unsigned> step_torque(torque::Torque& self, arm::Arm& model, const VectorArg& q,
                                               const VectorArg& v, const Vec6& F, const std::optional<Vec3>& F_cell_L,
                                               bool fresh) {
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
  nb::class_<LeaderCommand> command(m, "LeaderCommand", "Torques for the leader, as separate terms.");
  terms(command, &LeaderCommand::tau_force, "tau_force", "J^T (F_H_L + F_law_L) (n,) [N m].");
  terms(command, &LeaderCommand::tau_gravity, "tau_gravity", "Gravity compensation (n,) [N m].");
  terms(command, &LeaderCommand::tau_platform, "tau_platform",
        "Torque of the controller of joint 4, the platform (n,) [N m].");
  terms(command, &LeaderCommand::tau_friction, "tau_friction", "Friction compensation (n,) [N m].");
  terms(command, &LeaderCommand::tau_limits, "tau_limits", "Torque of the soft stops (n,) [N m].");
  command
      .def_prop_ro(
          "tau", [](const LeaderCommand& c) -> Vector { return c.support_torque() + c.response_torque(); },
          "Sum of all terms (n,) [N m].")
      .def_prop_ro(
          "F_H_L", [](const LeaderCommand& c) -> Vector { return to_vector(c.F_H_L); },
          "Wrench rendered on the hand within the drive limits (6,) [N, N m].")
      .def_prop_ro(
          "F_law_L", [](const LeaderCommand& c) -> Vector { return to_vector(c.F_law_L); },
          "Wrench that the control law adds to F_H_L (6,) [N, N m].")
      .def_ro("F_neglected", &LeaderCommand::F_neglected,
              "Force of the arm's inertia and Coriolis terms that the law does not compensate [N]."_doc);
}

void bind_torque_options(nb::module_& m) {
  nb::class_<torque::Options> options(m, "TorqueOptions", "Options of the stage `torque`.");
  options.def(nb::init<>())
      .def_rw("law", &torque::Options::law, "Control law: 'stiffness' (the paper's), 'impedance' or 'admittance'."_doc)
      .def_prop_rw("mode", &mode_name, &set_mode, "'full', or 'paper': torques on the first three joints only.")
      .def_rw("force_gain", &torque::Options::force_gain, "Gain of tau_force [-]; 0 switches it off."_doc)
      .def_rw("gravity_gain", &torque::Options::gravity_gain,
              "Gain of the gravity compensation [-]; 0 switches it off."_doc)
      .def_rw("platform_gain", &torque::Options::platform_gain,
              "Gain of the controller of joint 4, 0..1 [-], for MTMs with seven joints in mode 'full'."_doc)
      .def_rw("friction", &torque::Options::friction, "Options of the friction compensation."_doc)
      .def_rw("limits", &torque::Options::limits, "Options of the soft stops."_doc)
      .def_rw("laws", &torque::Options::laws, "Options of the control laws."_doc)
      .def_rw("law_cap", &torque::Options::law_cap, "Largest force that a law may add to the rendered force [N]."_doc)
      .def_rw("fast_force", &torque::Options::fast_force,
              "F_neglected above which the status bit too_fast is set [N]."_doc);
  joint_field(options, "rotor_inertia", &torque::Options::rotor_inertia,
              "Rotor inertias in the controller's model (n,) [kg m^2].");

  nb::class_<FrictionOptions> friction(m, "FrictionOptions",
                                       "Options of the friction compensation, which never drives the arm.");
  friction.def(nb::init<>())
      .def_rw("gain", &FrictionOptions::gain,
              "Fraction of the friction that is compensated, 0..1 [-]; 0 switches it off."_doc)
      .def_rw("dead_band", &FrictionOptions::dead_band, "Speed below which nothing is compensated [rad/s, m/s]."_doc)
      .def_rw("full_speed", &FrictionOptions::full_speed,
              "Speed from which on the compensation is complete [rad/s, m/s]."_doc);
  joint_field(friction, "coulomb", &FrictionOptions::coulomb, "Coulomb friction in the controller's model (n,) [N m].");
  joint_field(friction, "viscous", &FrictionOptions::viscous,
              "Viscous friction in the controller's model (n,) [N m s/rad].");

  nb::class_<LimitOptions>(m, "LimitOptions", "Options of the soft stops before the joint limits.")
      .def(nb::init<>())
      .def_rw("gain", &LimitOptions::gain,
              "Torque at the joint limit, as a fraction of the drive's limit [-]; 0 switches the soft stops off."_doc)
      .def_rw("margin", &LimitOptions::margin, "Width of a soft stop, as a fraction of the joint's range [-]."_doc);

  nb::class_<ControlLawOptions>(m, "ControlLawOptions", "Options of the control laws; each law reads its own.")
      .def(nb::init<>())
      .def_rw("shape_inertia", &ControlLawOptions::shape_inertia,
              "impedance: True gives the handle the inertia virtual_mass; this needs a load cell."_doc)
      .def_rw(
          "virtual_mass", &ControlLawOptions::virtual_mass,
          "Inertia of the handle that the hand feels [kg], for admittance, and for impedance with shape_inertia."_doc)
      .def_rw("virtual_damping", &ControlLawOptions::virtual_damping,
              "admittance: damping of the handle that the hand feels [N s/m]."_doc)
      .def_rw("servo_bandwidth", &ControlLawOptions::servo_bandwidth,
              "admittance: bandwidth of the position loop [Hz]."_doc);
}

}  // namespace

void bind_torque(nb::module_& m) {
  bind_command(m);
  bind_torque_options(m);
  nb::class_<torque::Torque>(m, "Torque",
                             "The stage `torque`: joint torques of one control law, within the drive limits.")
      .def(
          "__init__",
          [](torque::Torque* self, const torque::Options& options, const VectorArg& tau_max, double dt) {
            new (self) torque::Torque(options, joint_vector(tau_max, "tau_max"), dt);
          },
          "options"_a, "tau_max"_a, "dt"_a = 1e-3,
          "tau_max (n,): torque limits of the drives [N m]; dt: period of the cycle [s].")
      .def("step", &step_torque, "model"_a, "q"_a, "v"_a, "F_H_L"_a, "F_cell_L"_a = nb::none(), "fresh"_a = true,
           "One tick: (LeaderCommand that renders F_H_L (6,) [N, N m], status bits). F_cell_L (3,): measured force of "
           "the arm on the hand [N]. fresh: False resets the control law, because the state of the leader is not new.");
  m.def("removed_friction", &torque::removed_friction, "options"_a, "dt"_a,
        "Fraction of the arm's friction that friction compensation or the control law removes. dt: period [s].");
  m.def("cartesian_place", &cartesian<3>, "model"_a, "q"_a, "v"_a, "rotor_inertia"_a = nb::none(), "heaviest"_a = 20.0,
        "Dynamics of the tip's position (Eqs 2-5): (Lambda (3,3) [kg], Gamma v (3,) [N], eta (3,) [N], singular). "
        "Eigenvalues of Lambda above heaviest [kg] are set to it, and singular is True.");
  m.def("cartesian", &cartesian<6>, "model"_a, "q"_a, "v"_a, "rotor_inertia"_a = nb::none(), "heaviest"_a = 20.0,
        "Dynamics of the tip's position and orientation (Eqs 2-5): (Lambda (6,6), Gamma v (6,), eta (6,), singular), "
        "as for cartesian_place.");
}

}  // namespace palpate::bindings
