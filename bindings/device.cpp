#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "bindings.hpp"
#include "convert.hpp"
#include "front.hpp"
#include "palpate/loop/device_cycle.hpp"
#include "timing.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using loop::DeviceCycle;
using loop::DeviceFault;
using Pose16 = nb::ndarray<const double, nb::shape<4, 4>, nb::c_contig, nb::device::cpu>;
using Twist6 = nb::ndarray<const double, nb::shape<6>, nb::c_contig, nb::device::cpu>;
using Wrench6 = nb::ndarray<double, nb::shape<6>, nb::c_contig, nb::device::cpu>;

void write(const Wrench& F, Wrench6& to) {
  Eigen::Map<Vec3>(to.data()) = F.f;
  Eigen::Map<Vec3>(to.data() + 3) = F.t;
}

DeviceFault step(DeviceCycle& self, double t, const Pose16& X, const std::optional<Twist6>& V, double gripper,
                 bool clutch, Wrench6 F) {
  loop::DeviceState state{.t = t, .gripper = gripper, .clutch = clutch};
  std::copy_n(X.data(), 16, state.X_LH.begin());
  if (V) std::copy_n(V->data(), 6, state.V_LH.emplace().begin());
  write(self.step(state), F);
  return self.fault();
}

}  // namespace

void bind_device(nb::module_& m) {
  nb::enum_<DeviceFault>(m, "DeviceFault", "Reason for which a state of the device was not used.")
      .value("none", DeviceFault::none)
      .value("not_finite", DeviceFault::not_finite)
      .value("not_rigid", DeviceFault::not_rigid)
      .value("left_handed", DeviceFault::left_handed)
      .value("time_not_up", DeviceFault::time_not_up)
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
      .def("step", &step, "t"_a, "X_LH"_a, "V_LH"_a.none(), "gripper"_a, "clutch"_a, "F"_a,
           "One step at time t [s]: pose X_LH (4, 4) [m], velocity V_LH (6,) [m/s, rad/s] or None, gripper [rad]. "
           "Writes the wrench on the hand, in L, to F (6,) [N, N m], and returns why the state was not used.")
      .def(
          "report_failure", [](DeviceCycle& self, Wrench6 F) { write(self.report_failure(), F); }, "F"_a,
          "Sets the wrench to zero and records that the device cannot be read; writes zeros to F (6,).")
      .def_prop_ro("status", &DeviceCycle::status, "Bits of Status of the last step.")
      .def_prop_ro("period", &DeviceCycle::period, "Mean time between steps; 0: unknown [s].")
      .def(
          "timing", [](const DeviceCycle& self) { return percentiles(self.cycle_time()); },
          "Compute times of the steps: p50, p99, p999 and max [us].");
  bind_front(cycle);

  m.def(
      "schedule", [](bool priority) { return loop::schedule({.allow_priority = priority, .allow_affinity = false}); },
      "priority"_a = true,
      "Requests SCHED_FIFO, locked memory and short timer slack for the calling thread. Returns what was granted.");
}

}  // namespace palpate::bindings
