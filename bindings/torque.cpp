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

}  // namespace

void bind_torque(nb::module_& m) {
  nb::class_<Options>(m, "TorqueOptions", "Torques that render a force and hold the arm's own weight.")
      .def(nb::init<>())
      .def_prop_rw("mode", &mode_name, &set_mode, "'full', or 'paper': first three joints, wrist torques zero")
      .def_rw("gravity_gain", &Options::gravity_gain, "0 switches gravity compensation off")
      .def_rw("platform_gain", &Options::platform_gain, "joint-4 null-space controller, 0..1");
}

}  // namespace palpate::bindings
