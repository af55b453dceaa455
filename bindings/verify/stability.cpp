#include "palpate/stability/stability.hpp"

#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>

#include <array>
#include <limits>

#include "convert.hpp"
#include "doc.hpp"
#include "palpate/stability/ledger.hpp"
#include "verify/bindings.hpp"

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

void bind_stage(nb::module_& m) {
  const auto vector = [](Wrench Output::* field) {
    return [field](const Output& o) -> Eigen::VectorXd { return to_vector(o.*field); };
  };
  nb::class_<Output>(m, "StabilityOutput", "Output of one tick of the stage; wrenches (6,) on the hand in L [N, N m].")
      .def_prop_ro("F_H_L", vector(&Output::F_H_L), "Wrench to be rendered (6,).")
      .def_prop_ro("F_capped", vector(&Output::F_capped),
                   "Output of the limiter, input of the passivity controller (6,).")
      .def_prop_ro("F_coupling", vector(&Output::F_coupling), "Input minus output of the virtual coupling (6,).")
      .def_prop_ro("F_low_pass", vector(&Output::F_low_pass), "Input minus output of the low-pass (6,).")
      .def_prop_ro("F_passivity", vector(&Output::F_passivity), "Input minus output of the passivity controller (6,).")
      .def_prop_ro(
          "lag",
          [](const Output& o) { return std::array{o.lag.coupling, o.lag.low_pass, o.lag.passivity, o.lag.caps}; },
          "Lags of the coupling, the low-pass, the passivity controller and the caps [s].")
      .def_ro("status", &Output::status, "Status bits."_doc);

  nb::class_<Stability>(m, "Stability", "Stage `stability`: coupling, low-pass, passivity controller, limiter.")
      .def(nb::init<const Options&, double>(), "options"_a, "dt"_a, "dt: period of the cycle [s].")
      .def(
          "step",
          [](Stability& self, const VectorArg& F_H_L, const Vec3& p_LH, const Vec3& v_LH, const Eigen::VectorXd& q,
             double stiffness, double t, double t_leader, bool engaged, const Eigen::Matrix3d& R_LH, const Vec3& w_LH,
             double potential, double dt, double credit) {
            stability::Input in;
            in.commanded.F = wrench(F_H_L, "F_H_L");
            in.t = t;
            in.handle = {{t_leader, true}, {R_LH, p_LH}, {v_LH, w_LH}, 0.0, joint_vector(q, "q")};
            in.tool = {t, true};
            in.engaged = engaged;
            in.stiffness = stiffness;
            in.potential = potential;
            in.dt = dt;
            in.credit = credit;
            return self.step(in);
          },
          "F_H_L"_a, "p_LH"_a, "v_LH"_a, "q"_a = Eigen::VectorXd(), "stiffness"_a = 0.0, "t"_a = 0.0,
          "t_leader"_a = 0.0, "engaged"_a = true, "R_LH"_a = Eigen::Matrix3d(Eigen::Matrix3d::Identity()),
          "w_LH"_a = Vec3(Vec3::Zero()), "potential"_a = std::numeric_limits<double>::infinity(), "dt"_a = 0.0,
          "credit"_a = 0.0,
          "One tick at t [s] with the handle at p_LH (3,) [m], R_LH (3, 3), v_LH (3,) [m/s], w_LH (3,) [rad/s], joints "
          "q (n,), and the wrench F_H_L (6,) to be rendered. potential: energy that its springs store now [J]; "
          "infinity: unknown. dt: time since the last tick, 0: one period [s]; credit: energy of potentials that were "
          "switched on [J]. Call rendered() after each step.")
      .def(
          "rendered", [](Stability& self, const VectorArg& F_H_L) { self.rendered(wrench(F_H_L, "F_H_L")); }, "F_H_L"_a,
          "Reports the wrench (6,) that the drives rendered after their torque limits.")
      .def_prop_ro(
          "stored", [](const Stability& self) { return self.passivity().stored(); },
          "Energy that may be returned to the hand [J].")
      .def_prop_ro(
          "credited", [](const Stability& self) { return self.passivity().credited(); },
          "Energy credited and not yet repaid [J].")
      .def_prop_ro(
          "reserve", [](const Stability& self) { return self.passivity().reserve(); },
          "Energy that the account may hold beyond the potential, in mode 'observer' [J].")
      .def_prop_ro(
          "reserved", [](const Stability& self) { return self.passivity().reserved(); },
          "Part of `stored` that is reserved for wrenches still in the delay [J].");
}

