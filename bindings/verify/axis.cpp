#include "palpate/verify/axis.hpp"

#include <memory>

#include "doc.hpp"
#include "palpate/verify/axis_layer.hpp"
#include "types.hpp"
#include "verify/bindings.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using verify::Axis;
using verify::AxisMotion;
using verify::AxisOptions;
using verify::AxisResult;
using verify::AxisRow;
using verify::SwingJudgement;

constexpr std::size_t kColumns = sizeof(AxisRow) / sizeof(double);

Table to_array(std::vector<AxisRow>&& rows) {
  auto owner = std::make_unique<std::vector<AxisRow>>(std::move(rows));
  auto* data = reinterpret_cast<double*>(owner->data());
  const std::size_t n = owner->size();
  nb::capsule capsule(owner.release(), [](void* p) noexcept { delete static_cast<std::vector<AxisRow>*>(p); });
  return Table(data, {n, kColumns}, capsule);
}

AxisMotion motion(std::optional<double> duration, double x0, double v0, double push, std::vector<double> path) {
  return {duration, x0, v0, push, std::move(path)};
}

/// The stage `stability` between the wall and the drive; null without options.
std::unique_ptr<verify::AxisLayer> make_layer(const Axis& axis, const std::optional<stability::Options>& options) {
  if (!options) return nullptr;
  return std::make_unique<verify::AxisLayer>(*options, axis.options());
}

void bind_result(nb::module_& m) {
  nb::class_<AxisResult>(m, "AxisResult", "Outcome of a run of an Axis.")
      .def_ro("diverged", &AxisResult::diverged, "True if |x| reached 1 m."_doc)
      .def_ro("oscillates", &AxisResult::oscillates, "True if |x| reached 1 m, or if the swing lasts."_doc)
      .def_prop_ro(
          "swing", [](const AxisResult& r) { return verify::swing_name(r.swing); },
          "rests, decays, lasts or undecided (judge_swing).")
      .def_ro("growth", &AxisResult::growth, "Relative growth rate of the amplitude, from its trend [1/s]."_doc)
      .def_ro("duration", &AxisResult::duration, "Duration of the run [s]."_doc)
      .def_ro("amplitude", &AxisResult::amplitude,
              "Half the peak-to-peak motion in the last quarter of the run [m]."_doc)
      .def_ro("frequency", &AxisResult::frequency, "Frequency of the motion in the last quarter of the run [Hz]."_doc)
      .def_ro("peak", &AxisResult::peak, "Largest penetration [m]."_doc)
      .def_ro("rest", &AxisResult::rest, "Mean position in the last quarter of the run [m]."_doc)
      .def_ro("overshoot", &AxisResult::overshoot,
              "(peak - rest) / rest [-]; 0 if the axis does not rest inside the wall."_doc)
      .def_ro("settling", &AxisResult::settling, "Time from which on |x - rest| < 2 % of |rest| [s]."_doc)
      .def_ro("energy_port", &AxisResult::energy_port,
              "Energy that the wall took from the hand, by the true positions [J]."_doc)
      .def_ro("energy_min", &AxisResult::energy_min,
              "Smallest value of that energy; negative if the wall generated energy [J]."_doc);
}

void bind_swing(nb::module_& m) {
  nb::class_<SwingJudgement>(m, "SwingJudgement", "Whether a motion keeps oscillating.")
      .def_prop_ro(
          "swing", [](const SwingJudgement& j) { return verify::swing_name(j.swing); },
          "rests, decays, lasts or undecided.")
      .def_ro("growth", &SwingJudgement::growth, "Relative growth rate of the amplitude, from its trend [1/s]."_doc)
      .def_ro("change", &SwingJudgement::change, "Change of the logarithm of the amplitude over all windows [-]."_doc)
      .def_ro("period", &SwingJudgement::period, "Period of the slowest mode, as given or as observed [s]."_doc);
  m.def(
      "judge_swing",
      [](const std::vector<double>& x, double dt, double period, double floor) {
        if (!(dt > 0.0) || !(period >= 0.0) || !(floor > 0.0)) {
          throw std::invalid_argument("judge_swing: dt and floor must be above 0, period 0 or more");
        }
        return verify::judge_swing(x, dt, period, floor);
      },
      "x"_a, "dt"_a, "period"_a, "floor"_a,
      "Judges positions x (n,) [m] at intervals dt [s]: whether the end stays within floor [m], and whether the "
      "amplitude of windows of at least one period [s] of the slowest mode falls along its trend.");
}

