// Controls and tick rows of a running loop, bound in the same way for every class that has a loop::Front. The ROS 2
// extension compiles this file as well.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <utility>
#include <vector>

#include "palpate/loop/bodies.hpp"
#include "palpate/loop/front.hpp"
#include "palpate/loop/instruments.hpp"
#include "rows.hpp"

namespace palpate::bindings {

/// Loop: a class whose front() is a loop::Front.
template <class Loop>
void bind_front(nanobind::class_<Loop>& c) {
  using nanobind::literals::operator""_a;
  c.def(
       "drain",
       [](Loop& self) {
         std::vector<loop::Tick> ticks(self.front().waiting());
         {
           const nanobind::gil_scoped_release release;
           ticks.resize(self.front().drain(ticks.size(), ticks.data()));
         }
         return to_rows(std::move(ticks));
       },
       "Rows since the last drain, in real time (n, TICK_BYTES/8).")
      .def_prop_ro(
          "dropped", [](const Loop& self) { return self.front().dropped(); },
          "Number of rows lost because they were not drained in time.")
      .def(
          "latest", [](Loop& self) { return to_row(self.front().latest()); }, "The newest row (TICK_BYTES/8,).")
      .def(
          "soft_vertices",
          [](Loop& self, std::size_t object) {
            std::vector<double> vertices = self.front().soft_vertices(object);
            const std::size_t n = vertices.size() / 3;
            return array(std::move(vertices), {n, 3});
          },
          "object"_a,
          "Deformed surface of a soft object: vertices (n, 3) in the object's frame O [m], in the order of "
          "TissueSurface.vertices. The loop publishes them every 16 ms. Raises ValueError if the object does not exist "
          "or is not soft.")
      .def_prop_rw(
          "controls", [](const Loop& self) { return self.front().controls(); },
          [](Loop& self, const Controls& controls) { self.front().set_controls(controls); },
          "The operator's controls. This is a copy: assign a whole one, which applies from the next tick on.")
      .def(
          "set_fixtures",
          [](Loop& self, std::shared_ptr<const guidance::FixtureList> f) { self.front().set_fixtures(std::move(f)); },
          "fixtures"_a, "Replaces the fixtures of guidance at the next tick, without a step in the force.")
      .def(
          "set_snapshot",
          [](Loop& self, std::shared_ptr<const scene::Snapshot> s) { self.front().set_scene(std::move(s)); },
          "snapshot"_a,
          "Replaces the scene at the next tick. Contact goes on if the number, names and surfaces of the objects stay "
          "the same, and starts anew otherwise.")
      .def(
          "set_live", [](Loop& self, const LiveTargets& targets) { self.front().set_live(targets); }, "targets"_a,
          "Sets the poses that the live objects of the newest snapshot shall reach, from the next tick on. Raises "
          "ValueError if their number differs.");
}

/// Loop: a class whose tool meets the instruments of other loops, and rigid bodies.
template <class Loop>
void bind_together(nanobind::class_<Loop>& c) {
  using nanobind::literals::operator""_a;
  c.def(
       "join",
       [](Loop& self, std::shared_ptr<loop::Board> board, int index, std::vector<loop::ToolCapsule> capsules,
          double stiffness,
          double damping) { self.join(std::move(board), index, std::move(capsules), {stiffness, damping}); },
       "board"_a, "index"_a, "capsules"_a, "stiffness"_a, "damping"_a,
       "Puts the instrument among those of other loops, which push it apart with a stiffness [N/m] and a damping "
       "[N s/m]. index: its number among them. Not while the loop runs.")
      .def("join_bodies", &Loop::join_bodies, "bodies"_a, "tool"_a,
           "Puts the tool among rigid bodies, as the tool of this number. A simulation that has the only tool advances "
           "them in lockstep. Not while the loop runs.");
}

}  // namespace palpate::bindings
