#include <nanobind/eigen/dense.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <memory>
#include <vector>

#include "bench/mock_leader.hpp"
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

void bind_options(nb::module_& m) {
  nb::class_<MockLeaderOptions>(m, "MockLeaderOptions", "Of a leader that moves as message.")
      .def(nb::init<>())
      .def_rw("leader", &MockLeaderOptions::leader)
      .def_rw("teleop", &MockLeaderOptions::teleop)
      .def_rw("wrench", &MockLeaderOptions::wrench, "Topic of the wrenches that the leader receives.")
      .def_rw("rate", &MockLeaderOptions::rate, "Rate of the published states [Hz].")
      .def_rw("reliable", &MockLeaderOptions::reliable)
      .def_rw("echo", &MockLeaderOptions::echo, "True: also measure the round-trip time of a plain echo.")
      .def_rw("seed", &MockLeaderOptions::seed);

  nb::class_<MessageFaults>(m, "MessageFaults", "Faults injected into the messages of a mock leader.")
      .def(nb::init<>())
      .def_rw("drop", &MessageFaults::drop, "Fraction of lost messages [-].")
      .def_rw("twice", &MessageFaults::twice, "Fraction of repeated messages [-].")
      .def_rw("swap", &MessageFaults::swap, "Fraction of messages that arrive after the next one [-].")
      .def_rw("delay", &MessageFaults::delay, "Time from the stamp to the publication [s].")
      .def_rw("clock", &MessageFaults::clock, "Clock offset added to the stamps [s].")
      .def_rw("not_finite", &MessageFaults::not_finite)
      .def_rw("no_rotation", &MessageFaults::no_rotation)
      .def_rw("zero_stamp", &MessageFaults::zero_stamp)
      .def_rw("wrong_length", &MessageFaults::wrong_length)
      .def_rw("silent", &MessageFaults::silent);
}

}  // namespace

void bind_bench(nb::module_& m) {
  bind_options(m);
  const auto free = nb::call_guard<nb::gil_scoped_release>();
  nb::class_<MockLeader>(m, "MockLeader",
                         "A mock CRTK leader: it publishes commanded motions and logs every wrench that it receives.")
      .def(nb::init<std::shared_ptr<Context>, const MockLeaderOptions&>(), "context"_a, "options"_a)
      .def("start", &MockLeader::start, free)
      .def("stop", &MockLeader::stop, free)
      .def("move_to", &MockLeader::move_to, "p"_a, "seconds"_a)
      .def("swing", &MockLeader::swing, "amplitude"_a, "frequency"_a)
      .def("turn_to", &MockLeader::turn_to, "quat"_a, "Sets the orientation at once: quaternion x y z w.")
      .def("inject", &MockLeader::inject, "faults"_a)
      .def("set_state", &MockLeader::set_state, "state"_a, "homed"_a = true)
      .def("follow", &MockLeader::follow, "on"_a)
      .def_prop_ro(
          "sent", [](const MockLeader& self) { return to_array(self.sent()); }, nb::rv_policy::automatic,
          "Publication time of each state (n, 1) [s].")
      .def_prop_ro(
          "wrenches", [](const MockLeader& self) { return to_array(self.wrenches()); }, nb::rv_policy::automatic,
          "Received wrenches (n, 12): monotonic time, time since 1970, stamp [s], force [N], torque [N m], index of "
          "the "
          "publisher (0, 1, ...), 1 if a dVRK arm would read it in absolute axes, number of messages of that "
          "publisher.")
      .def_prop_ro(
          "echoes", [](const MockLeader& self) { return to_array(self.echoes()); }, nb::rv_policy::automatic,
          "Round-trip times of the echo (n, 1) [s].")
      .def_prop_ro(
          "frame_settings", [](const MockLeader& self) { return to_array(self.frame_settings()); },
          nb::rv_policy::automatic, "Received settings of body/set_cf_orientation_absolute (n, 2): time [s], value.")
      .def_prop_ro("absolute", &MockLeader::absolute, "body/set_cf_orientation_absolute, as it was message.")
      .def_prop_ro("gravity_compensation", &MockLeader::gravity_compensation,
                   "use_gravity_compensation, as it was message.")
      .def_prop_ro("pings", &MockLeader::pings)
      .def_prop_ro("listeners", &MockLeader::listeners, "Number of subscribers of the states.")
      .def_prop_ro("writers", &MockLeader::writers, "Number of publishers of wrenches.")
      .def_prop_ro("late_p99_us",
                   [](const MockLeader& self) { return self.punctuality().lateness.percentile_us(0.99); })
      .def_prop_ro("missed", [](const MockLeader& self) { return self.punctuality().missed.load(); })
      .def_prop_ro("scheduler", &MockLeader::scheduler);
}

}  // namespace palpate::ros
