#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bind.hpp"
#include "echo.hpp"
#include "rcl/context.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::ros {

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

  nb::class_<Echo>(m, "Echo", "Sends every WrenchStamped of one topic back on another.")
      .def(nb::init<std::shared_ptr<Context>, const std::string&, const std::string&>(), "context"_a, "source"_a,
           "target"_a, nb::call_guard<nb::gil_scoped_release>(), "Start the node; it runs until it is deleted.")
      .def_prop_ro("count", &Echo::count, "Messages sent back [-].");
}

}  // namespace palpate::ros
