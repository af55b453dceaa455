#include <cstring>

#include "convert.hpp"
#include "doc.hpp"
#include "network/bindings.hpp"
#include "palpate/network/arrivals.hpp"
#include "palpate/network/clock.hpp"
#include "palpate/network/packet.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using network::Arrivals;
using network::ClockSync;
using network::Datagram;
using network::ModelEstimate;
using network::ReplayWindow;

std::span<const std::uint8_t> view(const nb::bytes& bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.c_str()), bytes.size()};
}

void bind_datagram(nb::module_& m) {
  nb::class_<ModelEstimate>(m, "ModelEstimate", "What the site has learnt about one object.")
      .def(nb::init<>())
      .def_rw("object", &ModelEstimate::object, "Index of the object; 65535: none yet."_doc)
      .def_rw("shift", &ModelEstimate::shift, "Displacement from its place in the scene, in W (3,) [m]."_doc)
      .def_rw("normal", &ModelEstimate::normal, "Of a plane: outward unit normal in W; zero: an object (3,)."_doc)
      .def_rw("K", &ModelEstimate::K, "Stiffness [N/m]."_doc)
      .def_rw("B", &ModelEstimate::B, "Damping along the normal [N s/m]."_doc)
      .def_rw("mu", &ModelEstimate::mu, "Friction coefficient [-]."_doc)
      .def_rw("sd_K", &ModelEstimate::sd_K, "Standard deviation of K [N/m]."_doc)
      .def_rw("sd_shift", &ModelEstimate::sd_shift, "Standard deviation of the shift along the touched normal [m]."_doc)
      .def_rw("margin", &ModelEstimate::margin, "Rms of the measured force minus that of the estimate [N]."_doc);
  nb::class_<Datagram>(m, "Datagram", "State of one end at one moment, in W (docs/network.md).")
      .def(nb::init<>())
      .def_rw("t", &Datagram::t, "Clock of the sender [s]."_doc)
      .def_rw("t_peer", &Datagram::t_peer, "Clock of the receiver in its newest packet that the sender has [s]."_doc)
      .def_rw("t_received", &Datagram::t_received, "Clock of the sender when that packet arrived [s]."_doc)
      .def_prop_rw(
          "X", [](const Datagram& d) -> Matrix4 { return to_matrix(d.X); },
          [](Datagram& d, const Matrix4& X) { d.X = to_pose(X, "X"); }, "Pose of the tool (4, 4) [m]."_doc)
      .def_rw("v", &Datagram::v, "Velocity of the tool (3,) [m/s]."_doc)
      .def_rw("jaw", &Datagram::jaw, "Jaw angle [rad]."_doc)
      .def_rw("F", &Datagram::F, "Force on the hand, or of the environment on the tool (3,) [N]."_doc)
      .def_rw("energy_in", &Datagram::energy_in, "Energy that the sender's port has taken, without returns [J]."_doc)
      .def_rw("energy_out", &Datagram::energy_out, "Energy that it has given [J]."_doc)
      .def_rw("play_delay", &Datagram::play_delay, "Site: delay at which the motion is played [s]."_doc)
      .def_rw("flags", &Datagram::flags, "Bits FLAG_*."_doc)
      .def_rw("model", &Datagram::model, "Site: the estimate of the object touched last."_doc);
  m.attr("PACKET_SIZE") = network::kPacketSize;
  m.attr("PACKET_VERSION") = static_cast<int>(network::kVersion);
  m.attr("FLAG_ENGAGED") = static_cast<unsigned>(network::kEngaged);
  m.attr("FLAG_OUTAGE") = static_cast<unsigned>(network::kOutage);
  m.attr("FLAG_ALIGNED") = static_cast<unsigned>(network::kAligned);
  m.attr("FLAG_HOLDING") = static_cast<unsigned>(network::kHolding);
  m.attr("FLAG_LIMITED") = static_cast<unsigned>(network::kLimited);
  m.attr("FLAG_UNMODELLED") = static_cast<unsigned>(network::kUnmodelled);
  m.def(
      "encode",
      [](const Datagram& d) {
        const network::Bytes bytes = network::encode(d);
        return nb::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      },
      "datagram"_a, "The bytes of a datagram before encryption.");
  m.def(
      "decode",
      [](const nb::bytes& bytes) -> std::optional<Datagram> {
        Datagram out;
        if (!network::decode(view(bytes), out)) return std::nullopt;
        return out;
      },
      "bytes"_a, "The datagram of these bytes; None unless they are valid.");
}

}  // namespace

void bind_packets(nb::module_& m) {
  bind_datagram(m);
  nb::class_<ReplayWindow>(m, "ReplayWindow", "Refuses numbers that were seen before or are too old.")
      .def(nb::init<>())
      .def("accept", &ReplayWindow::accept, "number"_a, "True if the number is new; it then counts as seen.");
  nb::class_<ClockSync>(m, "ClockSync", "Offset and drift of the peer's clock, by the times of packets.")
      .def(nb::init<>())
      .def("add", &ClockSync::add, "t1"_a, "t2"_a, "t3"_a, "t4"_a,
           "One exchange [s]: t1 sent here, t2 received there, t3 sent there, t4 received here.")
      .def("offset", &ClockSync::offset, "t"_a, "Peer's clock minus own clock at the own time t [s].")
      .def_prop_ro("known", &ClockSync::known, "True once an exchange is known.")
      .def_prop_ro("drift", &ClockSync::drift, "Rate of the peer's clock minus 1 [-].")
      .def_prop_ro("bound", &ClockSync::bound, "Bound of the error by an unknown asymmetry of the delays [s].");
  nb::class_<Arrivals>(m, "Arrivals", "Percentiles of the age of the newest packet, and outages.")
      .def(nb::init<>())
      .def("step", &Arrivals::step, "age"_a, "dt"_a,
           "One tick: age of the newest packet, time since the last tick [s].")
      .def_prop_ro("outage", &Arrivals::outage, "True during an outage.")
      .def_prop_ro("age", &Arrivals::age, "Age of the newest packet [s].")
      .def_prop_ro("p50", &Arrivals::p50, "Median of the age [s].")
      .def_prop_ro("p99", &Arrivals::p99, "99th percentile [s].")
      .def_prop_ro("p999", &Arrivals::p999, "99.9th percentile [s].")
      .def_prop_ro("limit", &Arrivals::limit, "Age from which an outage is told [s].")
      .def_prop_ro("outages", &Arrivals::outages, "Number of outages so far.");
}

}  // namespace palpate::bindings
