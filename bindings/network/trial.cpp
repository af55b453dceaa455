#include "palpate/network/trial.hpp"

#include <nanobind/stl/tuple.h>

#include <memory>
#include <tuple>

#include "doc.hpp"
#include "network/bindings.hpp"
#include "palpate/network/alarms.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using network::OperatorOptions;
using network::PalpationOptions;
using network::Trial;
using network::TrialOptions;
using network::TrialResult;
using network::TrialRow;

constexpr std::size_t kTrialColumns = sizeof(TrialRow) / sizeof(double);

void bind_trial_options(nb::module_& m) {
  nb::class_<OperatorOptions, network::EndOptions>(m, "OperatorOptions", "Options of the operator's end.")
      .def(nb::init<>())
      .def_rw("rate", &OperatorOptions::rate, "Rate of the cycle [Hz]."_doc)
      .def_rw("stability", &OperatorOptions::stability, "Options of the stage `stability`."_doc)
      .def_rw("update", &OperatorOptions::update, "Limits of updates of the local model."_doc);
  nb::class_<TrialOptions>(m, "TrialOptions", "A simulated teleoperation in virtual time.")
      .def(nb::init<>())
      .def_rw("operator_end", &TrialOptions::operator_end, "Operator's end."_doc)
      .def_rw("site", &TrialOptions::site, "Follower's end."_doc)
      .def_rw("instrument", &TrialOptions::instrument, "Simulated instrument."_doc)
      .def_rw("to_site", &TrialOptions::to_site, "Link from the operator to the site."_doc)
      .def_rw("to_operator", &TrialOptions::to_operator, "Link from the site to the operator."_doc)
      .def_rw("every", &TrialOptions::every, "Ticks between two packets of each end."_doc)
      .def_rw("handle_mass", &TrialOptions::handle_mass, "[kg]."_doc)
      .def_rw("handle_damping", &TrialOptions::handle_damping, "[N s/m]."_doc)
      .def_rw("hand_mass", &TrialOptions::hand_mass, "[kg]."_doc)
      .def_rw("hand_damping", &TrialOptions::hand_damping, "[N s/m]."_doc)
      .def_rw("hand_stiffness", &TrialOptions::hand_stiffness, "[N/m]."_doc)
      .def_rw("clock_offset", &TrialOptions::clock_offset, "Of the site's clock [s]."_doc)
      .def_rw("clock_drift", &TrialOptions::clock_drift, "Of the site's clock [-]."_doc)
      .def_rw("settle", &TrialOptions::settle,
              "Time after first touch and three round trips that does not count [s]."_doc)
      .def_rw("round_trip", &TrialOptions::round_trip, "Nominal round trip [s]."_doc)
      .def_rw("after_release", &TrialOptions::after_release, "Forces count once the first touch has ended as well."_doc)
      .def_rw("seed", &TrialOptions::seed, "Seed of links and noise."_doc)
      .def(
          "push",
          [](TrialOptions& self, double t, std::size_t object, const Vec3& shift) { self.push = {t, object, shift}; },
          "t"_a, "object"_a, "shift"_a, "Pushes an object aside by shift (3,) [m] at the time t [s].");
}

void bind_alarms(nb::module_& m) {
  nb::class_<network::Alarms>(m, "Alarms", "Figures of the detector of outages on one emulated link.")
      .def_ro("false_alarms", &network::Alarms::false_alarms, "Outages reported while packets were sent."_doc)
      .def_ro("seconds", &network::Alarms::seconds, "Virtual time in which they were counted [s]."_doc)
      .def_ro("p999", &network::Alarms::p999, "99.9th percentile of the age before the outage [s]."_doc)
      .def_ro("limit", &network::Alarms::limit, "Age from which an outage is reported then [s]."_doc)
      .def_ro("possible", &network::Alarms::possible,
              "Age that an hour of this link exceeds once without an outage [s]."_doc)
      .def_ro("told", &network::Alarms::told, "Age at which the outage at the end was reported [s]."_doc);
  m.def("count_alarms", &network::count_alarms, "condition"_a, "seconds"_a, "settle"_a = 30.0, "seed"_a = 0,
        nb::call_guard<nb::gil_scoped_release>(),
        "Sends a packet every millisecond for `seconds` of virtual time, then none; counts the outages that are "
        "reported. The first `settle` seconds do not count.");
}

}  // namespace

