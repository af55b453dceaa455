#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "bindings.hpp"
#include "convert.hpp"
#include "front.hpp"
#include "palpate/loop/device_cycle.hpp"
#include "palpate/loop/driver_thread.hpp"
#include "palpate/loop/shared_object.hpp"
#include "timing.hpp"
#include "types.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using loop::DeviceCycle;
using loop::DeviceFault;
using loop::Driver;
using loop::DriverThread;
using loop::SharedObject;
using OnePose = Input<double, 4, 4>;
using OneTwist = Input<double, 6>;
using Wrenches = nb::ndarray<double, nb::shape<-1, 6>, nb::c_contig, nb::device::cpu>;
using OneWrench = nb::ndarray<double, nb::shape<6>, nb::c_contig, nb::device::cpu>;

void write(const Wrench& F, OneWrench& to) {
  Eigen::Map<Vec3>(to.data()) = F.f;
  Eigen::Map<Vec3>(to.data() + 3) = F.t;
}

DeviceFault step_device(DeviceCycle& self, double t, const OnePose& X, const std::optional<OneTwist>& V, double gripper,
                        bool clutch, OneWrench F) {
  loop::DeviceState state{.t = t, .gripper = gripper, .clutch = clutch};
  std::copy_n(X.data(), 16, state.X_LH.begin());
  if (V) std::copy_n(V->data(), 6, state.V_LH.emplace().begin());
  write(self.step(state), F);
  return self.fault();
}

using Paths = Input<double, -1, 7>;
using Rows = nb::ndarray<double, nb::shape<-1, static_cast<nb::ssize_t>(kColumns)>, nb::c_contig, nb::device::cpu>;
using Values = nb::ndarray<double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Cycles = std::vector<std::shared_ptr<DeviceCycle>>;

void glide_together(const Cycles& cycles, const std::vector<std::shared_ptr<loop::Bodies>>& bodies, const Times& t,
                    double dt, int steps, const Paths& from, const Paths& to, Rows rows, Values felt) {
  const std::size_t n = cycles.size(), worlds = t.shape(0);
  for (const std::size_t size : {from.shape(0), to.shape(0), rows.shape(0), felt.shape(0)}) {
    if (size != n) throw std::invalid_argument("glide_together: an array has not one row for each cycle");
  }
  if (worlds == 0 || n == 0 || n % worlds != 0 || !(bodies.empty() || bodies.size() == worlds))
    throw std::invalid_argument("glide_together: the cycles are not equally many for each time and world");
  const nb::gil_scoped_release release;
  const std::size_t each = n / worlds;
  std::vector<loop::Glide> paths(each);
  for (std::size_t w = 0; w < worlds; ++w) {
    for (std::size_t k = 0; k < each; ++k) {
      const auto end = [row = w * each + k](const Paths& path) { return loop::Glide::End(path.data() + 7 * row); };
      paths[k] = {.t = t.data()[w], .dt = dt, .steps = steps, .from = end(from), .to = end(to)};
    }
    loop::glide(std::span(cycles).subspan(w * each, each), paths, bodies.empty() ? nullptr : bodies[w].get(),
                std::span(felt.data() + w * each, each));
  }
  for (std::size_t i = 0; i < n; ++i) {
    const loop::Tick newest = cycles[i]->front().latest();
    std::memcpy(rows.data() + kColumns * i, &newest, sizeof(newest));
  }
}

void bind_driver(nb::module_& m) {
  nb::class_<Driver>(m, "Driver", "An opened device, which a thread of the core reads and commands.")
      .def_prop_ro(
          "name", [](const Driver& d) { return std::string(d.info().name); }, "Name of the device.")
      .def_prop_ro(
          "rate", [](const Driver& d) { return d.info().rate; }, "Rate of read and write [Hz].")
      .def_prop_ro(
          "force_max", [](const Driver& d) { return d.info().force_max; }, "Largest force [N].")
      .def_prop_ro(
          "moment_max", [](const Driver& d) { return d.info().moment_max; }, "Largest moment [N m].")
      .def_prop_ro(
          "workspace",
          [](const Driver& d) -> Tuple<double, double, double> {
            const double* size = d.info().workspace;
            return nb::make_tuple(size[0], size[1], size[2]);
          },
          "Lengths of the workspace (3) [m].")
      .def_prop_ro(
          "resolution", [](const Driver& d) { return d.info().resolution; },
          "Step of the measured position; 0: unknown [m].")
      .def_prop_ro(
          "mass", [](const Driver& d) { return d.info().mass; }, "Moving mass at the handle; 0: unknown [kg].")
      .def_prop_ro(
          "delay", [](const Driver& d) { return d.info().delay; },
          "Time from a measurement to the force on the hand; 0: unknown [s].")
      .def_prop_ro(
          "friction", [](const Driver& d) { return d.info().friction; },
          "Dry friction that certainly resists the handle [N].")
      .def_prop_ro(
          "damping", [](const Driver& d) { return d.info().damping; },
          "Viscous friction that certainly resists the handle [N s/m].")
      .def_prop_ro("notices", &Driver::notices, "What has happened to the device since it was opened: cause; mend.");
  nb::class_<SharedObject, Driver>(m, "SharedObject",
                                   "A driver in C: a shared object with the functions of palpate/loop/driver.h.")
      .def(nb::init<const std::string&, const std::string&>(), "file"_a, "argument"_a = "",
           "Loads the shared object and opens the device.");
  nb::class_<DriverThread>(m, "DriverThread", "Reads a driver, steps the cycle and writes, in real time.")
      .def(nb::init<std::shared_ptr<Driver>, std::shared_ptr<DeviceCycle>>(), "driver"_a, "cycle"_a)
      .def("start", &DriverThread::start, nb::call_guard<nb::gil_scoped_release>(), "Starts the real-time thread.")
      .def("stop", &DriverThread::stop, nb::call_guard<nb::gil_scoped_release>(),
           "Ramps the force to zero and ends the threads, within a second even if the driver hangs.")
      .def("fault", &DriverThread::fault, "Why the loop ended by itself or hangs; empty if neither.")
      .def_prop_ro("buttons", &DriverThread::buttons, "Buttons of the newest measurement, as `Reading.buttons`.")
      .def_prop_ro("stalls", &DriverThread::stalls, "Number of calls for which the watchdog wrote zero force.")
      .def(
          "timing", [](const DriverThread& self) { return punctuality(self.thread()); },
          "Punctuality so far: lateness_us, slack_us, ticks, missed_ticks, scheduler.");
}

}  // namespace

