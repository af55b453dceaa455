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
           "robot: the simulation; twin: a second one that answers queries. No other object may use them until stop(). "
           "rate: "
           "rate of the measured states [Hz].")
      .def("stop", &Robot::stop, nb::call_guard<nb::gil_scoped_release>(),
           "Powers off, publishes the new states and ends the threads.")
      .def_prop_ro("rate", &Robot::rate, "Rate of the measured states [Hz].")
      .def_prop_ro(
          "scheduler", [](const Robot& r) { return r.servo().scheduler(); }, "Scheduling that the system granted.")
      .def_prop_ro(
          "missed", [](const Robot& r) { return r.servo().punctuality().missed.load(); },
          "Number of servo ticks that were missed [-].")
      .def_prop_ro("rounds", &Robot::rounds, "Number of times that all measured states were published [-].")
      .def_prop_ro("commands", &Robot::commands, "Number of commands received [-].")
      .def_prop_ro("dropped", &Robot::dropped,
                   "Number of commands lost because they arrived faster than the servo takes them [-].");
}

}  // namespace palpate::ros
