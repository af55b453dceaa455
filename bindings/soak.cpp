#include "palpate/verify/soak.hpp"

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include "bindings.hpp"

namespace nb = nanobind;

namespace palpate::bindings {
namespace {

verify::SoakReport soak(const std::shared_ptr<scene::Mesh>& mesh, const std::string& method, std::int64_t passes,
                        std::uint64_t seed, const verify::SoakRange& range) {
  const nb::gil_scoped_release release;
  return verify::soak(mesh, method, passes, seed, range);
}

}  // namespace

void bind_soak(nb::module_& m) {
  using verify::SoakPass, verify::SoakRange, verify::SoakReport;
  nb::class_<SoakRange>(m, "SoakRange", "What the passes are drawn from.")
      .def(nb::init<>())
      .def_rw("radius_min", &SoakRange::radius_min, "SPR [m]")
      .def_rw("radius_max", &SoakRange::radius_max, "SPR [m]")
      .def_rw("speed_min", &SoakRange::speed_min, "of the tool [m/s]")
      .def_rw("speed_max", &SoakRange::speed_max, "of the tool [m/s]")
      .def_rw("depth", &SoakRange::depth, "beyond the surface, at most [m]")
      .def_rw("drag", &SoakRange::drag, "afterwards, in any direction, at most [m]")
      .def_rw("angle", &SoakRange::angle, "from the normal, at most [rad]")
      .def_rw("object_speed", &SoakRange::object_speed, "of the object, at most [m/s]");
  nb::class_<SoakPass>(m, "SoakPass", "One pass, as it was drawn.")
      .def_ro("index", &SoakPass::index)
      .def_ro("radius", &SoakPass::radius, "[m]")
      .def_ro("speed", &SoakPass::speed, "[m/s]")
      .def_ro("depth", &SoakPass::depth, "[m]")
      .def_ro("object_moves", &SoakPass::object_moves);
  nb::class_<SoakReport>(m, "SoakReport", "What many passes at one mesh gave.")
      .def_ro("passes", &SoakReport::passes, "that found free space to begin in")
      .def_ro("ticks", &SoakReport::ticks)
      .def_ro("touched", &SoakReport::touched, "passes with a force")
      .def_ro("popped", &SoakReport::popped, "passes whose proxy crossed the surface")
      .def_ro("first_popped", &SoakReport::first_popped);
  m.def("soak", &soak, nb::arg("mesh"), nb::arg("method"), nb::arg("passes"), nb::arg("seed"), nb::arg("range"),
        "Random pokes at a mesh at 1 kHz, judged triangle by triangle; without the interpreter lock.");
}

}  // namespace palpate::bindings
