#include "palpate/stability/stability.hpp"

#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <array>
#include <string>

#include "bindings.hpp"
#include "convert.hpp"
#include "palpate/stability/ledger.hpp"
#include "palpate/types/low_pass.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using stability::CertainFriction;
using stability::Energy;
using stability::Ledger;
using stability::Limiter;
using stability::Observer;
using stability::Options;
using stability::Output;
using stability::Stability;

constexpr std::array kModes = {"off", "observer", "tank"};  // as in stability::Passivity

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

void bind_options(nb::module_& m) {
  nb::class_<CertainFriction> friction(m, "CertainFriction",
                                       "The part of a device's friction that is certain, per joint.");
  friction.def(nb::init<>());
  joint_field(friction, "coulomb", &CertainFriction::coulomb, "[N m, N]");
  joint_field(friction, "viscous", &CertainFriction::viscous, "[N m s/rad, N s/m]");
  joint_field(friction, "quantum", &CertainFriction::quantum, "resolution of the joint's position [rad, m]");

  nb::class_<Options> options(m, "StabilityOptions", "What may reach the hand.");
  options.def(nb::init<>())
      .def_rw("force_cap", &Options::force_cap, "largest force on the hand [N]")
      .def_rw("rate_cap", &Options::rate_cap, "largest change of it, and the ramp to zero [N/s]")
      .def_rw("moment_cap", &Options::moment_cap, "largest moment on the hand [N m]; 0: forces only")
      .def_rw("moment_rate_cap", &Options::moment_rate_cap, "largest change of it [N m/s]")
      .def_rw("stale_after", &Options::stale_after, "states older than this are not trusted [s]")
      .def_prop_rw(
          "passivity", &mode, &set_mode,
          nb::for_getter(nb::sig("def passivity(self) -> typing.Literal['observer', 'tank', 'off']")),
          nb::for_setter(nb::sig("def passivity(self, mode: typing.Literal['observer', 'tank', 'off'], /) -> None")))
      .def_prop_rw(
          "friction", [](const Options& o) { return o.passivity.friction; },
          [](Options& o, const CertainFriction& f) { o.passivity.friction = f; },
          "of the device; a copy, assign it whole")
      .def_prop_rw(
          "low_pass", [](const Options& o) { return o.low_pass.cutoff; },
          [](Options& o, double x) { o.low_pass.cutoff = x; }, "of the wanted force [Hz]; 0: none")
      .def_prop_rw(
          "coupling_stiffness", [](const Options& o) { return o.coupling.stiffness; },
          [](Options& o, double x) { o.coupling.stiffness = x; }, "of the virtual coupling [N/m]; 0: none")
      .def_prop_rw(
          "coupling_damping", [](const Options& o) { return o.coupling.damping; },
          [](Options& o, double x) { o.coupling.damping = x; }, "beside its spring [N s/m]");
  using O = stability::ObserverOptions;
  observer_field(options, "delay", &O::delay, "known, of the loop [s]");
  observer_field(options, "quantum", &O::quantum, "resolution of the handle's position [m]");
  observer_field(options, "allowance", &O::allowance, "may be given beyond what came in [J]");
  observer_field(options, "tank_capacity", &O::capacity, "of the tank [J]");
  observer_field(options, "acceleration", &O::acceleration, "nobody snatches the handle away faster [m/s^2]");
  observer_field(options, "angular_acceleration", &O::angular_acceleration, "nor turns it [rad/s^2]");
}

void bind_stage(nb::module_& m) {
  const auto vector = [](Wrench Output::* field) {
    return [field](const Output& o) -> Eigen::VectorXd { return to_vector(o.*field); };
  };
  nb::class_<Output>(m, "StabilityOutput", "One tick of the stage; wrenches (6,) on the hand in L.")
      .def_prop_ro("F_H_L", vector(&Output::F_H_L), "rendered")
      .def_prop_ro("F_capped", vector(&Output::F_capped), "what the limiter was asked for")
      .def_prop_ro("F_coupling", vector(&Output::F_coupling), "what the virtual coupling kept")
      .def_prop_ro("F_low_pass", vector(&Output::F_low_pass), "what the low-pass kept")
      .def_prop_ro("F_passivity", vector(&Output::F_passivity), "what the passivity controller kept")
      .def_prop_ro(
          "lag",
          [](const Output& o) { return std::array{o.lag.coupling, o.lag.low_pass, o.lag.passivity, o.lag.caps}; },
          "of coupling, low-pass, passivity controller, caps [s]")
      .def_ro("status", &Output::status, "bits of Status");

  nb::class_<Stability>(m, "Stability", "Stage `stability`: coupling, low-pass, passivity controller, limiter.")
      .def(nb::init<const Options&, double>(), "options"_a, "dt"_a)
      .def(
          "step",
          [](Stability& self, const VectorArg& F_H_L, const Vec3& p_LH, const Vec3& v_LH, const Eigen::VectorXd& q,
             double stiffness, double t, double t_leader, bool engaged) {
            stability::Input in;
            in.wanted.F = wrench(F_H_L, "F_H_L");
            in.t = t;
            in.handle = {{t_leader, true}, {Mat3::Identity(), p_LH}, {v_LH, Vec3::Zero()}, 0.0, joint_vector(q, "q")};
            in.tool = {t, true};
            in.engaged = engaged;
            in.stiffness = stiffness;
            return self.step(in);
          },
          "F_H_L"_a, "p_LH"_a, "v_LH"_a, "q"_a = Eigen::VectorXd(), "stiffness"_a = 0.0, "t"_a = 0.0,
          "t_leader"_a = 0.0, "engaged"_a = true, "One tick; rendered() has to follow.")
      .def(
          "rendered", [](Stability& self, const VectorArg& F_H_L) { self.rendered(wrench(F_H_L, "F_H_L")); }, "F_H_L"_a,
          "What the drives left of it.")
      .def_prop_ro(
          "stored", [](const Stability& self) { return self.passivity().stored(); }, "may be given back [J]")
      .def_prop_ro(
          "reserved", [](const Stability& self) { return self.passivity().reserved(); },
          "of it, most that what is on its way may cost [J]");
}

