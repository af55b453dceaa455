#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <utility>
#include <vector>

#include "bind.hpp"
#include "bindings/front.hpp"
#include "bindings/timing.hpp"
#include "haptics/guardian.hpp"
#include "haptics/haptic_node.hpp"
#include "haptics/stream_meter.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::ros {
namespace {

using bindings::percentiles;

nb::dict timing(const HapticNode& self) {
  nb::dict d;
  d["cycle_us"] = percentiles(self.cycle_time());
  d["answer_us"] = percentiles(self.answer_time());
  d["ticks"] = self.cycle_time().count();
  d["published"] = self.published();
  d["guardian_took_over"] = self.guarded();
  d["scheduler"] = self.scheduler();
  const Stream leader = self.leader();
  d["leader_rate"] = leader.rate;
  d["leader_age_us"] = 1e6 * leader.age;
  d["leader_clock_s"] = leader.clock_offset;
  d["leader_messages"] = leader.taken;
  d["leader_left_out"] = leader.left_out;
  return d;
}

void bind_node(nb::module_& m) {
  nb::class_<HapticNames>(m, "HapticNames", "CRTK names of the devices of a haptic node.")
      .def(nb::init<>())
      .def_rw("leader", &HapticNames::leader)
      .def_rw("follower", &HapticNames::follower, "Empty: a virtual follower.")
      .def_rw("teleop", &HapticNames::teleop, "Name of an external teleoperation; empty: Palpate's own.")
      .def_rw("space", &HapticNames::space)
      .def_rw("console", &HapticNames::console)
      .def_prop_ro("wrench", &HapticNames::wrench, "Topic of the wrenches on the leader.");

  nb::class_<HapticNodeOptions>(m, "HapticNodeOptions", "Options of a haptic node.")
      .def(
          "__init__",
          [](HapticNodeOptions* self, const HapticNames& names, const loop::CrtkOptions& cycle, std::string writer,
             std::string guardian, int beat_fd) {
            new (self) HapticNodeOptions{names, cycle, {}, std::move(writer), std::move(guardian), beat_fd};
          },
          "names"_a, "cycle"_a, "writer"_a, "guardian"_a, "beat_fd"_a)
      .def_rw("realtime", &HapticNodeOptions::realtime);

  nb::class_<HapticNode> node(
      m, "HapticNode", "Receives the state of a CRTK leader, steps the cycle and sends the wrench, in a C++ thread.");
  bindings::bind_front(node);
  bindings::bind_together(node);
  node.def(nb::init<std::shared_ptr<Context>, const HapticNodeOptions&, std::optional<arm::Arm>,
                    std::shared_ptr<const scene::Snapshot>>(),
           "context"_a, "options"_a, "follower"_a, "snapshot"_a)
      .def("start", &HapticNode::start, nb::call_guard<nb::gil_scoped_release>(),
           "Starts the cycle: from now on the node sends wrenches.")
      .def("stop", &HapticNode::stop, nb::call_guard<nb::gil_scoped_release>(),
           "Ends the cycle; the last wrench sent is zero.")
      .def_prop_ro("running", &HapticNode::running)
      .def("take_events", &HapticNode::take_events, "Messages for the user since the last call, oldest first.")
      .def("timing", &timing, "Computation times, response times, counts and rates.");
}

}  // namespace

void bind_haptics(nb::module_& m) {
  bind_node(m);
  nb::class_<StreamMeter>(m, "StreamMeter", "Measures how regularly the poses of a topic arrive.")
      .def(nb::init<std::shared_ptr<Context>, const std::string&>(), "context"_a, "topic"_a,
           nb::call_guard<nb::gil_scoped_release>(), "Start to listen; it runs until it is deleted.")
      .def("rows", &StreamMeter::rows, "Arrival [s, monotonic] and age of the stamp [s] of each message so far.");
  m.def(
      "guard",
      [](const std::shared_ptr<Context>& context, std::string wrench_topic, std::string node_name, int node_pid,
         int beat_fd) {
        GuardianOptions options;
        options.wrench_topic = std::move(wrench_topic);
        options.node_name = std::move(node_name);
        options.node_pid = node_pid;
        options.beat_fd = beat_fd;
        return guard(context, options);
      },
      "context"_a, "wrench_topic"_a, "node_name"_a, "node_pid"_a, "beat_fd"_a, nb::call_guard<nb::gil_scoped_release>(),
      "Guards a haptic node until it ends. Returns True if the node ended properly, False if it died.");
}

}  // namespace palpate::ros
