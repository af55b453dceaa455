#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <utility>
#include <vector>

#include "bind.hpp"
#include "haptics/guardian.hpp"
#include "haptics/haptic_node.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::ros {
namespace {

using loop::Tick;
using Rows = nb::ndarray<nb::numpy, double, nb::ndim<2>>;

Rows to_rows(std::vector<Tick>&& ticks) {
  auto owner = std::make_unique<std::vector<Tick>>(std::move(ticks));
  auto* data = reinterpret_cast<double*>(owner->data());
  const std::size_t n = owner->size();
  nb::capsule capsule(owner.release(), [](void* p) noexcept { delete static_cast<std::vector<Tick>*>(p); });
  return Rows(data, {n, sizeof(Tick) / sizeof(double)}, capsule);
}

nb::object to_row(const Tick& tick) { return nb::cast(to_rows({tick}))[nb::int_(0)]; }

Rows drain(HapticNode& self) {
  std::vector<Tick> ticks(self.waiting());
  {
    nb::gil_scoped_release release;
    ticks.resize(self.drain(ticks.size(), ticks.data()));
  }
  return to_rows(std::move(ticks));
}

nb::dict percentiles(const loop::Histogram& h) {
  nb::dict d;
  d["p50"] = h.percentile_us(0.5);
  d["p99"] = h.percentile_us(0.99);
  d["p999"] = h.percentile_us(0.999);
  d["max"] = h.max_us();
  return d;
}

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
  d["leader_messages"] = leader.taken;
  d["leader_left_out"] = leader.left_out;
  return d;
}

void bind_node(nb::module_& m) {
  nb::class_<HapticNames>(m, "HapticNames", "Which devices a haptic node works with.")
      .def(nb::init<>())
      .def_rw("leader", &HapticNames::leader)
      .def_rw("follower", &HapticNames::follower, "empty: a virtual one")
      .def_rw("teleop", &HapticNames::teleop, "of somebody else's teleoperation; empty: ours")
      .def_rw("console", &HapticNames::console)
      .def_prop_ro("wrench", &HapticNames::wrench, "Topic that wrenches go to.");

  nb::class_<HapticNodeOptions>(m, "HapticNodeOptions", "All that a haptic node is told.")
      .def(
          "__init__",
          [](HapticNodeOptions* self, const HapticNames& names, const loop::CrtkOptions& cycle, std::string writer,
             std::string guardian, int beat_fd) {
            new (self) HapticNodeOptions{names, cycle, {}, std::move(writer), std::move(guardian), beat_fd};
          },
          "names"_a, "cycle"_a, "writer"_a, "guardian"_a, "beat_fd"_a)
      .def_rw("realtime", &HapticNodeOptions::realtime);

  nb::class_<HapticNode>(m, "HapticNode", "A CRTK leader's state in, the cycle, the wrench out, in a thread of C++.")
      .def(nb::init<std::shared_ptr<Context>, const HapticNodeOptions&, std::optional<arm::Arm>,
                    std::shared_ptr<const scene::Snapshot>>(),
           "context"_a, "options"_a, "follower"_a, "snapshot"_a)
      .def("start", &HapticNode::start, nb::call_guard<nb::gil_scoped_release>(), "From here on it pushes.")
      .def("stop", &HapticNode::stop, nb::call_guard<nb::gil_scoped_release>(), "The last wrench that is sent is zero.")
      .def_prop_ro("running", &HapticNode::running)
      .def("drain", &drain, "Rows since the last drain.")
      .def_prop_ro("dropped", &HapticNode::dropped, "Rows lost because nobody drained.")
      .def(
          "latest", [](HapticNode& self) { return to_row(self.latest()); }, "The newest row.")
      .def_prop_rw("controls", &HapticNode::controls, &HapticNode::set_controls, "A copy; assign it whole.")
      .def("set_snapshot", &HapticNode::set_scene, "snapshot"_a, "Swaps the scene whole at the next step.")
      .def("set_fixtures", &HapticNode::set_fixtures, "fixtures"_a,
           "Swaps the fixtures of guidance whole at the next step.")
      .def("news", &HapticNode::news, "What has happened since the last call, in words.")
      .def("timing", &timing, "Times of computation and of answers, counts, rates.");
}

}  // namespace

void bind_haptics(nb::module_& m) {
  bind_node(m);
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
      "Guards a haptic node until it ends; True after a good end, False after a death.");
}

}  // namespace palpate::ros
