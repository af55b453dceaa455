#include <nanobind/eigen/dense.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <memory>
#include <vector>

#include "bench/puppet.hpp"
#include "bind.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::ros {
namespace {

using Array = nb::ndarray<nb::numpy, double, nb::ndim<2>>;

template <class T>
Array to_array(std::vector<T>&& rows) {
  auto owner = std::make_unique<std::vector<T>>(std::move(rows));
  auto* data = reinterpret_cast<double*>(owner->data());
  const std::size_t n = owner->size();
  nb::capsule capsule(owner.release(), [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return Array(data, {n, sizeof(T) / sizeof(double)}, capsule);
}

}  // namespace

void bind_bench(nb::module_& m) {
  nb::class_<PuppetOptions>(m, "PuppetOptions", "Of a leader that moves as told.")
      .def(nb::init<>())
      .def_rw("leader", &PuppetOptions::leader)
      .def_rw("teleop", &PuppetOptions::teleop)
      .def_rw("wrench", &PuppetOptions::wrench, "topic that it is pushed by")
      .def_rw("rate", &PuppetOptions::rate, "of its states [Hz]")
      .def_rw("reliable", &PuppetOptions::reliable)
      .def_rw("echo", &PuppetOptions::echo, "measure a bare echo beside it")
      .def_rw("seed", &PuppetOptions::seed);

  nb::class_<Spoil>(m, "Spoil", "What happens to a puppet's messages on the way.")
      .def(nb::init<>())
      .def_rw("drop", &Spoil::drop, "share that is lost [-]")
      .def_rw("twice", &Spoil::twice, "share that comes twice [-]")
      .def_rw("swap", &Spoil::swap, "share that comes after the next [-]")
      .def_rw("delay", &Spoil::delay, "[s]")
      .def_rw("clock", &Spoil::clock, "added to stamps [s]")
      .def_rw("not_finite", &Spoil::not_finite)
      .def_rw("no_rotation", &Spoil::no_rotation)
      .def_rw("zero_stamp", &Spoil::zero_stamp)
      .def_rw("wrong_length", &Spoil::wrong_length)
      .def_rw("silent", &Spoil::silent);

  const auto free = nb::call_guard<nb::gil_scoped_release>();
  nb::class_<Puppet>(m, "Puppet", "A CRTK leader that is none: moves as told, notes every wrench.")
      .def(nb::init<std::shared_ptr<Context>, const PuppetOptions&>(), "context"_a, "options"_a)
      .def("start", &Puppet::start, free)
      .def("stop", &Puppet::stop, free)
      .def("move_to", &Puppet::move_to, "p"_a, "seconds"_a)
      .def("swing", &Puppet::swing, "amplitude"_a, "frequency"_a)
      .def("turn_to", &Puppet::turn_to, "quat"_a, "x y z w; at once")
      .def("spoil", &Puppet::spoil, "spoil"_a)
      .def("set_state", &Puppet::set_state, "state"_a, "homed"_a = true)
      .def("follow", &Puppet::follow, "on"_a)
      .def_prop_ro(
          "sent", [](const Puppet& self) { return to_array(self.sent()); }, nb::rv_policy::automatic,
          "(n, 1) when each state was published [s]")
      .def_prop_ro(
          "felt", [](const Puppet& self) { return to_array(self.felt()); }, nb::rv_policy::automatic,
          "(n, 12): monotonic time, time since 1970, stamp [s], force [N], torque [N m], who wrote it (0, 1, ...), "
          "whether an arm would read it in absolute axes, how many that writer had sent")
      .def_prop_ro(
          "echoes", [](const Puppet& self) { return to_array(self.echoes()); }, nb::rv_policy::automatic,
          "(n, 1) there and back [s]")
      .def_prop_ro(
          "flags", [](const Puppet& self) { return to_array(self.flags()); }, nb::rv_policy::automatic,
          "(n, 2) body/set_cf_orientation_absolute: when [s], what")
      .def_prop_ro("absolute", &Puppet::absolute, "body/set_cf_orientation_absolute, as it was told.")
      .def_prop_ro("carried", &Puppet::carried, "use_gravity_compensation, as it was told.")
      .def_prop_ro("pings", &Puppet::pings)
      .def_prop_ro("listeners", &Puppet::listeners, "Of its states.")
      .def_prop_ro("writers", &Puppet::writers, "Of its wrenches.")
      .def_prop_ro("late_p99_us", [](const Puppet& self) { return self.punctuality().lateness.percentile_us(0.99); })
      .def_prop_ro("missed", [](const Puppet& self) { return self.punctuality().missed.load(); })
      .def_prop_ro("scheduler", &Puppet::scheduler);
}

}  // namespace palpate::ros
