#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include "bind.hpp"
#include "sim/robot.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::ros {

void bind_sim(nb::module_& m) {
  nb::class_<Robot>(m, "Robot", "The simulated dVRK on ROS 2; it runs until stop().")
      .def(nb::init<std::shared_ptr<Context>, dvrk::System&, dvrk::System&, double>(), "context"_a, "robot"_a, "twin"_a,
           "rate"_a, nb::keep_alive<1, 3>(), nb::keep_alive<1, 4>(), nb::call_guard<nb::gil_scoped_release>(),
           "robot and its twin, which answers queries, are nobody else's meanwhile; rate of measures [Hz].")
      .def("stop", &Robot::stop, nb::call_guard<nb::gil_scoped_release>(), "Powers off, tells it, ends its threads.")
      .def_prop_ro("rate", &Robot::rate, "Of measures [Hz].")
      .def_prop_ro(
          "scheduler", [](const Robot& r) { return r.servo().scheduler(); }, "What the system granted.")
      .def_prop_ro(
          "missed", [](const Robot& r) { return r.servo().punctuality().missed.load(); }, "Servo ticks late.")
      .def_prop_ro("rounds", &Robot::rounds, "How often everything measured was published [-].")
      .def_prop_ro("commands", &Robot::commands, "Commands received [-].")
      .def_prop_ro("dropped", &Robot::dropped, "Commands that came faster than the servo took them [-].");
}

}  // namespace palpate::ros
