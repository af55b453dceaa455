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
  nb::class_<SoakRange>(m, "SoakRange", "Ranges from which each pass draws its values.")
      .def(nb::init<>())
      .def_rw("radius_min", &SoakRange::radius_min, "Smallest SPR radius [m].")
      .def_rw("radius_max", &SoakRange::radius_max, "Largest SPR radius [m].")
      .def_rw("speed_min", &SoakRange::speed_min, "Smallest speed of the tool [m/s].")
      .def_rw("speed_max", &SoakRange::speed_max, "Largest speed of the tool [m/s].")
      .def_rw("depth", &SoakRange::depth, "Largest depth below the surface [m].")
      .def_rw("drag", &SoakRange::drag, "Largest length of the drag that follows, in any direction [m].")
      .def_rw("angle", &SoakRange::angle, "Largest angle between the motion and the surface normal [rad].")
      .def_rw("object_speed", &SoakRange::object_speed, "Largest speed of the object [m/s].");
  nb::class_<SoakPass>(m, "SoakPass", "Values of one pass.")
      .def_ro("index", &SoakPass::index, "Index of the pass; -1: no pass.")
      .def_ro("radius", &SoakPass::radius, "SPR radius [m].")
      .def_ro("speed", &SoakPass::speed, "Speed of the tool [m/s].")
      .def_ro("depth", &SoakPass::depth, "Depth below the surface [m].")
      .def_ro("object_moves", &SoakPass::object_moves, "True if the object moves.");
  nb::class_<SoakReport>(m, "SoakReport", "Outcome of many passes at one mesh.")
      .def_ro("passes", &SoakReport::passes, "Number of passes that found free space to begin in.")
      .def_ro("ticks", &SoakReport::ticks, "Number of ticks.")
      .def_ro("touched", &SoakReport::touched, "Number of passes with a contact force.")
      .def_ro("popped", &SoakReport::crossed, "Number of passes whose proxy crossed the surface.")
      .def_ro("first_popped", &SoakReport::first_crossed, "First pass whose proxy crossed the surface.");
  m.def("soak", &soak, nb::arg("mesh"), nb::arg("method"), nb::arg("passes"), nb::arg("seed"), nb::arg("range"),
        "Simulates random pokes at a mesh at 1 kHz and tests the proxy against each triangle. It releases the "
        "interpreter lock.");
}

}  // namespace palpate::bindings