void bind_limiter(nb::module_& m) {
  nb::class_<Limiter>(m, "Limiter", "The end of stage `stability`: finite, below its cap, no faster than its rate cap.")
      .def(
          "__init__", [](Limiter* self, const Options& options, double dt) { new (self) Limiter(options, dt); },
          "options"_a, "dt"_a)
      .def(
          "step",
          [](Limiter& self, const VectorArg& F_H_L, double t, double t_leader, double t_follower, bool leader_valid,
             bool follower_valid, bool engaged) {
            const stability::Limited out =
                self.step({wrench(F_H_L, "F_H_L"), t, {t_leader, leader_valid}, {t_follower, follower_valid}, engaged});
            const Eigen::Index n = F_H_L.values.size();
            return std::make_tuple(Eigen::VectorXd(to_vector(out.F_H_L).head(n)),
                                   Eigen::VectorXd(to_vector(out.F_cut).head(n)), out.status);
          },
          "F_H_L"_a, "t"_a = 0.0, "t_leader"_a = 0.0, "t_follower"_a = 0.0, "leader_valid"_a = true,
          "follower_valid"_a = true, "engaged"_a = true,
          "One tick, a force (3,) or a wrench (6,): (F_H_L rendered, F_cut, status bits).");
}

void bind_energy(nb::module_& m) {
  nb::class_<Energy>(m, "Energy", "Entries of the ledger [J].")
      .def_ro("port", &Energy::port)
      .def_ro("spring", &Energy::spring)
      .def_ro("damping", &Energy::damping)
      .def_ro("cut", &Energy::cut)
      .def_ro("passivity", &Energy::passivity)
      .def_ro("source", &Energy::source);
  nb::class_<Ledger>(m, "Ledger", "Energy at the hand's port: each force times the motion while it acted.")
      .def(nb::init<double, double>(), "delay"_a = 0.0, "dt"_a = 1e-3)
      .def(
          "step",
          [](Ledger& self, const Vec3& p_LH, const VectorArg& F_H_L, const VectorArg& F_damping, const VectorArg& F_cut,
             double spring, const Eigen::Matrix3d& R_LH, const std::optional<Eigen::MatrixXd>& F_source) {
            stability::PortForces forces;
            forces.F_H_L = wrench(F_H_L, "F_H_L");
            forces.F_damping = wrench(F_damping, "F_damping");
            forces.F_cut = wrench(F_cut, "F_cut");
            for (Eigen::Index i = 0; F_source && i < std::min<Eigen::Index>(F_source->rows(), kSources); ++i) {
              forces.F_source[static_cast<std::size_t>(i)] = wrench(F_source->row(i), "F_source");
            }
            return self.step({R_LH, p_LH}, forces, spring);
          },
          "p_LH"_a, "F_H_L"_a, "F_damping"_a, "F_cut"_a, "spring"_a,
          "R_LH"_a = Eigen::Matrix3d(Eigen::Matrix3d::Identity()), "F_source"_a = nb::none(),
          "One tick, forces (3,) or wrenches (6,) in L, of each source a row: the energies [J].");

  nb::class_<Observer>(m, "PassivityObserver", "What the hand has surely put into the port; a force on one point.")
      .def(
          "__init__",
          [](Observer* self, const Options& o, double dt) { new (self) Observer(o.passivity.observer, dt); },
          "options"_a, "dt"_a)
      .def(
          "step",
          [](Observer& self, const Vec3& p_LH, const Vec3& v_LH, const Vec3& F_H_L) {
            self.step({Mat3::Identity(), p_LH}, {v_LH, Vec3::Zero()}, 0.0);
            self.sent({F_H_L, Vec3::Zero()});
            return self.stored();
          },
          "p_LH"_a, "v_LH"_a, "F_H_L"_a, "One tick, the force sent at its end: what may be given back [J].")
      .def_prop_ro("in_flight", &Observer::in_flight, "most that what was sent may still give [J]");
  nb::class_<stability::Dissipation>(m, "Dissipation", "What a device surely turns into heat.")
      .def(nb::init<CertainFriction, double>(), "friction"_a, "dt"_a)
      .def(
          "step",
          [](stability::Dissipation& self, const Eigen::VectorXd& q) { return self.step(joint_vector(q, "q")); }, "q"_a,
          "Measured joints of a tick: heat since the last one, at least [J].");
  m.def("held_cost", &stability::held_cost, "F"_a, "u"_a, "a"_a, "begin"_a, "end"_a,
        "F times the integral of max(0, u + a t) over [begin, end] [J].");
  m.def("ramp_cost", &stability::ramp_cost, "F"_a, "u"_a, "a"_a, "begin"_a, "rate"_a,
        "The same of a force that falls from F at begin by rate [N/s].");
  m.def("low_pass_share", &low_pass_share, "cutoff"_a, "dt"_a,
        "a of y_k = y_k-1 + a (u_k - y_k-1); cutoff [Hz], 0: none; dt [s].");
}

}  // namespace

void bind_stability(nb::module_& m) {
  bind_options(m);
  bind_stage(m);
  bind_limiter(m);
  bind_energy(m);
}

}  // namespace palpate::bindings