void bind_axis_options(nb::module_& m) {
  nb::class_<AxisOptions>(m, "AxisOptions",
                          "One axis of a haptic device with its control loop, a hand, and a virtual wall at x > 0.")
      .def(nb::init<>())
      .def_rw("mass", &AxisOptions::mass, "Mass of the device [kg]."_doc)
      .def_rw("damping", &AxisOptions::damping, "Viscous damping of the device [N s/m]."_doc)
      .def_rw("coulomb", &AxisOptions::coulomb, "Dry friction of the device [N]."_doc)
      .def_rw("rate", &AxisOptions::rate, "Rate of the haptic cycle [Hz]."_doc)
      .def_rw("delay", &AxisOptions::delay, "Delay from the measurement to the force [s]."_doc)
      .def_rw("jitter", &AxisOptions::jitter, "Additional random delay of each cycle, uniform in 0..jitter [s]."_doc)
      .def_rw("quantum", &AxisOptions::quantum, "Resolution of the measured position [m]; 0: exact."_doc)
      .def_rw("velocity_cutoff", &AxisOptions::velocity_cutoff,
              "Cutoff of the low-pass on the differentiated position [Hz]; 0: no low-pass."_doc)
      .def_rw("K", &AxisOptions::K, "Stiffness of the wall [N/m]."_doc)
      .def_rw("B", &AxisOptions::B, "Damping of the wall [N s/m]."_doc)
      .def_rw("bilateral", &AxisOptions::bilateral, "True: the wall is a spring that also pulls."_doc)
      .def_rw("force_max", &AxisOptions::force_max, "Largest force of the device [N]."_doc)
      .def_rw("rate_max", &AxisOptions::rate_max, "Largest rate of change of the force [N/s]."_doc)
      .def_rw("hand_mass", &AxisOptions::hand_mass, "Mass of the hand, which moves with the device [kg]."_doc)
      .def_rw("hand_damping", &AxisOptions::hand_damping, "Damping between the hand and its intended path [N s/m]."_doc)
      .def_rw("hand_stiffness", &AxisOptions::hand_stiffness,
              "Stiffness between the hand and its intended path [N/m]."_doc)
      .def_rw("seed", &AxisOptions::seed, "Seed of the jitter."_doc);
}

}  // namespace

void bind_axis(nb::module_& m) {
  bind_swing(m);
  m.attr("AXIS_QUANTA") = verify::kAxisQuanta;
  m.attr("AXIS_UNFELT") = verify::kAxisUnfelt;
  bind_axis_options(m);
  bind_result(m);
  nb::class_<Axis>(m, "Axis",
                   "Simulates the axis in closed form between commands, cycles and reversals of the dry friction.")
      .def(nb::init<const AxisOptions&>(), "options"_a)
      .def(
          "run",
          [](Axis& self, std::optional<double> duration, double x0, double v0, double push, std::vector<double> path,
             const std::optional<stability::Options>& stability) {
            nb::gil_scoped_release release;
            auto layer = make_layer(self, stability);
            return self.run(motion(duration, x0, v0, push, std::move(path)), layer.get());
          },
          "duration"_a = nb::none(), "x0"_a = 0.0, "v0"_a = 0.0, "push"_a = 0.0, "path"_a = std::vector<double>{},
          "stability"_a = nb::none(),
          "Simulates duration [s] from position x0 [m] and velocity v0 [m/s]. Without a duration the run is as long as "
          "the "
          "judgement of the swing needs, in periods of the slowest mode. push: constant force of the hand [N]. path: "
          "intended position of the hand at each cycle [m], its last value held; empty: 0. stability: options of the "
          "stage "
          "`stability`; None: without that stage.")
      .def(
          "trace",
          [](Axis& self, std::optional<double> duration, double x0, double v0, double push, std::vector<double> path,
             const std::optional<stability::Options>& stability) {
            std::vector<AxisRow> rows;
            auto layer = make_layer(self, stability);
            const AxisResult result = self.run(motion(duration, x0, v0, push, std::move(path)), layer.get(), &rows);
            return std::make_tuple(result, to_array(std::move(rows)));
          },
          "duration"_a = nb::none(), "x0"_a = 0.0, "v0"_a = 0.0, "push"_a = 0.0, "path"_a = std::vector<double>{},
          "stability"_a = nb::none(),
          "The same run as (AxisResult, rows (n, 5)) with one row per cycle: t [s], x [m], v [m/s], force commanded on "
          "the device along x [N], energy_port [J].");
}

}  // namespace palpate::bindings
