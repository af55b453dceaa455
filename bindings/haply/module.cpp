// The extension `_haply`: the driver of Haply devices, and the WebSocket on which it talks.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <tuple>

#include "palpate/haply/device.hpp"
#include "palpate/loop/realtime.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using haply::Device;
using haply::WebSocket;
using OneWrench = nb::ndarray<const double, nb::shape<6>, nb::c_contig, nb::device::cpu>;
using OnePose = nb::ndarray<double, nb::shape<4, 4>, nb::c_contig, nb::device::cpu>;
using Times = nb::ndarray<double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;

std::int64_t nanoseconds(double seconds) { return static_cast<std::int64_t>(1e9 * seconds); }

std::string receive(WebSocket& self, double seconds) {
  const WebSocket::Got got = [&] {
    const nb::gil_scoped_release released;
    return self.receive(nanoseconds(seconds));
  }();
  switch (got) {
    case WebSocket::Got::message:
      return std::string(self.message());
    case WebSocket::Got::nothing:
      throw std::runtime_error("no message within " + std::to_string(seconds) + " s");
    case WebSocket::Got::closed:
      throw std::runtime_error("the service closed the connection");
    default:
      throw std::runtime_error("what the service sent is no WebSocket message");
  }
}

void send(WebSocket& self, const std::string& text) {
  if (!self.send(text)) throw std::runtime_error("the connection to the service is broken");
}

/// Fills in the times of round trips that `go` makes [s]; false ends them early.
template <class Go>
std::size_t time_trips(Times& out, const Go& go) {
  for (std::size_t i = 0; i < out.shape(0); ++i) {
    const std::int64_t begin = loop::now_ns();
    if (!go()) return i;
    out.data()[i] = 1e-9 * static_cast<double>(loop::now_ns() - begin);
  }
  return out.shape(0);
}

