#include "palpate/stability/stability.hpp"

#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>

#include <array>
#include <string>

#include "bindings.hpp"
#include "convert.hpp"
#include "doc.hpp"
#include "palpate/types/low_pass.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using stability::CertainFriction;
using stability::Options;

constexpr std::array kModes = {"off", "observer", "tank"};  // in the order of stability::Passivity

std::string mode(const Options& o) { return kModes[static_cast<std::size_t>(o.passivity.mode)]; }

void set_mode(Options& o, const std::string& name) {
  for (std::size_t i = 0; i < kModes.size(); ++i) {
    if (name == kModes[i]) {
      o.passivity.mode = static_cast<stability::Passivity>(i);
      return;
    }
  }
  throw std::invalid_argument("stability.passivity must be 'observer', 'tank' or 'off'; got '" + name + "'");
}

template <typename Class>
void observer_field(Class& c, const char* name, double stability::ObserverOptions::* field, const char* doc) {
  c.def_prop_rw(
      name, [field](const Options& o) { return o.passivity.observer.*field; },
      [field](Options& o, double x) { o.passivity.observer.*field = x; }, doc);
}

template <typename Class>
void passivity_field(Class& c, const char* name, double stability::PassivityOptions::* field, const char* doc) {
  c.def_prop_rw(
      name, [field](const Options& o) { return o.passivity.*field; },
      [field](Options& o, double x) { o.passivity.*field = x; }, doc);
}

void bind_stability_options(nb::module_& m) {
  nb::class_<CertainFriction> friction(m, "CertainFriction", "Certified lower bounds of a device's friction.");
  friction.def(nb::init<>());
  joint_field(friction, "coulomb", &CertainFriction::coulomb, "Coulomb friction (n,) [N m, N].");
  joint_field(friction, "viscous", &CertainFriction::viscous, "Viscous friction (n,) [N m s/rad, N s/m].");
  joint_field(friction, "quantum", &CertainFriction::quantum, "Resolution of the joint positions (n,) [rad, m].");
  friction.def_rw("at_handle", &CertainFriction::at_handle,
                  "True: the entries (3,) belong to the position of the handle in L, not to joints."_doc);

  nb::class_<Options> options(m, "StabilityOptions",
                              "Options of the stage `stability`, which limits what the hand receives.");
  options.def(nb::init<>())
      .def_rw("force_cap", &Options::force_cap, "Largest force on the hand [N]."_doc)
      .def_rw("rate_cap", &Options::rate_cap,
              "Largest rate of change of the force, also that of the ramp to zero [N/s]."_doc)
      .def_rw("moment_cap", &Options::moment_cap, "Largest moment on the hand [N m]; 0: forces only."_doc)
      .def_rw("moment_rate_cap", &Options::moment_rate_cap, "Largest rate of change of the moment [N m/s]."_doc)
      .def_rw("gripper_cap", &Options::gripper_cap,
              "Largest torque on the operator's fingers; 0: the gripper has no motor [N m]."_doc)
      .def_rw("stale_after", &Options::stale_after, "Age above which measured states are not trusted [s]."_doc)
      .def_prop_rw(
          "passivity", &mode, &set_mode,
          nb::for_getter(nb::sig("def passivity(self) -> typing.Literal['observer', 'tank', 'off']")),
          nb::for_setter(nb::sig("def passivity(self, mode: typing.Literal['observer', 'tank', 'off'], /) -> None")),
          "Mode of the passivity controller: 'observer', 'tank' or 'off'.")
      .def_prop_rw(
          "friction", [](const Options& o) { return o.passivity.friction; },
          [](Options& o, const CertainFriction& f) { o.passivity.friction = f; },
          "Certified friction of the device. This is a copy: assign a whole one.")
      .def_prop_rw(
          "low_pass", [](const Options& o) { return o.low_pass.cutoff; },
          [](Options& o, double x) { o.low_pass.cutoff = x; },
          "Cutoff of the low-pass on the force to be rendered [Hz]; 0: no low-pass.")
      .def_prop_rw(
          "coupling_stiffness", [](const Options& o) { return o.coupling.stiffness; },
          [](Options& o, double x) { o.coupling.stiffness = x; },
          "Stiffness of the virtual coupling [N/m]; 0: no coupling.")
      .def_prop_rw(
          "coupling_damping", [](const Options& o) { return o.coupling.damping; },
          [](Options& o, double x) { o.coupling.damping = x; },
          "Damping of the virtual coupling, in parallel with its spring [N s/m].");
  using O = stability::ObserverOptions;
  observer_field(options, "delay", &O::delay, "Known delay of the loop [s].");
  observer_field(options, "quantum", &O::quantum, "Resolution of the handle's position [m].");
  observer_field(options, "allowance", &O::allowance,
                 "Energy that may be returned in excess of the certified input energy [J].");
  observer_field(options, "acceleration", &O::acceleration, "Largest assumed acceleration of the handle [m/s^2].");
  observer_field(options, "angular_acceleration", &O::angular_acceleration,
                 "Largest assumed angular acceleration of the handle [rad/s^2].");
  using P = stability::PassivityOptions;
  passivity_field(options, "delay_doubt", &P::delay_doubt, "The true delay may exceed `delay` by up to this time [s].");
  passivity_field(options, "tank_capacity", &P::capacity,
                  "Capacity of the energy tank, and bound of the outstanding credit in all modes [J].");
  passivity_field(options, "moving_share", &P::moving_share,
                  "Fraction of the work of moving surfaces and other instruments that the hand may receive.");
  passivity_field(options, "speed", &P::speed,
                  "Fastest motion along the largest force for which the account keeps a reserve [m/s].");
  passivity_field(options, "angular_speed", &P::angular_speed,
                  "Fastest rotation along the largest moment for which the account keeps a reserve [rad/s].");
}

}  // namespace

void bind_stability(nb::module_& m) {
  bind_stability_options(m);
  m.def("low_pass_share", &low_pass_coefficient, "cutoff"_a, "dt"_a,
        "Coefficient a of the low-pass y_k = y_k-1 + a (u_k - y_k-1). cutoff [Hz], 0: no low-pass; dt [s].");
}

}  // namespace palpate::bindings
