#include <nanobind/eigen/dense.h>
#include <nanobind/stl/string.h>

#include "bindings.hpp"
#include "convert.hpp"
#include "doc.hpp"
#include "palpate/loop/execution.hpp"
#include "palpate/loop/pace.hpp"
#include "palpate/loop/realtime.hpp"
#include "palpate/loop/session_machine.hpp"
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
      .def_rw("following", &Controls::following, "True: the tool follows the hand, and the hand receives forces."_doc)
      .def_rw("clutch", &Controls::clutch,
              "True: the clutch pedal is pressed; the hand moves freely and the tool stays."_doc)
      .def_rw("camera", &Controls::camera,
              "True: the camera pedal is pressed; the hands move the endoscope and the tool stays."_doc)
      .def_rw("power", &Controls::power, "True: the arms shall have power."_doc)
      .def_rw("home", &Controls::home, "True: the arms shall be homed."_doc)
      .def_rw("operator_present", &Controls::operator_present,
              "True: an operator is at the console, with the head in the viewer."_doc)
      .def_rw("hold_all", &Controls::hold_all, "True: everything holds where it is."_doc)
      .def_rw("recover_by_itself", &Controls::recover_by_itself, "True: a fault ends when its cause is gone."_doc)
      .def_rw(
          "take_back_requests", &Controls::take_back_requests,
          "A new number takes the shift of the tool against the hand back, which pauses after faults have left."_doc)
      .def_rw("recover_requests", &Controls::recover_requests, "A new number leaves a fault whose cause is gone."_doc)
      .def_rw("lock_rotation", &Controls::lock_rotation, "True: the tool keeps its orientation while it follows."_doc)
      .def_rw("lock_translation", &Controls::lock_translation,
              "True: the tool keeps its position while it follows, and the hand feels no force."_doc)
      .def_rw("scale", &Controls::scale, "Tool motion per hand motion; 0: as in the scene [-]."_doc)
      .def_rw("quat_WL", &Controls::quat_WL,
              "Orientation of the leader base in W (4,), w x y z; zeros: as in the scene."_doc)
      .def_rw("paused", &Controls::paused, "True: simulated time stands still."_doc)
      .def_rw("hold", &Controls::hand_paused, "True: the simulated hand stays where it is on its path."_doc)
      .def_rw("stiffness_scale", &Controls::stiffness_scale, "Factor on the stiffness of every object [-]."_doc)
      .def_rw("damping_scale", &Controls::damping_scale, "Factor on the damping of every object [-]."_doc)
      .def_rw("guidance", &Controls::guidance,
              "Position of the guidance pedal, 0-1, for fixtures with a ramp by pedal [-]."_doc)
      .def_rw("hand_pinch", &Controls::hand_pinch,
              "Pinch angle of the simulated hand instead of its path's [rad]; NaN: as the path says."_doc)
      .def_rw("p_hand_offset_W", &Controls::p_hand_offset_W,
              "Offset added to the hand's intended position (3,) [m]."_doc);
}

nb::typed<nb::list, Tuple<nb::str, nb::str, bool>> rows_of(std::span<const loop::SessionWord> words) {
  nb::typed<nb::list, Tuple<nb::str, nb::str, bool>> rows;
  for (const loop::SessionWord& w : words) rows.append(nb::make_tuple(w.name, w.description, w.request));
  return rows;
}

