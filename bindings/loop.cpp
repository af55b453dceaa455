#include <nanobind/stl/string.h>

#include "bindings.hpp"
#include "convert.hpp"
#include "palpate/loop/realtime.hpp"
#include "palpate/loop/tick.hpp"
#include "palpate/types/arms.hpp"
#include "timing.hpp"

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
        nb::list rows;
        for (const loop::Signal& s : loop::signals()) {
          rows.append(nb::make_tuple(s.name, s.offset, s.size, s.unit, s.frame, s.doc, s.deterministic, s.stage));
        }
        return rows;
      },
      "The table of signals: (name, byte offset, doubles, unit, frame, doc, deterministic, stage) per row.");
  m.def(
      "status_words",
      [] {
        nb::list rows;
        for (const StatusWords& s : status_words()) {
          rows.append(nb::make_tuple(s.name, s.bit, s.words));
        }
        return rows;
      },
      "The bits of the signal `status`, the gravest first: (name, bit, words) per row.");
}

void bind_controls(nb::module_& m) {
  nb::class_<Controls>(m, "Controls", "What a person may change while it runs.")
      .def(nb::init<>())
      .def_rw("following", &Controls::following, "the tool follows the hand, the hand is given forces")
      .def_rw("clutch", &Controls::clutch, "pedal pressed: the hand moves freely, the tool stays")
      .def_rw("paused", &Controls::paused, "simulated time stands still")
      .def_rw("hold", &Controls::hold, "the simulated hand waits where its path is")
      .def_rw("stiffness_scale", &Controls::stiffness_scale, "times every object's stiffness")
      .def_rw("damping_scale", &Controls::damping_scale, "times every object's damping")
      .def_rw("guidance", &Controls::guidance, "pedal of guidance, 0-1, for fixtures that fade with it")
      .def_rw("p_hand_offset_W", &Controls::p_hand_offset_W, "added to the hand's intended position, (3,) [m]");
}

void bind_realtime(nb::module_& m) {
  using loop::BareLoop;
  using loop::RealTimeOptions;
  nb::class_<RealTimeOptions>(m, "RealTimeOptions", "What the real-time thread may ask of the system.")
      .def(nb::init<>())
      .def_rw("allow_priority", &RealTimeOptions::allow_priority, "SCHED_FIFO and locked memory")
      .def_rw("allow_affinity", &RealTimeOptions::allow_affinity, "one core for the loop")
      .def_rw("priority", &RealTimeOptions::priority, "of SCHED_FIFO, 1..99")
      .def_rw("spin_us", &RealTimeOptions::spin_us, "last stretch before a deadline awaited awake [us]");

  nb::class_<BareLoop>(m, "BareLoop", "A loop that only keeps time: what the machine itself can do.")
      .def(nb::init<double, loop::RealTimeOptions>(), "rate"_a, "options"_a = loop::RealTimeOptions{})
      .def("start", &BareLoop::start, nb::call_guard<nb::gil_scoped_release>())
      .def("stop", &BareLoop::stop, nb::call_guard<nb::gil_scoped_release>())
      .def(
          "timing", [](const BareLoop& self) { return punctuality(self.thread()); },
          "lateness_us, slack_us, ticks, missed_ticks, scheduler.");
}

}  // namespace

void bind_loop(nb::module_& m) {
  bind_table(m);
  bind_controls(m);
  bind_realtime(m);
}

}  // namespace palpate::bindings
