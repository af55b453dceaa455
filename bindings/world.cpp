// The objects of a scene and their snapshot.
#include <nanobind/eigen/dense.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"
#include "convert.hpp"
#include "doc.hpp"
#include "palpate/scene/snapshot.hpp"
#include "types.hpp"

namespace nb = nanobind;

namespace palpate::bindings {
namespace {

void bind_object(nb::module_& m) {
  using scene::Object;
  nb::class_<Object>(m, "Object", "A surface with a pose, a material, and regions of other materials.")
      .def(
          "__init__",
          [](Object* self, std::string name, std::shared_ptr<scene::Surface> surface, const Matrix4& X_WO,
             const Material& material, std::vector<scene::Region> regions, scene::Motion motion, bool is_virtual,
             bool is_real, const std::optional<scene::LiveOptions>& live) {
            if (live && !motion.is_static()) throw nb::value_error("a live object has no motion of its own");
            new (self) Object{std::move(name),
                              std::move(surface),
                              to_pose(X_WO, "X_WO"),
                              material,
                              std::move(regions),
                              std::move(motion),
                              is_virtual,
                              is_real,
                              live};
          },
          nb::arg("name"), nb::arg("surface"), nb::arg("X_WO") = Matrix4(Matrix4::Identity()),
          nb::arg("material") = Material{}, nb::arg("regions") = std::vector<scene::Region>{},
          nb::arg("motion") = scene::Motion{}, nb::arg("is_virtual") = true, nb::arg("is_real") = true,
          nb::arg("live") = nb::none(),
          "is_virtual: the contact stage renders it. is_real: it stops the tool of a driven follower. live: its "
          "pose is set while a loop runs (set_live).")
      .def_ro("name", &Object::name, "Name of the object."_doc)
      .def_prop_ro(
          "surface", [](const Object& o) { return std::const_pointer_cast<scene::Surface>(o.surface); },
          "Surface, in O.")
      .def_prop_rw(
          "X_WO", [](const Object& o) { return to_matrix(o.X_WO); },
          [](Object& o, const Matrix4& X) { o.X_WO = to_pose(X, "X_WO"); }, "Pose in W at rest (4, 4).")
      .def_rw("material", &Object::material, "Material outside the regions."_doc)
      .def_prop_ro(
          "is_live", [](const Object& o) { return o.live.has_value(); }, "True if its pose is set while a loop runs.")
      .def(
          "pose", [](const Object& o, double t) { return to_matrix(o.pose(t)); }, nb::arg("t"),
          "Pose X_WO (4, 4) at t [s].")
      .def(
          "velocity", [](const Object& o, const Vec3& p_W, double t) { return o.motion.velocity(p_W, t); },
          nb::arg("p_W"), nb::arg("t"), "Velocity (3,) [m/s] of the material point that is at p_W (3,) [m] at t [s].")
      .def(
          "feel",
          [](const Object& o, const Vec3& p_O) -> Tuple<Material, Mat3> {
            const scene::LocalMaterial local = o.material_at(p_O);
            return nb::make_tuple(local.material, local.dK);
          },
          nb::arg("p_O"),
          "Material at p_O (3,) [m], regions included: (material, gradients of K (3, 3), one row for each entry of K "
          "[N/m^2]).");
}

void bind_snapshot(nb::module_& m) {
  using scene::Object;
  m.attr("MAX_OBJECTS") = scene::kMaxObjects;
  nb::class_<scene::Snapshot>(m, "Snapshot", "The objects of a scene; immutable during a tick, replaced as a whole.")
      .def(
          "__init__",
          [](scene::Snapshot* self, std::vector<Object> objects) {
            if (objects.size() > scene::kMaxObjects)
              throw nb::value_error(("a snapshot holds at most " + std::to_string(scene::kMaxObjects) +
                                     " objects, got " + std::to_string(objects.size()))
                                        .c_str());
            new (self) scene::Snapshot{std::move(objects)};
          },
          nb::arg("objects"), "Raises ValueError if there are too many objects; the message states the limit.")
      .def_ro("objects", &scene::Snapshot::objects, "The objects, in order."_doc);
}

}  // namespace

void bind_world(nb::module_& m) {
  bind_object(m);
  bind_snapshot(m);
}

}  // namespace palpate::bindings