/// Ticks, missed ticks and late answers of a thread in real time that takes an answer and sends a text in each tick.
std::tuple<std::uint64_t, std::uint64_t, std::uint64_t> pace(WebSocket& self, const std::string& text, double rate,
                                                             std::uint64_t n) {
  loop::RealTimeThread thread({.allow_affinity = false});
  std::uint64_t sent = 0, late = 0;
  thread.start(rate, [&](const loop::Wake&) {
    if (sent > 0 && self.receive(0) != WebSocket::Got::message) {
      ++late;
      if (self.receive(Device::kGone) != WebSocket::Got::message) return false;
    }
    return sent < n && self.send(text) && ++sent > 0;
  });
  while (thread.running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  thread.stop();
  return {sent, thread.punctuality().missed.load(), late};
}

void bind_connection(nb::module_& m) {
  nb::class_<WebSocket>(m, "Connection", "The client's end of a WebSocket, after the handshake.")
      .def(nb::init<int>(), "socket"_a, "Takes over the file descriptor of a connected socket.")
      .def("send", &send, "text"_a, "Sends a text. Raises RuntimeError if the connection is broken.")
      .def("receive", &receive, "seconds"_a, "Waits for a message [s]. Raises RuntimeError without one.")
      .def(
          "receive_bytes",
          [](WebSocket& self, double seconds) {
            const std::string found = receive(self, seconds);
            return nb::bytes(found.data(), found.size());
          },
          "seconds"_a, "As receive(), for messages that are no valid text.")
      .def(
          "round_trips",
          [](WebSocket& self, const std::string& text, Times out) {
            return time_trips(
                out, [&] { return self.send(text) && self.receive(nanoseconds(1.0)) == WebSocket::Got::message; });
          },
          "text"_a, "out"_a, nb::call_guard<nb::gil_scoped_release>(),
          "Sends a text and waits for the answer, as often as `out` (n,) is long; writes the times [s] to it. Returns "
          "how many there were.")
      .def("pace", &pace, "text"_a, "rate"_a, "n"_a, nb::call_guard<nb::gil_scoped_release>(),
           "Sends a text `n` times at a rate [Hz], from a thread like that of a driver, and takes each answer one "
           "period later. Returns the texts sent, the ticks missed, and the answers that were not there after a "
           "period.");
}

void bind_device(nb::module_& m) {
  nb::class_<Device, loop::Driver>(m, "Device", "A Haply device: a driver for the thread of the core.")
      .def(
          "__init__",
          [](Device* self, std::shared_ptr<WebSocket> service, std::shared_ptr<WebSocket> events,
             const std::string& device, const std::string& address, const std::string& grip, const std::string& list,
             bool vector, double rate, double force_max, double workspace) {
            new (self) Device({device, address, grip, list, vector, rate, force_max, workspace}, std::move(service),
                              std::move(events));
          },
          "service"_a, "events"_a.none(), nb::kw_only(), "device"_a, "address"_a, "grip"_a, "list"_a, "vector"_a,
          "rate"_a, "force_max"_a, "workspace"_a,
          "service: the connection after its inventory; events: that of the events, or None. device, grip: their ids; "
          "address: the id of the device as JSON, as the service wrote it; list: the list of the messages in which the "
          "grip is; vector: the service is 3.5 or later.")
      .def(
          "read",
          [](Device& self, OnePose X) -> std::optional<std::tuple<int, double>> {
            loop::DeviceState state;
            const loop::Reading found = [&] {
              const nb::gil_scoped_release released;
              return self.read(state);
            }();
            switch (found) {
              case loop::Reading::failed:
                throw std::runtime_error(self.why());
              case loop::Reading::missing:
                return std::nullopt;
              default:
                std::copy(state.X_LH.begin(), state.X_LH.end(), X.data());
                return std::tuple(static_cast<int>(state.buttons), state.gripper);
            }
          },
          "X"_a,
          "Writes the pose (4, 4) [m] to X. Returns the buttons and the angle of the gripper [rad], or None if there "
          "is "
          "no measurement. Raises RuntimeError if the device is lost.")
      .def(
          "write",
          [](Device& self, const OneWrench& F) {
            if (!self.write({{F.data()[0], F.data()[1], F.data()[2]}, Vec3::Zero()})) {
              throw std::runtime_error(self.why());
            }
          },
          "F"_a, "Commands the force of a wrench (6,) [N]. Raises RuntimeError if the device is lost.")
      .def(
          "round_trips",
          [](Device& self, Times out) {
            loop::DeviceState state;
            return time_trips(out, [&] {
              const std::uint64_t before = self.exchanges();
              if (!self.write({})) return false;
              while (self.exchanges() == before) {  // a read that is weary of waiting returns at once
                if (self.read(state) == loop::Reading::failed) return false;
              }
              return true;
            });
          },
          "out"_a, nb::call_guard<nb::gil_scoped_release>(),
          "Commands zero force and reads the answer, as often as `out` (n,) is long; writes the times [s] to it.")
      .def_prop_ro("exchanges", &Device::exchanges, "Number of answers of the service so far.")
      .def_prop_ro("late", &Device::late, "Number of answers that were not there when the next tick began.");
}

/// Position, velocity, quaternion, and the flags of an answer; None if it is not accepted.
using Answer = std::tuple<std::array<double, 3>, std::array<double, 3>, std::array<double, 4>, bool, bool, bool>;

void bind_reader(nb::module_& m) {
  nb::class_<haply::Reader>(m, "Reader", "Reads the messages of the service, as the driver does in its cycle.")
      .def(nb::init<std::string, std::string, std::string>(), "device"_a, "grip"_a, "list"_a)
      .def(
          "read",
          [](haply::Reader& self, const nb::bytes& text) -> std::optional<Answer> {
            haply::Measured found;
            if (self.read({text.c_str(), text.size()}, found) != haply::Parsed::good) return std::nullopt;
            return Answer(found.p, found.v, found.q, found.calibrated, found.ready, found.a);
          },
          "text"_a,
          "Position (3,) [m], velocity (3,) [m/s], orientation (4,) as x, y, z, w, calibrated, ready and button a of "
          "an answer; None if it is no valid state of the device.")
      .def(
          "read_event",
          [](haply::Reader& self, const nb::bytes& text) {
            return static_cast<int>(self.read_event({text.c_str(), text.size()}));
          },
          "text"_a, "Kind of an event; 0: it concerns no force of this device.");
}

}  // namespace
}  // namespace palpate::bindings

NB_MODULE(_haply, m) {
  nb::set_leak_warnings(false);  // objects that live until the interpreter ends are not leaks
  m.doc() = "Haply devices through the vendor's Inverse Service.";
  nb::module_::import_("palpate._core");
  palpate::bindings::bind_connection(m);
  palpate::bindings::bind_device(m);
  palpate::bindings::bind_reader(m);
}
