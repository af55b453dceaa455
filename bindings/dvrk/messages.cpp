// The tables of commands and topics, and the control law of servo_ci.
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <tuple>
#include <vector>

#include "convert.hpp"
#include "dvrk/bindings.hpp"
#include "dvrk/impedance.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

std::vector<std::tuple<int, unsigned, std::string, int>> verbs() {
  std::vector<std::tuple<int, unsigned, std::string, int>> rows;
  for (const dvrk::VerbEntry& e : dvrk::verbs()) {
    rows.emplace_back(static_cast<int>(e.kind), e.arms, std::string(e.name), static_cast<int>(e.payload));
  }
  return rows;
}

std::vector<std::tuple<int, unsigned, std::string, int, bool>> topics() {
  std::vector<std::tuple<int, unsigned, std::string, int, bool>> rows;
  for (const dvrk::TopicEntry& e : dvrk::topics()) {
    rows.emplace_back(static_cast<int>(e.kind), e.arms, std::string(e.name), static_cast<int>(e.payload), e.latched);
  }
  return rows;
}

}  // namespace

void bind_messages(nb::module_& m) {
  m.def("verbs", &verbs, "All commands: (kind of component, kinds of arms as bits, name, payload).");
  m.def("topics", &topics, "All events: (kind of component, kinds of arms as bits, name, payload, latched).");
  m.def(
      "impedance_wrench",
      [](const Fields& gains, const Matrix4& X, const Vec6& V) {
        return to_vector(dvrk::impedance_wrench(impedance(gains), to_pose(X, "X"), {V.head<3>(), V.tail<3>()}));
      },
      "gains"_a, "X"_a, "V"_a, "Wrench (6,) that servo_ci applies at pose X moving with twist V, in the base frame.");
}

}  // namespace palpate::bindings