void bind_limiter(nb::module_& m) {
  nb::class_<Limiter>(
      m, "Limiter",
      "Caps and watchdog of the stage `stability`: its output is finite and within the cap and the rate cap.")
      .def(
          "__init__", [](Limiter* self, const Options& options, double dt) { new (self) Limiter(options, dt); },
          "options"_a, "dt"_a, "dt: period of the cycle [s].")
      .def(
          "step",
          [](Limiter& self, const VectorArg& F_H_L, double t, double t_leader, double t_follower, bool leader_valid,
             bool follower_valid, bool engaged, double explained, double dt, double potential, double work) {
            const stability::Limited out = self.step({wrench(F_H_L, "F_H_L"),
                                                      t,
                                                      {t_leader, leader_valid},
                                                      {t_follower, follower_valid},
                                                      engaged,
                                                      explained,
                                                      dt,
                                                      potential,
                                                      work});
            const Eigen::Index n = F_H_L.values.size();
            return std::make_tuple(Eigen::VectorXd(to_vector(out.F_H_L).head(n)),
                                   Eigen::VectorXd(to_vector(out.F_cut).head(n)), out.status);
          },
          "F_H_L"_a, "t"_a = 0.0, "t_leader"_a = 0.0, "t_follower"_a = 0.0, "leader_valid"_a = true,
          "follower_valid"_a = true, "engaged"_a = true, "explained"_a = 0.0, "dt"_a = 0.0,
          "potential"_a = std::numeric_limits<double>::infinity(), "work"_a = 0.0,
          "One tick with a force (3,) or a wrench (6,): (F_H_L to be rendered, F_cut = input - output, status bits). "
          "explained: fall of the force that the motion explains [N]; dt: time since the last tick, 0: one period "
          "[s]; potential: energy of the springs behind the wrench, infinity: unknown [J]; work: of the hand since the "
          "last tick [J].");
}

void bind_energy(nb::module_& m) {
  nb::class_<Energy>(m, "Energy", "Entries of the energy ledger, at the hand's port [J].")
      .def_ro("port", &Energy::port,
              "Energy that the rendered force took from the hand; negative: generated energy."_doc)
      .def_ro("spring", &Energy::spring, "Energy stored in the contacts' springs."_doc)
      .def_ro("damping", &Energy::damping, "Energy dissipated by the damping forces."_doc)
      .def_ro("cut", &Energy::cut, "Energy of the force that the caps removed."_doc)
      .def_ro("passivity", &Energy::passivity, "Energy of the force that the passivity controller removed."_doc)
      .def_ro("source", &Energy::source, "Energy of the force of each source."_doc);
  nb::class_<Ledger>(m, "Ledger",
                     "Energy ledger at the hand's port: the work of each force on the motion during which it acts.")
      .def(nb::init<double, double>(), "delay"_a = 0.0, "dt"_a = 1e-3,
           "delay: known delay of the loop [s]; dt: period of the cycle [s].")
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
          "One tick with the handle at p_LH (3,) [m] and R_LH (3, 3). Forces (3,) or wrenches (6,) in L; F_source: one "
          "row for each source; spring: stored energy [J]. Returns the energies since the start [J].");
}

void bind_passivity(nb::module_& m) {
  nb::class_<Observer>(m, "PassivityObserver",
                       "Certified energy that the hand has put into the port, for a force at one point.")
      .def(
          "__init__",
          [](Observer* self, const Options& o, double dt) { new (self) Observer(o.passivity.observer, dt); },
          "options"_a, "dt"_a, "dt: nominal period of the cycle [s].")
      .def(
          "step",
          [](Observer& self, const Vec3& p_LH, const Vec3& v_LH, const Vec3& F_H_L, double dt) {
            self.step({Mat3::Identity(), p_LH}, {v_LH, Vec3::Zero()}, 0.0, dt);
            self.sent({F_H_L, Vec3::Zero()});
            return self.stored();
          },
          "p_LH"_a, "v_LH"_a, "F_H_L"_a, "dt"_a = 1e-3,
          "One tick, dt after the last one [s], with the handle at p_LH (3,) [m], v_LH (3,) [m/s]; F_H_L (3,) [N] is "
          "sent at its end. Returns the energy that may be returned to the hand [J].")
      .def_prop_ro("in_flight", &Observer::in_flight,
                   "Largest energy that the forces already sent can still give to the hand [J].");
  nb::class_<stability::Dissipation>(m, "Dissipation", "Certified energy that a device dissipates by friction.")
      .def(nb::init<CertainFriction, double>(), "friction"_a, "dt"_a, "dt: period of the cycle [s].")
      .def(
          "step",
          [](stability::Dissipation& self, const Eigen::VectorXd& q) { return self.step(joint_vector(q, "q")); }, "q"_a,
          "Certified dissipation since the last tick [J], from the measured joint positions q (n,).");
  m.def("held_cost", &stability::held_cost, "F"_a, "u"_a, "a"_a, "begin"_a, "end"_a,
        "Largest work of a constant force: F times the integral of max(0, u + a t) over [begin, end] [J]. F [N], u "
        "[m/s], a [m/s^2], times [s].");
  m.def("fade_cost", &stability::fade_cost, "F"_a, "u"_a, "a"_a, "begin"_a, "span"_a,
        "Largest work of a force that falls linearly from F at `begin` to zero within `span` [s]: the integral of the "
        "force times max(0, u + a t) [J].");
  m.attr("FADE") = stability::kFade;
}

}  // namespace

void bind_stability(nb::module_& m) {
  bind_stage(m);
  bind_limiter(m);
  bind_energy(m);
  bind_passivity(m);
}

}  // namespace palpate::bindings
