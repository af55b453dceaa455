#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "convert.hpp"
#include "doc.hpp"
#include "network/bindings.hpp"
#include "palpate/network/emulated_end.hpp"
#include "palpate/network/follower.hpp"
#include "palpate/network/loop_end.hpp"
#include "timing.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using network::Ages;
using network::Datagram;
using network::EmulatedEnd;
using network::EmulatedOptions;
using network::Follower;
using network::FollowerOptions;
using network::FollowerState;
using network::LinkState;
using network::LoopEnd;
using network::LoopEndOptions;

nb::bytes bytes_of(const Datagram& d) {
  const network::Bytes bytes = network::encode(d);
  return nb::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

/// Gives the datagram of these bytes to an end; false unless they are valid and the end takes them.
template <class End>
bool take(End& end, const nb::bytes& bytes, double at) {
  Datagram d;
  const std::span<const std::uint8_t> view{reinterpret_cast<const std::uint8_t*>(bytes.c_str()), bytes.size()};
  return network::decode(view, d) && end.receive(d, at);
}

void bind_ages(nb::module_& m) {
  nb::class_<Ages>(m, "Ages", "Ages of the newest packet at an end.")
      .def_ro("age", &Ages::age, "Age of the newest packet [s]."_doc)
      .def_ro("p50", &Ages::p50, "Its median [s]."_doc)
      .def_ro("p99", &Ages::p99, "Its 99th percentile [s]."_doc)
      .def_ro("p999", &Ages::p999, "Its 99.9th percentile [s]."_doc)
      .def_ro("outages", &Ages::outages, "Outages so far."_doc);
}

void bind_loop_end(nb::module_& m) {
  nb::class_<LoopEndOptions, network::EndOptions>(m, "LoopEndOptions", "Options of the operator's end in a loop.")
      .def(nb::init<>())
      .def_rw("update", &LoopEndOptions::update, "Limits of updates of the local model."_doc);
  nb::class_<LinkState, Ages>(m, "LinkState", "What is known about a link after a tick.")
      .def_ro("newest", &LinkState::newest, "The newest datagram of the other end."_doc)
      .def_ro("offset", &LinkState::offset, "Clock of the other end minus the own one [s]."_doc)
      .def_ro("drift", &LinkState::drift, "Rate of the other clock minus 1 [-]."_doc)
      .def_ro("bound", &LinkState::bound, "Error of the offset by an unknown asymmetry of the delays [s]."_doc)
      .def_ro("held", &LinkState::held, "Time without link after the first [s]."_doc)
      .def_ro("received", &LinkState::received, "Packets that have arrived."_doc)
      .def_ro("known", &LinkState::known,
              "True once an answer has arrived, so that the clock of the other end is known."_doc)
      .def_ro("linked", &LinkState::linked, "True while the hand feels the remote side."_doc)
      .def_ro("outage", &LinkState::outage, "True while packets are missing."_doc)
      .def_ro("models", &LinkState::models, "Estimates as rendered, one for each object."_doc)
      .def_ro("tank", &LinkState::tank, "Least energy in the tanks of the objects [J]."_doc)
      .def_ro("paid", &LinkState::paid, "Energy that updates have added to the springs, less what they took [J]."_doc);
  nb::class_<LoopEnd, loop::RemoteEnd>(m, "LoopEnd", "The operator's end of a link, for Simulation.attach().")
      .def(nb::init<const LoopEndOptions&, scene::Snapshot>(), "options"_a, "scene"_a)
      .def("receive", &take<LoopEnd>, "bytes"_a, "at"_a,
           "The bytes of a datagram that arrived at the own time `at` [s]; False unless they are valid.")
      .def(
          "packet", [](LoopEnd& self) { return bytes_of(self.state().out); },
          "The bytes of the datagram that leaves next.")
      .def("state", &LoopEnd::state, "The state after the newest tick.");
}

void bind_follower(nb::module_& m) {
  nb::class_<FollowerOptions>(m, "FollowerOptions", "Options of a simulated follower.")
      .def(nb::init<>())
      .def_rw("site", &FollowerOptions::site, "Follower's end."_doc)
      .def_rw("instrument", &FollowerOptions::instrument, "Simulated instrument."_doc)
      .def_rw("rate", &FollowerOptions::rate, "Rate of its loop [Hz]."_doc)
      .def_rw("realtime", &FollowerOptions::realtime, "Options of its thread."_doc);
  nb::class_<FollowerState, Ages>(m, "FollowerState", "What is known about a follower after a tick.")
      .def_ro("x", &FollowerState::x, "True position of the tool (3,) [m]."_doc)
      .def_ro("F", &FollowerState::F, "True force of the tissue (3,) [N]."_doc)
      .def_ro("largest", &FollowerState::largest, "Largest force of the tissue so far [N]."_doc)
      .def_ro("account", &FollowerState::account, "Energy that the tool may still spend [J]."_doc);
  nb::class_<Follower>(m, "Follower", "The follower's end with a simulated instrument, in a real-time thread.")
      .def(
          "__init__",
          [](Follower* self, const FollowerOptions& options, const scene::Snapshot& scene, const scene::Snapshot& world,
             const Matrix4& X) { new (self) Follower(options, scene, world, to_pose(X, "X")); },
          "options"_a, "scene"_a, "world"_a, "X"_a,
          "scene: the objects as both ends have them; world: as they are; X (4, 4): pose of the tool in W [m].")
      .def("start", &Follower::start, nb::call_guard<nb::gil_scoped_release>(), "Starts the thread.")
      .def("stop", &Follower::stop, nb::call_guard<nb::gil_scoped_release>(), "Ends the thread.")
      .def("receive", &take<Follower>, "bytes"_a, "at"_a,
           "The bytes of a datagram that arrived at the own time `at` [s]; False unless they are valid.")
      .def("forget_operator", &Follower::forget_operator, "A new operator comes; what was learnt is kept.")
      .def(
          "packet", [](Follower& self) { return bytes_of(self.state().out); },
          "The bytes of the datagram that leaves next.")
      .def("state", &Follower::state, "The state after the newest tick.")
      .def(
          "timing", [](const Follower& self) { return punctuality(self.thread()); },
          "Punctuality so far: lateness_us, slack_us, ticks, missed_ticks, scheduler.");
}

void bind_emulated(nb::module_& m) {
  nb::class_<EmulatedOptions>(m, "EmulatedOptions", "Options of an emulated remote site.")
      .def(nb::init<>())
      .def_rw("operator_end", &EmulatedOptions::operator_end, "Operator's end."_doc)
      .def_rw("follower", &EmulatedOptions::follower, "Follower's end, with the rate of the loop."_doc)
      .def_rw("to_site", &EmulatedOptions::to_site, "Link from the operator to the site."_doc)
      .def_rw("to_operator", &EmulatedOptions::to_operator, "Link from the site to the operator."_doc)
      .def_rw("seed", &EmulatedOptions::seed, "Seed of the link."_doc);
  nb::class_<EmulatedEnd, loop::RemoteEnd>(m, "EmulatedEnd",
                                           "Both ends, the link and an instrument, for Simulation.attach(): a session "
                                           "across an emulated network in virtual time.")
      .def(nb::init<const EmulatedOptions&, const scene::Snapshot&, scene::Snapshot>(), "options"_a, "scene"_a,
           "world"_a, "scene: the objects as both ends have them; world: as they are.")
      .def("state", &EmulatedEnd::state, "The state of the operator's end after the newest tick.");
}

}  // namespace

void bind_loops(nb::module_& m) {
  bind_ages(m);
  bind_loop_end(m);
  bind_follower(m);
  bind_emulated(m);
}

}  // namespace palpate::bindings