void bind_session(nb::module_& m) {
  using loop::SessionInput;
  using loop::SessionMachine;
  m.def(
      "session_states", [] { return rows_of(loop::session_states()); },
      "States of a session in the order of their numbers, with one row (name, description, False) for each.");
  m.def(
      "session_causes", [] { return rows_of(loop::session_causes()); },
      "Causes of transitions, with one row (name, description, True for a request of a person) for each.");
  m.def(
      "session_transitions",
      [] {
        nb::typed<nb::list, Tuple<nb::str, nb::str, nb::str>> rows;
        for (const loop::SessionTransition& row : loop::session_transitions()) {
          const auto name = [](std::span<const loop::SessionWord> words, auto value) {
            return words[static_cast<std::size_t>(value)].name;
          };
          rows.append(nb::make_tuple(name(loop::session_states(), row.from), name(loop::session_causes(), row.cause),
                                     name(loop::session_states(), row.to)));
        }
        return rows;
      },
      "Table of transitions (from, cause, to). In a state, the first row whose cause holds is taken.");
  nb::class_<SessionInput>(m, "SessionInput", "Levels that the state machine of a session reads in one tick.")
      .def(nb::init<>())
      .def_rw("power", &SessionInput::power, "Power is requested, and the arms have it."_doc)
      .def_rw("home", &SessionInput::home, "Homing is requested."_doc)
      .def_rw("at_home", &SessionInput::at_home, "Both arms report that they are homed."_doc)
      .def_rw("follow", &SessionInput::follow, "Teleoperation is requested, and an operator is at the console."_doc)
      .def_rw("aligned", &SessionInput::aligned, "Handle and tool have the same orientation."_doc)
      .def_rw("clutch", &SessionInput::clutch, "The clutch pedal is pressed."_doc)
      .def_rw("camera", &SessionInput::camera, "The camera pedal is pressed."_doc)
      .def_rw("hold", &SessionInput::hold, "A hold is requested."_doc)
      .def_rw("execute", &SessionInput::execute, "A planned motion waits, moves or pauses."_doc)
      .def_rw("moving", &SessionInput::moving, "A planned motion is not yet at rest."_doc)
      .def_rw("fault", &SessionInput::fault, "A state of an arm is missing or wrong."_doc)
      .def_rw("recover", &SessionInput::recover, "A fault may be left once its cause is gone."_doc)
      .def_rw("settled", &SessionInput::settled, "No fault for the time that the loop demands."_doc);
  nb::class_<SessionMachine>(m, "SessionMachine", "The state machine of a session, which every loop runs in its cycle.")
      .def(nb::init<>())
      .def(
          "step",
          [](SessionMachine& self, const SessionInput& in) {
            return loop::session_states()[static_cast<std::size_t>(self.step(in))].name;
          },
          "levels"_a, "Takes all transitions that the levels allow; returns the name of the new state.")
      .def_prop_ro(
          "state",
          [](const SessionMachine& self) {
            return loop::session_states()[static_cast<std::size_t>(self.state())].name;
          },
          "Name of the present state.");
}

void bind_pace(nb::module_& m) {
  using loop::Pace;
  nb::class_<Pace>(m, "Pace", "Speed along a planned motion relative to the plan, which changes by 1 in stop_time.")
      .def(nb::init<double>(), "stop_time"_a, "stop_time: time in which a motion at full pace comes to rest [s].")
      .def("step", &Pace::step, "wanted"_a, "dt"_a,
           "One period dt [s] towards the wanted pace; returns the progress along the motion [s].")
      .def("reset", &Pace::reset, "Rests at once.")
      .def("limit", &Pace::limit, "left"_a, "The largest pace from which the motion rests within `left` [s] along it.")
      .def_prop_ro("value", &Pace::value, "The present pace, 1: as planned [-].");
  m.attr("STOP_TIME") = loop::Execution::kStopTime;
}

void bind_realtime(nb::module_& m) {
  using loop::BareLoop;
  using loop::RealTimeOptions;
  nb::class_<RealTimeOptions>(m, "RealTimeOptions", "What the real-time thread may request from the operating system.")
      .def(nb::init<>())
      .def_rw("allow_priority", &RealTimeOptions::allow_priority,
              "True: the thread may request SCHED_FIFO and locked memory."_doc)
      .def_rw("allow_affinity", &RealTimeOptions::allow_affinity, "True: the thread may bind itself to one core."_doc)
      .def_rw("priority", &RealTimeOptions::priority, "Priority of SCHED_FIFO, 1..99."_doc)
      .def_rw("spin_us", &RealTimeOptions::spin_us,
              "Time before a deadline that the thread spends in a busy wait [us]."_doc);

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
  bind_session(m);
  bind_pace(m);
  bind_realtime(m);
}

}  // namespace palpate::bindings
