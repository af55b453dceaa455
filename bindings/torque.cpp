#include "palpate/torque/torque.hpp"

#include <nanobind/stl/string.h>

#include <string>

#include "bindings.hpp"
#include "convert.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using torque::Mode;
using torque::Options;

std::string mode_name(const Options& o) { return o.mode == Mode::full ? "full" : "paper"; }

void set_mode(Options& o, const std::string& name) {
  if (name != "full" && name != "paper") {
    throw std::invalid_argument("torque mode must be 'full' or 'paper' (first three joints only); got '" + name + "'");
  }
  o.mode = name == "full" ? Mode::full : Mode::paper;
}

using Vector = Eigen::VectorXd;

/// `model` is the controller's arm; F_H_L (6,) the wrench to render on the hand.
nb::tuple step(torque::Torque& self, arm::Arm& model, const Vector& q_in, const Vector& v_in, const Vec6& F) {
  const JointVector q = joint_vector(q_in, "q", model.n());
  const JointVector v = joint_vector(v_in, "v", model.n());
  LeaderCommand out;
  model.update(q, v);
  const bool limited = self.step(model, q, v, {F.head<3>(), F.tail<3>()}, out);
  return nb::make_tuple(Vector(out.tau_force), Vector(out.tau_gravity), Vector(out.tau_platform), to_vector(out.F_H_L),
                        limited);
}

}  // namespace

void bind_torque(nb::module_& m) {
  nb::class_<Options>(m, "TorqueOptions", "Torques that render a force and hold the arm's own weight.")
      .def(nb::init<>())
      .def_prop_rw("mode", &mode_name, &set_mode, "'full', or 'paper': first three joints, wrist torques zero")
      .def_rw("gravity_gain", &Options::gravity_gain, "0 switches gravity compensation off")
      .def_rw("platform_gain", &Options::platform_gain, "joint-4 controller, 0..1 (7-joint arms, full mode)");

  nb::class_<torque::Torque>(m, "Torque", "tau = tau_force + tau_gravity + tau_platform, within the drive limits.")
      .def(
          "__init__",
          [](torque::Torque* self, const Options& options, const Vector& tau_max) {
            new (self) torque::Torque(options, joint_vector(tau_max, "tau_max"));
          },
          "options"_a, "tau_max"_a)
      .def("step", &step, "model"_a, "q"_a, "v"_a, "F_H_L"_a,
           "(tau_force, tau_gravity, tau_platform, F_H_L as truly rendered (6,), a drive limit was reached).");
}

}  // namespace palpate::bindings
