#include "palpate/verify/soak.hpp"

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include "doc.hpp"
#include "palpate/verify/tissue_soak.hpp"
#include "types.hpp"
#include "verify/bindings.hpp"

namespace nb = nanobind;

namespace palpate::bindings {
namespace {

verify::SoakReport soak(const std::shared_ptr<scene::Mesh>& mesh, const std::string& method, std::int64_t passes,
                        std::uint64_t seed, const verify::SoakRange& range) {
  const nb::gil_scoped_release release;
  return verify::soak(mesh, method, passes, seed, range);
}

void bind_tissue_soak(nb::module_& m) {
  using verify::TissueSoakRange, verify::TissueSoakReport;
  nb::class_<TissueSoakRange>(m, "TissueSoakRange", "Ranges from which each action draws its values.")
      .def(nb::init<>())
      .def_rw("radius", &TissueSoakRange::radius, "Radius of both spheres [m]."_doc)
      .def_rw("speed_min", &TissueSoakRange::speed_min, "Smallest speed [m/s]."_doc)
      .def_rw("speed_max", &TissueSoakRange::speed_max, "Largest speed, that of slides [m/s]."_doc)
      .def_rw("depth", &TissueSoakRange::depth, "Longest way below the surface [m]."_doc)
      .def_rw("force_min", &TissueSoakRange::force_min, "Smallest force at which the tool turns back [N]."_doc)
      .def_rw("force_max", &TissueSoakRange::force_max, "Largest force at which it turns back [N]."_doc)
      .def_rw("hard_share", &TissueSoakRange::hard_share, "Share of the actions beyond force_max [-]."_doc)
      .def_rw("hard_force", &TissueSoakRange::hard_force, "Force at which those turn back [N]."_doc)
      .def_rw("friction", &TissueSoakRange::friction, "Largest coefficient of friction [-]."_doc)
      .def_rw("rest_every", &TissueSoakRange::rest_every, "Actions between two checks at rest."_doc)
      .def_rw("rest", &TissueSoakRange::rest, "Time without contact before a check [s]."_doc)
      .def_rw("hold", &TissueSoakRange::hold, "Time for which a poke is held where it turns back [s]."_doc)
      .def_rw("restless", &TissueSoakRange::restless, "Second difference of the force that is no rest [N]."_doc)
      .def_rw("decay", &TissueSoakRange::decay,
              "Kinetic energy over that of the third of the hold before, below which a swing decays [-]."_doc);
  nb::class_<TissueSoakReport>(m, "TissueSoakReport", "Outcome of many actions at one soft body.")
      .def_ro("pokes", &TissueSoakReport::pokes, "Number of pokes."_doc)
      .def_ro("slides", &TissueSoakReport::slides, "Number of slides."_doc)
      .def_ro("grasps", &TissueSoakReport::grasps, "Number of grasps."_doc)
      .def_ro("hard", &TissueSoakReport::hard, "Number of actions beyond force_max."_doc)
      .def_ro("touched", &TissueSoakReport::touched, "Number of actions with a contact."_doc)
      .def_ro("ticks", &TissueSoakReport::ticks, "Number of ticks."_doc)
      .def_ro("held", &TissueSoakReport::held, "Pokes that were held in contact."_doc)
      .def_ro("restless", &TissueSoakReport::restless,
              "Of these, up to force_max, with a force that did not come to rest."_doc)
      .def_ro("not_finite", &TissueSoakReport::not_finite, "Actions with a force that is not finite."_doc)
      .def_ro("popped", &TissueSoakReport::popped, "Actions in which a sphere lost its contact below the surface."_doc)
      .def_ro("guarded", &TissueSoakReport::guarded,
              "Actions up to force_max in which the guard stopped a divergence."_doc)
      .def_ro("guarded_hard", &TissueSoakReport::guarded_hard, "The same, of the hard actions."_doc)
      .def_ro("hurried", &TissueSoakReport::hurried, "Actions in which the body took more steps."_doc)
      .def_ro("rests", &TissueSoakReport::rests, "Checks at rest."_doc)
      .def_ro("inverted_at_rest", &TissueSoakReport::inverted_at_rest, "Checks with an inverted tetrahedron."_doc)
      .def_ro("moved_at_rest", &TissueSoakReport::moved_at_rest, "Checks with a displaced node."_doc)
      .def_ro("least_volume", &TissueSoakReport::least_volume, "Smallest det F in an action [-]."_doc)
      .def_ro("least_volume_at_rest", &TissueSoakReport::least_volume_at_rest, "Smallest det F at rest [-]."_doc)
      .def_ro("largest_force", &TissueSoakReport::largest_force,
              "Largest force of the actions up to force_max [N]."_doc);
  m.def(
      "soak_tissue", &verify::soak_tissue, nb::arg("surface"), nb::arg("actions"), nb::arg("seed"),
      nb::arg("held_below"), nb::arg("range"), nb::call_guard<nb::gil_scoped_release>(),
      "Pokes, slides and grasps a copy at rest of a soft surface at random, at 1 kHz, above the height held_below [m]. "
      "It releases the interpreter lock.");
}

}  // namespace

void bind_soak(nb::module_& m) {
  using verify::SoakPass, verify::SoakRange, verify::SoakReport;
  nb::class_<SoakRange>(m, "SoakRange", "Ranges from which each pass draws its values.")
      .def(nb::init<>())
      .def_rw("radius_min", &SoakRange::radius_min, "Smallest SPR radius [m]."_doc)
      .def_rw("radius_max", &SoakRange::radius_max, "Largest SPR radius [m]."_doc)
      .def_rw("speed_min", &SoakRange::speed_min, "Smallest speed of the tool [m/s]."_doc)
      .def_rw("speed_max", &SoakRange::speed_max, "Largest speed of the tool [m/s]."_doc)
      .def_rw("depth", &SoakRange::depth, "Largest depth below the surface [m]."_doc)
      .def_rw("drag", &SoakRange::drag, "Largest length of the drag that follows, in any direction [m]."_doc)
      .def_rw("angle", &SoakRange::angle, "Largest angle between the motion and the surface normal [rad]."_doc)
      .def_rw("object_speed", &SoakRange::object_speed, "Largest speed of the object [m/s]."_doc);
  nb::class_<SoakPass>(m, "SoakPass", "Values of one pass.")
      .def_ro("index", &SoakPass::index, "Index of the pass; -1: no pass."_doc)
      .def_ro("radius", &SoakPass::radius, "SPR radius [m]."_doc)
      .def_ro("speed", &SoakPass::speed, "Speed of the tool [m/s]."_doc)
      .def_ro("depth", &SoakPass::depth, "Depth below the surface [m]."_doc)
      .def_ro("object_moves", &SoakPass::object_moves, "True if the object moves."_doc);
  nb::class_<SoakReport>(m, "SoakReport", "Outcome of many passes at one mesh.")
      .def_ro("passes", &SoakReport::passes, "Number of passes that found free space to begin in."_doc)
      .def_ro("ticks", &SoakReport::ticks, "Number of ticks."_doc)
      .def_ro("touched", &SoakReport::touched, "Number of passes with a contact force."_doc)
      .def_ro("popped", &SoakReport::crossed, "Number of passes whose proxy crossed the surface."_doc)
      .def_ro("first_popped", &SoakReport::first_crossed, "First pass whose proxy crossed the surface."_doc);
  m.def("soak", &soak, nb::arg("mesh"), nb::arg("method"), nb::arg("passes"), nb::arg("seed"), nb::arg("range"),
        "Simulates random pokes at a mesh at 1 kHz and tests the proxy against each triangle. It releases the "
        "interpreter lock.");
  bind_tissue_soak(m);
}

}  // namespace palpate::bindings
