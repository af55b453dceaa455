#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <tuple>

#include "bind.hpp"
#include "echo.hpp"
#include "rcl/context.hpp"
#include "topic_meter.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::ros {
namespace {

using Times = nb::ndarray<nb::numpy, double, nb::ndim<1>>;

Times times(const std::vector<double>& values) {
  auto* data = new double[values.size()];
  std::copy(values.begin(), values.end(), data);
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<double*>(p); });
  return Times(data, {values.size()}, owner);
}

void listen(TopicMeter& meter, const nb::list& topics) {
  std::vector<TopicMeter::Topic> wanted;
  for (const nb::handle one : topics) {
    const auto [name, type, stamped, latched] = nb::cast<std::tuple<std::string, nb::capsule, bool, bool>>(one);
    wanted.push_back({name, static_cast<const rosidl_message_type_support_t*>(type.data()), stamped, latched});
  }
  const nb::gil_scoped_release free;
  meter.listen(wanted);
}

nb::list take(TopicMeter& meter) {
  std::vector<TopicMeter::Heard> heard;
  {
    const nb::gil_scoped_release free;
    heard = meter.take();
  }
  nb::list out;
  for (const auto& one : heard) out.append(nb::make_tuple(times(one.arrivals), times(one.ages)));
  return out;
}

void bind_topic_meter(nb::module_& m) {
  nb::class_<TopicMeter>(m, "TopicMeter", "Counts the messages of any topics and measures their ages.")
      .def(nb::init<std::shared_ptr<Context>, const std::string&>(), "context"_a, "name"_a)
      .def("listen", &listen, "topics"_a,
           "Listen to these topics from now on: tuples of name, type support (capsule of rclpy), whether the message "
           "begins with a header, whether it is latched.")
      .def("take", &take,
           "Ends listening. For each topic: monotonic times of the messages (n,) [s], and the ages of those with a "
           "stamp "
           "(m,) [s].");
}

}  // namespace

void bind_rcl(nb::module_& m) {
  const nb::exception<Error> error(m, "RosError", PyExc_RuntimeError);

  nb::class_<Context>(m, "Context", "A connection of this process to ROS 2.")
      .def(
          "__init__",
          [](Context* self, bool network, int domain, int priority, std::vector<std::string> arguments) {
            new (self) Context(
                {.network = network, .domain = domain, .priority = priority, .arguments = std::move(arguments)});
          },
          nb::kw_only(), "network"_a = ContextOptions{}.network, "domain"_a = ContextOptions{}.domain,
          "priority"_a = ContextOptions{}.priority, "arguments"_a = std::vector<std::string>{},
          "Start ROS 2: within this machine alone unless `network`; `domain` -1 is the one of the environment; "
          "`priority` of SCHED_FIFO for the middleware's receiving threads, where allowed, 0 for none.")
      .def_prop_ro("network", &Context::network, "Whether it talks to other machines.")
      .def_prop_ro("domain", &Context::domain, "ROS_DOMAIN_ID [-].");

  bind_topic_meter(m);
  nb::class_<Echo>(m, "Echo", "Sends every WrenchStamped of one topic back on another.")
      .def(nb::init<std::shared_ptr<Context>, const std::string&, const std::string&>(), "context"_a, "source"_a,
           "target"_a, nb::call_guard<nb::gil_scoped_release>(), "Start the node; it runs until it is deleted.")
      .def_prop_ro("count", &Echo::count, "Messages sent back [-].");
}

}  // namespace palpate::ros
