#include <nanobind/eigen/dense.h>
#include <nanobind/stl/string.h>

#include "bindings.hpp"
#include "convert.hpp"
#include "palpate/loop/realtime.hpp"
#include "palpate/loop/tick.hpp"
#include "palpate/types/arms.hpp"
#include "timing.hpp"
#include "types.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using loop::Tick;

void bind_table(nb::module_& m) {
  m.attr("TICK_BYTES") = sizeof(Tick);
  m.def(
      "signals",
      [] {
        using Row = Tuple<nb::str, int, int, nb::str, nb::str, nb::str, bool, nb::str>;
        nb::typed<nb::list, Row> rows;
        for (const loop::Signal& s : loop::signals()) {
          rows.append(nb::make_tuple(s.name, s.offset, s.size, s.unit, s.frame, s.doc, s.deterministic, s.stage));
        }
        return rows;
      },
      "Table of signals, with one row (name, byte offset, number of doubles, unit, frame, doc, deterministic, stage) "
      "for each.");
  m.def(
      "status_words",
      [] {
        nb::typed<nb::list, Tuple<nb::str, int, nb::str>> rows;
        for (const StatusDescription& s : status_descriptions()) {
          rows.append(nb::make_tuple(s.name, s.bit, s.description));
        }
        return rows;
      },
      "Bits of the signal `status`, the gravest first, with one row (name, bit, description) for each.");
}

void bind_controls(nb::module_& m) {
  nb::class_<Controls>(m, "Controls", "Values that the operator may change during a run.")
      .def(nb::init<>())
      .def_rw("following", &Controls::following, "True: the tool follows the hand, and the hand receives forces.")
      .def_rw("clutch", &Controls::clutch,
              "True: the clutch pedal is pressed; the hand moves freely and the tool stays.")
      .def_rw("paused", &Controls::paused, "True: simulated time stands still.")
      .def_rw("hold", &Controls::hand_paused, "True: the simulated hand stays where it is on its path.")
      .def_rw("stiffness_scale", &Controls::stiffness_scale, "Factor on the stiffness of every object [-].")
      .def_rw("damping_scale", &Controls::damping_scale, "Factor on the damping of every object [-].")
      .def_rw("guidance", &Controls::guidance,
              "Position of the guidance pedal, 0-1, for fixtures with a ramp by pedal [-].")
      .def_rw("p_hand_offset_W", &Controls::p_hand_offset_W, "Offset added to the hand's intended position (3,) [m].");
}

void bind_realtime(nb::module_& m) {
  using loop::BareLoop;
  using loop::RealTimeOptions;
  nb::class_<RealTimeOptions>(m, "RealTimeOptions", "What the real-time thread may request from the operating system.")
      .def(nb::init<>())
      .def_rw("allow_priority", &RealTimeOptions::allow_priority,
              "True: the thread may request SCHED_FIFO and locked memory.")
      .def_rw("allow_affinity", &RealTimeOptions::allow_affinity, "True: the thread may bind itself to one core.")
      .def_rw("priority", &RealTimeOptions::priority, "Priority of SCHED_FIFO, 1..99.")
      .def_rw("spin_us", &RealTimeOptions::spin_us,
              "Time before a deadline that the thread spends in a busy wait [us].");

  nb::class_<BareLoop>(m, "BareLoop", "A loop that only keeps time, as a baseline for the punctuality of a machine.")
      .def(nb::init<double, loop::RealTimeOptions>(), "rate"_a, "options"_a = loop::RealTimeOptions{}, "rate [Hz].")
      .def("start", &BareLoop::start, nb::call_guard<nb::gil_scoped_release>(), "Starts the thread.")
      .def("stop", &BareLoop::stop, nb::call_guard<nb::gil_scoped_release>(), "Ends the thread.")
      .def(
          "timing", [](const BareLoop& self) { return punctuality(self.thread()); },
          "Punctuality so far: lateness_us, slack_us, ticks, missed_ticks, scheduler.");
}

}  // namespace

void bind_loop(nb::module_& m) {
  bind_table(m);
  bind_controls(m);
  bind_realtime(m);
}

}  // namespace palpate::bindings