void bind_device(nb::module_& m) {
  nb::enum_<DeviceFault>(m, "DeviceFault", "Reason for which a state of the device was not used.")
      .value("none", DeviceFault::none)
      .value("not_finite", DeviceFault::not_finite)
      .value("not_rigid", DeviceFault::not_rigid)
      .value("left_handed", DeviceFault::left_handed)
      .value("time_not_increasing", DeviceFault::time_not_increasing)
      .value("gap", DeviceFault::gap)
      .value("too_often", DeviceFault::too_often)
      .value("driver_failed", DeviceFault::driver_failed);

  auto cycle = nb::class_<DeviceCycle>(
      m, "DeviceCycle",
      "The haptic cycle for a device in anybody's loop: each step takes one state, returns a wrench.");
  cycle
      .def(nb::init<const loop::CrtkOptions&, arm::Arm, std::shared_ptr<const scene::Snapshot>>(), "options"_a,
           "follower"_a, "snapshot"_a)
      .def("start", &DeviceCycle::start, nb::call_guard<nb::gil_scoped_release>(), "Allocates the queue of rows.")
      .def("stop", &DeviceCycle::stop, nb::call_guard<nb::gil_scoped_release>(), "Ends the collision queries.")
      .def("step", &step_device, "t"_a, "X_LH"_a, "V_LH"_a.none(), "gripper"_a, "clutch"_a, "F"_a,
           "One step at time t [s]: pose X_LH (4, 4) [m], velocity V_LH (6,) [m/s, rad/s] or None, gripper [rad]. "
           "Writes the wrench on the hand, in L, to F (6,) [N, N m], and returns why the state was not used.")
      .def(
          "report_failure", [](DeviceCycle& self, OneWrench F) { write(self.report_failure(), F); }, "F"_a,
          "Sets the wrench to zero and records that the device cannot be read; writes zeros to F (6,).")
      .def(
          "replay",
          [](DeviceCycle& self, const Times& t, const Poses& X, const Wrenches& F) {
            const std::size_t n = std::min({t.shape(0), X.shape(0), F.shape(0)});
            for (std::size_t i = 0; i < n; ++i) {
              loop::DeviceState state{.t = t.data()[i]};
              std::copy_n(X.data() + 16 * i, 16, state.X_LH.begin());
              const Wrench& felt = self.step(state);
              Eigen::Map<Vec3>(F.data() + 6 * i) = felt.f;
              Eigen::Map<Vec3>(F.data() + 6 * i + 3) = felt.t;
            }
          },
          "t"_a, "X_LH"_a, "F"_a, nb::call_guard<nb::gil_scoped_release>(),
          "Steps at all times t (n,) [s] with poses X_LH (n, 4, 4) [m]; writes the wrenches to F (n, 6) [N, N m].")
      .def("attach", &DeviceCycle::attach, "remote"_a.none(),
           "Lets the hand feel what this end of a link renders; None: the objects of the cycle. Not while it runs.")
      .def("allow_force", &DeviceCycle::allow_force, "allowed"_a, "False: the wrench ramps to zero.")
      .def_prop_ro("gripper_torque", &DeviceCycle::gripper_torque,
                   "Torque on the operator's fingers after the last step, positive when it opens them [N m].")
      .def_prop_ro("status", &DeviceCycle::status, "Bits of Status of the last step.")
      .def_prop_ro("period", &DeviceCycle::period, "Mean time between steps; 0: unknown [s].")
      .def(
          "timing", [](const DeviceCycle& self) { return percentiles(self.cycle_time()); },
          "Compute times of the steps: p50, p99, p999 and max [us].");
  bind_front(cycle);
  bind_together(cycle);
  m.def("glide_together", &glide_together, "cycles"_a, "bodies"_a, "t"_a, "dt"_a, "steps"_a, "from_"_a, "to"_a,
        "rows"_a, "felt"_a,
        "Steps the cycles of several worlds from their times t (worlds,) [s] by `steps` steps of dt [s], each along a "
        "straight path of the handle: displacement [m], rotation vector [rad] and pinch angle [rad], from_ (n, 7) to "
        "`to` (n, 7). Each world has equally many of the n cycles, and its entry of `bodies` unless that is empty. "
        "Writes the newest row of each to rows (n, TICK_BYTES/8), and the largest force on its hand to felt (n,) [N].");

  bind_driver(m);
  m.def(
      "schedule", [](bool priority) { return loop::schedule({.allow_priority = priority, .allow_affinity = false}); },
      "priority"_a = true,
      "Requests SCHED_FIFO, locked memory and short timer slack for the calling thread, not for those that it begins, "
      "or "
      "normal scheduling again (False). Returns what was granted.");
}

}  // namespace palpate::bindings
