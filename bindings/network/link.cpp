#include <nanobind/stl/pair.h>

#include <cmath>

#include "doc.hpp"
#include "network/bindings.hpp"
#include "palpate/network/emulator.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using network::Condition;
using network::FourStates;
using network::GilbertElliott;
using network::Link;

void bind_loss(nb::module_& m) {
  nb::class_<GilbertElliott>(m, "GilbertElliott", "Loss by a Markov chain of two states, stepped at each packet.")
      .def(
          "__init__",
          [](GilbertElliott* self, double to_bad, double to_good, double loss_good, double loss_bad) {
            new (self) GilbertElliott{to_bad, to_good, loss_good, loss_bad};
          },
          "to_bad"_a = 0.0, "to_good"_a = 1.0, "loss_good"_a = 0.0, "loss_bad"_a = 0.0)
      .def_ro("to_bad", &GilbertElliott::to_bad, "Probability of the step from good to bad [-]."_doc)
      .def_ro("to_good", &GilbertElliott::to_good, "Probability of the step from bad to good [-]."_doc)
      .def_ro("loss_good", &GilbertElliott::loss_good, "Loss in the good state [-]."_doc)
      .def_ro("loss_bad", &GilbertElliott::loss_bad, "Loss in the bad state [-]."_doc);
  nb::class_<FourStates>(m, "FourStates",
                         "Loss by a Markov chain of four states: 1 received, 2 received within a burst, 3 lost within "
                         "a burst, 4 lost alone. p13 is the probability of the step from 1 to 3.")
      .def(
          "__init__",
          [](FourStates* self, double p13, double p31, double p32, double p23, double p14) {
            new (self) FourStates{p13, p31, p32, p23, p14};
          },
          "p13"_a = 0.0, "p31"_a = 1.0, "p32"_a = 0.0, "p23"_a = 1.0, "p14"_a = 0.0)
      .def_ro("p13", &FourStates::p13, "1 to 3 [-]."_doc)
      .def_ro("p31", &FourStates::p31, "3 to 1 [-]."_doc)
      .def_ro("p32", &FourStates::p32, "3 to 2 [-]."_doc)
      .def_ro("p23", &FourStates::p23, "2 to 3 [-]."_doc)
      .def_ro("p14", &FourStates::p14, "1 to 4 [-]."_doc);
}

/// Pairs (n, 2) of numbers as structs of two.
template <class T>
std::vector<T> pairs(const std::vector<std::pair<double, double>>& rows) {
  std::vector<T> out;
  for (const auto& [a, b] : rows) out.push_back({a, b});
  return out;
}

/// Structs of two numbers as pairs.
template <class T>
std::vector<std::pair<double, double>> rows(const std::vector<T>& values) {
  std::vector<std::pair<double, double>> out;
  for (const auto& [a, b] : values) out.emplace_back(a, b);
  return out;
}

}  // namespace

void bind_link(nb::module_& m) {
  bind_loss(m);
  nb::class_<Condition>(m, "Condition", "What a link does to the packets of one direction. Times in seconds.")
      .def(nb::init<>())
      .def_rw("delay", &Condition::delay, "Smallest delay [s]."_doc)
      .def_rw("weights", &Condition::weights, "Weights of the exponentials of the additional delay [-]."_doc)
      .def_rw("rates", &Condition::rates, "Rates of these exponentials [1/s]."_doc)
      .def_rw("correlation", &Condition::correlation,
              "Correlation of the additional delays of successive packets, as a Gaussian copula [-]."_doc)
      .def_rw("keep_order", &Condition::keep_order, "True: no packet arrives before an earlier one."_doc)
      .def_rw("reorder", &Condition::reorder, "Share of packets that are held back by reorder_delay [-]."_doc)
      .def_rw("reorder_delay", &Condition::reorder_delay, "[s]."_doc)
      .def_rw("duplicate", &Condition::duplicate, "Share of packets that arrive twice [-]."_doc)
      .def_rw("gilbert", &Condition::gilbert, "Loss of two states."_doc)
      .def_rw("four", &Condition::four, "Loss of four states."_doc)
      .def_rw("rate", &Condition::rate, "Rate limit [bytes/s]; 0: unlimited."_doc)
      .def_rw("queue", &Condition::queue, "Longest wait for the rate limit; beyond it packets are lost [s]."_doc)
      .def_rw("outage_every", &Condition::outage_every, "Mean time between random outages [s]; 0: none."_doc)
      .def_rw("outage_min", &Condition::outage_min, "Shortest random outage [s]."_doc)
      .def_rw("outage_max", &Condition::outage_max, "Longest random outage [s]."_doc)
      .def_prop_rw(
          "outages", [](const Condition& c) { return rows(c.outages); },
          [](Condition& c, const std::vector<std::pair<double, double>>& given) {
            c.outages = pairs<network::Outage>(given);
          },
          "Outages as (begin, duration) [s].")
      .def_prop_rw(
          "trace", [](const Condition& c) { return rows(c.trace); },
          [](Condition& c, const std::vector<std::pair<double, double>>& given) {
            c.trace = pairs<network::TracePoint>(given);
          },
          "Measured delays as (time, delay) [s]; a negative delay is a loss. They replace delay and mixture.")
      .def("check", &network::check, "Raises ValueError that names the value, unless the condition is valid.")
      .def("quantile", &network::mixture_quantile, "survival"_a,
           "Additional delay that is exceeded with the probability `survival`, in (0, 1] [s].");
  nb::class_<Link>(m, "Link", "One direction of an emulated link. The same seed gives the same delays and losses.")
      .def(nb::init<const Condition&, std::uint64_t>(), "condition"_a, "seed"_a)
      .def(
          "send",
          [](Link& self, double t, std::size_t bytes) {
            const network::Fate fate = self.send(t, bytes);
            return std::vector<double>(fate.arrival.begin(), fate.arrival.begin() + fate.copies);
          },
          "t"_a, "bytes"_a = 256,
          "Sends a packet at the time t [s]; returns the times at which its copies arrive, none if it is lost.")
      .def(
          "send_all",
          [](Link& self, const Times& t, std::size_t bytes) {
            std::vector<double> out(t.shape(0));
            for (std::size_t i = 0; i < out.size(); ++i) {
              const network::Fate fate = self.send(t.data()[i], bytes);
              out[i] = fate.copies > 0 ? fate.arrival[0] : NAN;
            }
            const std::size_t n = out.size();
            return array(std::move(out), {n});
          },
          "t"_a, "bytes"_a = 256, "Arrival (n,) of the first copy of packets sent at t (n,) [s]; NaN: lost.");
}

}  // namespace palpate::bindings
