// How people steer a loop and read its ticks, bound alike for every class that has a loop::Front. Also compiled into
// the ROS 2 extension.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>

#include <memory>
#include <utility>
#include <vector>

#include "palpate/loop/front.hpp"
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
       "Rows since the last drain (real time).")
      .def_prop_ro(
          "dropped", [](const Loop& self) { return self.front().dropped(); },
          "Rows lost because they were not drained in time.")
      .def(
          "latest", [](Loop& self) { return to_row(self.front().latest()); }, "The newest row.")
      .def_prop_rw(
          "controls", [](const Loop& self) { return self.front().controls(); },
          [](Loop& self, const Controls& controls) { self.front().set_controls(controls); },
          "A copy; assign it whole. Taken at the next tick.")
      .def(
          "set_fixtures",
          [](Loop& self, std::shared_ptr<const guidance::Fixtures> f) { self.front().set_fixtures(std::move(f)); },
          "fixtures"_a, "Swaps the fixtures of guidance whole at the next tick; no force that the hand feels jumps.")
      .def(
          "set_snapshot",
          [](Loop& self, std::shared_ptr<const scene::Snapshot> s) { self.front().set_scene(std::move(s)); },
          "snapshot"_a, "Swaps the scene whole at the next tick.");
}

}  // namespace palpate::bindings
