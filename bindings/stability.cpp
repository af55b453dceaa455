#include "palpate/stability/stability.hpp"

#include <nanobind/stl/tuple.h>

#include "bindings.hpp"
#include "convert.hpp"
#include "palpate/stability/ledger.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {

void bind_stability(nb::module_& m) {
  using stability::Energy;
  using stability::Ledger;
  using stability::Limiter;
  using stability::Options;
  nb::class_<Options>(m, "StabilityOptions", "What may reach the hand.")
      .def(nb::init<>())
      .def_rw("force_cap", &Options::force_cap, "largest force on the hand [N]")
      .def_rw("rate_cap", &Options::rate_cap, "largest change of it, and the ramp to zero [N/s]")
      .def_rw("moment_cap", &Options::moment_cap, "largest moment on the hand [N m]; 0: forces only")
      .def_rw("moment_rate_cap", &Options::moment_rate_cap, "largest change of it [N m/s]")
      .def_rw("stale_after", &Options::stale_after, "states older than this are not trusted [s]");

  nb::class_<Limiter>(m, "Limiter", "Stage `stability`: finite, below its cap, no faster than its rate cap. Always.")
      .def(nb::init<const Options&, double>(), "options"_a, "dt"_a)
      .def(
          "step",
          [](Limiter& self, const VectorArg& F_H_L, double t, double t_leader, double t_follower, bool leader_valid,
             bool follower_valid, bool engaged) {
            const stability::Output out =
                self.step({wrench(F_H_L, "F_H_L"), t, t_leader, t_follower, leader_valid, follower_valid, engaged});
            const Eigen::Index n = F_H_L.values.size();
            return std::make_tuple(Eigen::VectorXd(to_vector(out.F_H_L).head(n)),
                                   Eigen::VectorXd(to_vector(out.F_cut).head(n)), out.status);
          },
          "F_H_L"_a, "t"_a = 0.0, "t_leader"_a = 0.0, "t_follower"_a = 0.0, "leader_valid"_a = true,
          "follower_valid"_a = true, "engaged"_a = true,
          "One tick, a force (3,) or a wrench (6,): (F_H_L rendered, F_cut, status bits).");

  nb::class_<Ledger>(m, "Ledger", "Energy at the hand's port: each force times the motion while it was held.")
      .def(nb::init<>())
      .def(
          "step",
          [](Ledger& self, const Vec3& p_LH, const VectorArg& F_H_L, const VectorArg& F_damping, const VectorArg& F_cut,
             double spring, const Eigen::Matrix3d& R_LH) {
            const Energy& e = self.step(
                {R_LH, p_LH}, {wrench(F_H_L, "F_H_L"), wrench(F_damping, "F_damping"), wrench(F_cut, "F_cut")}, spring);
            return std::make_tuple(e.port, e.spring, e.damping, e.cut);
          },
          "p_LH"_a, "F_H_L"_a, "F_damping"_a, "F_cut"_a, "spring"_a,
          "R_LH"_a = Eigen::Matrix3d(Eigen::Matrix3d::Identity()),
          "One tick, forces (3,) or wrenches (6,) in L: (port, spring, damping, cut) [J].");
}

}  // namespace palpate::bindings
