#include "palpate/verify/axis.hpp"

#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "bindings.hpp"
#include "palpate/verify/axis_layer.hpp"

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
using Rows = nb::ndarray<nb::numpy, double, nb::ndim<2>>;

Rows to_array(std::vector<AxisRow>&& rows) {
  auto owner = std::make_unique<std::vector<AxisRow>>(std::move(rows));
  auto* data = reinterpret_cast<double*>(owner->data());
  const std::size_t n = owner->size();
  nb::capsule capsule(owner.release(), [](void* p) noexcept { delete static_cast<std::vector<AxisRow>*>(p); });
  return Rows(data, {n, kColumns}, capsule);
}

AxisMotion motion(std::optional<double> duration, double x0, double v0, double push, std::vector<double> path) {
  return {duration, x0, v0, push, std::move(path)};
}

/// The stage `stability` between the wall and the drive, where it is asked for.
std::unique_ptr<verify::AxisLayer> make_layer(const Axis& axis, const std::optional<stability::Options>& options) {
  if (!options) return nullptr;
  return std::make_unique<verify::AxisLayer>(*options, axis.options().K, 1.0 / axis.options().rate);
}

void bind_result(nb::module_& m) {
  nb::class_<AxisResult>(m, "AxisResult", "What came of a run of an Axis.")
      .def_ro("diverged", &AxisResult::diverged, "it left |x| < 1 m")
      .def_ro("oscillates", &AxisResult::oscillates, "it left |x| < 1 m, or its swing lasts")
      .def_prop_ro(
          "swing", [](const AxisResult& r) { return verify::swing_name(r.swing); },
          "rests, decays, lasts or undecided: see judge_swing")
      .def_ro("growth", &AxisResult::growth, "of the amplitude, relative, by its trend [1/s]")
      .def_ro("duration", &AxisResult::duration, "of the run [s]")
      .def_ro("amplitude", &AxisResult::amplitude, "half of peak to peak in the last quarter of the run [m]")
      .def_ro("frequency", &AxisResult::frequency, "in the last quarter [Hz]")
      .def_ro("peak", &AxisResult::peak, "deepest [m]")
      .def_ro("rest", &AxisResult::rest, "mean of the last quarter [m]")
      .def_ro("overshoot", &AxisResult::overshoot, "(peak - rest) / rest [-]")
      .def_ro("settling", &AxisResult::settling, "from then on |x - rest| < 2 % of |rest| [s]")
      .def_ro("energy_port", &AxisResult::energy_port, "taken from the hand by the wall, true [J]")
      .def_ro("energy_min", &AxisResult::energy_min, "lowest that it was: below zero the wall had made energy [J]");
}

}  // namespace

void bind_axis(nb::module_& m) {
  nb::class_<SwingJudgement>(m, "SwingJudgement", "Whether a motion keeps swinging.")
      .def_prop_ro(
          "swing", [](const SwingJudgement& j) { return verify::swing_name(j.swing); },
          "rests, decays, lasts or undecided")
      .def_ro("growth", &SwingJudgement::growth, "of the amplitude, relative, by its trend [1/s]")
      .def_ro("change", &SwingJudgement::change, "of the logarithm of the amplitude over the watched windows [-]")
      .def_ro("period", &SwingJudgement::period, "of the slowest mode, as given or as seen [s]");
  m.def(
      "judge_swing",
      [](const std::vector<double>& x, double dt, double period, double floor) {
        if (!(dt > 0.0) || !(period >= 0.0) || !(floor > 0.0)) {
          throw std::invalid_argument("judge_swing: dt and floor must be above 0, period 0 or more");
        }
        return verify::judge_swing(x, dt, period, floor);
      },
      "x"_a, "dt"_a, "period"_a, "floor"_a,
      "Judge positions x (n,) [m] that are dt [s] apart: does the end stay within floor [m], or does the amplitude of "
      "windows of at least one period [s] of the slowest mode fall along its trend?");
  m.attr("AXIS_QUANTA") = verify::kAxisQuanta;
  m.attr("AXIS_UNFELT") = verify::kAxisUnfelt;
  nb::class_<AxisOptions>(m, "AxisOptions", "One axis of a haptic device, its loop, a virtual wall at x > 0, a hand.")
      .def(nb::init<>())
      .def_rw("mass", &AxisOptions::mass, "of the device [kg]")
      .def_rw("damping", &AxisOptions::damping, "viscous [N s/m]")
      .def_rw("coulomb", &AxisOptions::coulomb, "dry friction [N]")
      .def_rw("rate", &AxisOptions::rate, "of the haptic cycle [Hz]")
      .def_rw("delay", &AxisOptions::delay, "from the measurement to the force [s]")
      .def_rw("jitter", &AxisOptions::jitter, "added to it in each cycle, uniform in 0..jitter [s]")
      .def_rw("quantum", &AxisOptions::quantum, "of the measured position; 0 = ideal [m]")
      .def_rw("velocity_cutoff", &AxisOptions::velocity_cutoff, "low pass of the difference; 0 = none [Hz]")
      .def_rw("K", &AxisOptions::K, "stiffness of the wall [N/m]")
      .def_rw("B", &AxisOptions::B, "its damping [N s/m]")
      .def_rw("bilateral", &AxisOptions::bilateral, "a spring that pulls, too")
      .def_rw("force_max", &AxisOptions::force_max, "the force is cut there [N]")
      .def_rw("rate_max", &AxisOptions::rate_max, "it changes no faster [N/s]")
      .def_rw("hand_mass", &AxisOptions::hand_mass, "moves with the device [kg]")
      .def_rw("hand_damping", &AxisOptions::hand_damping, "to where the hand wants to be [N s/m]")
      .def_rw("hand_stiffness", &AxisOptions::hand_stiffness, "the same [N/m]")
      .def_rw("seed", &AxisOptions::seed, "of the jitter");
  bind_result(m);
  nb::class_<Axis>(m, "Axis", "Simulates it: exact between commands, cycles and reversals of dry friction.")
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
          "duration [s] from (x0 [m], v0 [m/s]), or none: as long as it takes to judge the swing, by periods of the "
          "slowest mode; push: constant force of the hand [N]; path: where it wants to be at "
          "each cycle [m], then rests; nowhere else than 0 when left out; stability: options of that stage, or none.")
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
          "The same run, with its rows (n, 5), one per cycle: t [s], x [m], v [m/s], force commanded on the device "
          "along x [N], energy_port [J].");
}

}  // namespace palpate::bindings