void bind_trial(nb::module_& m) {
  bind_alarms(m);
  bind_trial_options(m);
  nb::class_<TrialResult>(m, "TrialResult", "Figures of a trial; energies by quadrature of the simulated motion.")
      .def_ro("energy_hand", &TrialResult::energy_hand,
              "Lowest energy that the hand has put in, less the work of moving surfaces [J]."_doc)
      .def_ro("energy_site", &TrialResult::energy_site,
              "Lowest gross energy of the hand less net work on the tissue [J]."_doc)
      .def_ro("energy_ports", &TrialResult::energy_ports,
              "Lowest net energy of the hand less net work on the tissue [J]."_doc)
      .def_ro("felt_over_true", &TrialResult::felt_over_true, "Slope of the felt over the true force [-]."_doc)
      .def_ro("force_rms", &TrialResult::force_rms, "Rms of their difference in contact [N]."_doc)
      .def_ro("force_site", &TrialResult::force_site, "Largest force on the tissue [N]."_doc)
      .def_ro("kick", &TrialResult::kick, "Largest change of the force per tick that no motion explains [N]."_doc)
      .def_ro("drift", &TrialResult::drift, "Distance of instrument and hand at the end [m]."_doc)
      .def_ro("relearnt", &TrialResult::relearnt,
              "Time from the push until the force is right [s]; negative: never."_doc)
      .def_ro("told", &TrialResult::told, "Time of the first fixed outage until both ends report it [s]."_doc)
      .def_ro("told_site", &TrialResult::told_site, "The same at the site, beyond its p99.9 [s]."_doc)
      .def_ro("p999", &TrialResult::p999, "99.9th percentile of the age at the site [s]."_doc)
      .def_ro("round_trip", &TrialResult::round_trip, "Sum of the median ages of both directions [s]."_doc)
      .def_ro("play_delay", &TrialResult::play_delay, "Delay of the played motion at the end [s]."_doc)
      .def_ro("clock_error", &TrialResult::clock_error, "Error of the site's estimate of the other clock [s]."_doc)
      .def_ro("outages", &TrialResult::outages, "Outages that the site has reported."_doc)
      .def_ro("lost", &TrialResult::lost, "Share of packets to the site that were lost [-]."_doc)
      .def_ro("touching", &TrialResult::touching, "Time in contact that counted [s]."_doc)
      .def_ro("palpated", &TrialResult::palpated,
              "Time of a palpation, since the link stood [s]; negative: not in time."_doc);
  m.def(
      "trial_columns",
      [] {
        return std::vector<std::string>{"t",  "depth", "felt",    "truth",      "x_hand", "x_site",      "F_site",
                                        "K",  "shift", "account", "play_delay", "tank",   "energy_hand", "energy_site",
                                        "mu", "error", "shift_x", "shift_y",    "shift_z"};
      },
      "Names of the columns of the rows of a trial.");
  m.def(
      "trial",
      [](const TrialOptions& options, const scene::Snapshot& world, const scene::Snapshot& model,
         const Points& path) -> Tuple<TrialResult, Table> {
        std::vector<Vec3> points;
        for (std::size_t i = 0; i < path.shape(0); ++i) points.emplace_back(path.data() + 3 * i);
        if (points.size() < 2) throw nb::value_error("path must have at least two points, one per millisecond");
        auto rows = std::make_unique<std::vector<TrialRow>>();
        TrialResult result;
        {
          const nb::gil_scoped_release release;
          Trial trial(options, world, model);
          rows->reserve(points.size());
          result = trial.run(points, rows.get());
        }
        auto* data = reinterpret_cast<double*>(rows->data());
        const std::size_t n = rows->size();
        nb::capsule owner(rows.release(), [](void* p) noexcept { delete static_cast<std::vector<TrialRow>*>(p); });
        return nb::make_tuple(result, Table(data, {n, kTrialColumns}, owner));
      },
      "options"_a, "world"_a, "model"_a, "path"_a,
      "Simulates a hand with the intended path (n, 3) [m], one point per millisecond: (figures, rows (n - 1, 19) with "
      "the columns trial_columns()). world: the objects as they are; model: as both ends have them.");
  m.def(
      "palpation",
      [](const TrialOptions& options, const scene::Snapshot& world, const scene::Snapshot& model, const Points& places,
         double force, double most) {
        PalpationOptions palpation;
        for (std::size_t i = 0; i < places.shape(0); ++i) palpation.places.emplace_back(places.data() + 3 * i);
        palpation.force = force;
        const nb::gil_scoped_release release;
        return Trial(options, world, model).palpate(palpation, most);
      },
      "options"_a, "world"_a, "model"_a, "places"_a, "force"_a = 1.0, "most"_a = 60.0,
      "Simulates a person who presses the surface below each of the places (n, 3) [m] with this force [N], for at most "
      "`most` [s]; the figures.");
}

}  // namespace palpate::bindings
