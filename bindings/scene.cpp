#include <nanobind/eigen/dense.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "convert.hpp"
#include "doc.hpp"
#include "palpate/scene/material.hpp"
#include "palpate/scene/mesh.hpp"
#include "palpate/scene/mesh_impl.hpp"
#include "palpate/scene/motion.hpp"
#include "palpate/scene/weld.hpp"
#include "types.hpp"

namespace nb = nanobind;

namespace palpate::bindings {
namespace {

std::shared_ptr<scene::Mesh> build(const Points& vertices, const Triangles& triangles) {
  const nb::gil_scoped_release release;
  const auto mesh = scene::Mesh::build({vertices.data(), vertices.size()}, {triangles.data(), triangles.size()});
  return std::const_pointer_cast<scene::Mesh>(mesh);  // nanobind holds no pointers to const; a mesh is immutable
}

scene::Welded weld(const Points& vertices, const Triangles& triangles) {
  const nb::gil_scoped_release release;
  return scene::weld({vertices.data(), vertices.size()}, {triangles.data(), triangles.size()});
}

std::shared_ptr<scene::Mesh> build_welded(scene::Welded& welded) {
  if (welded.triangles.empty()) throw std::invalid_argument("mesh: these triangles are those of a mesh already");
  const nb::gil_scoped_release release;
  return std::const_pointer_cast<scene::Mesh>(scene::Mesh::build(std::move(welded)));
}

/// A numpy view (n, 3) of values that the owner keeps alive.
template <class T>
ArrayOf<const T> view(nb::handle owner, std::span<const T> values) {
  return ArrayOf<const T>(nb::cast(nb::ndarray<nb::numpy, const T>(values.data(), {values.size() / 3, 3}, owner)));
}

using Bytes = Input<std::uint8_t, -1>;

ArrayOf<std::uint8_t> image(const scene::Mesh& mesh) {
  std::vector<std::uint8_t> bytes = mesh.image();
  const std::size_t n = bytes.size();
  return array(std::move(bytes), {n});
}

/// The pieces of an image as arrays; those of the mesh keep it alive.
std::vector<ArrayOf<const std::uint8_t>> image_pieces(nb::handle self) {
  std::vector<ArrayOf<const std::uint8_t>> found;
  const auto add = [&](std::span<const std::uint8_t> bytes, nb::handle owner) {
    found.emplace_back(nb::cast(nb::ndarray<nb::numpy, const std::uint8_t>(bytes.data(), {bytes.size()}, owner)));
  };
  for (scene::ImagePiece& piece : nb::cast<const scene::Mesh&>(self).image_pieces()) {
    const std::size_t n = piece.head.size();
    found.emplace_back(array(std::move(piece.head), {n}));
    add(piece.array, self);
  }
  return found;
}

std::shared_ptr<scene::Mesh> from_image(const Bytes& bytes) {
  const nb::gil_scoped_release release;
  return std::const_pointer_cast<scene::Mesh>(scene::Mesh::from_image({bytes.data(), bytes.size()}));
}

Tuple<Array, Array, Array, ArrayOf<std::int32_t>> closest(const scene::Mesh& mesh, const Points& points,
                                                          double max_distance) {
  const std::size_t n = points.shape(0);
  std::vector<double> distance(n), point(3 * n), normal(3 * n);
  std::vector<std::int32_t> triangle(n);
  {
    const nb::gil_scoped_release release;
    for (std::size_t i = 0; i < n; ++i) {
      const scene::ClosestPoint c = mesh.closest(Vec3(points.data() + 3 * i), max_distance);
      distance[i] = c.triangle < 0 ? INFINITY : c.distance;
      triangle[i] = c.triangle;
      Vec3::Map(&point[3 * i]) = c.triangle < 0 ? Vec3::Constant(NAN) : c.point;
      Vec3::Map(&normal[3 * i]) = c.normal;
    }
  }
  return nb::make_tuple(array(std::move(distance), {n}), array(std::move(point), {n, 3}),
                        array(std::move(normal), {n, 3}), array(std::move(triangle), {n}));
}

/// Distances by one of the two kernels, for tests that compare the kernels.
Array closest_by_kernel(const scene::Mesh& mesh, const Points& points, const std::string& kernel, double exact_within) {
  if (kernel != "avx2" && kernel != "portable")
    throw nb::value_error(("kernel must be 'avx2' or 'portable'; got '" + kernel + "'").c_str());
  const auto query = kernel == "avx2" ? &scene::bvh_closest_avx2 : &scene::bvh_closest_portable;
  std::vector<double> distance(points.shape(0));
  for (std::size_t i = 0; i < distance.size(); ++i)
    distance[i] =
        std::sqrt(query(mesh.impl().bvh, points.data() + 3 * i, {INFINITY, 0.0, 0.0, -1}, exact_within).distance2);
  return array(std::move(distance), {points.shape(0)});
}

ArrayOf<bool> contains(const scene::Mesh& mesh, const Points& points) {
  const std::size_t n = points.shape(0);
  std::vector<std::uint8_t> inside(n);
  for (std::size_t i = 0; i < n; ++i) inside[i] = mesh.contains(Vec3(points.data() + 3 * i)) ? 1 : 0;
  return ArrayOf<bool>(array(std::move(inside), {n}).attr("astype")("bool"));
}

/// Signed distance (n,), nearest point (n, 3) and normal (n, 3) for points (n, 3).
Tuple<Array, Array, Array> nearest(const scene::Surface& surface, const Points& points) {
  const std::size_t n = points.shape(0);
  std::vector<double> distance(n), point(3 * n), normal(3 * n);
  {
    const nb::gil_scoped_release release;
    for (std::size_t i = 0; i < n; ++i) {
      const scene::Nearest c = surface.nearest(Vec3(points.data() + 3 * i));
      distance[i] = c.distance;
      Vec3::Map(&point[3 * i]) = c.point;
      Vec3::Map(&normal[3 * i]) = c.normal;
    }
  }
  return nb::make_tuple(array(std::move(distance), {n}), array(std::move(point), {n, 3}),
                        array(std::move(normal), {n, 3}));
}

void bind_mesh_report(nb::module_& m) {
  nb::class_<scene::MeshReport>(m, "MeshReport",
                                "Counts of the defects that were found and repaired while a mesh was built.")
      .def_ro("vertices", &scene::MeshReport::vertices, "Number of vertices after welding."_doc)
      .def_ro("triangles", &scene::MeshReport::triangles, "Number of triangles kept."_doc)
      .def_ro("degenerate", &scene::MeshReport::degenerate,
              "Triangles dropped because a corner is repeated or all three are on a line."_doc)
      .def_ro("duplicate", &scene::MeshReport::duplicate,
              "Triangles dropped because another one has the same corners in the same winding."_doc)
      .def_ro("flat", &scene::MeshReport::flat,
              "Triangles kept although their corners are on a line, because they close a gap."_doc)
      .def_ro("parts", &scene::MeshReport::components,
              "Number of connected parts; triangles that share a vertex belong to one part."_doc)
      .def_ro("boundary_edges", &scene::MeshReport::boundary_edges, "Edges of only one triangle: holes and rims."_doc)
      .def_ro("branching_edges", &scene::MeshReport::branching_edges, "Edges of three triangles or more."_doc)
      .def_ro("inconsistent_edges", &scene::MeshReport::inconsistent_edges,
              "Edges whose triangles have opposite windings."_doc)
      .def_ro("turned", &scene::MeshReport::flipped,
              "Triangles turned because they faced the other way than their neighbours."_doc)
      .def_ro("inverted", &scene::MeshReport::inverted,
              "Triangles turned because their closed part was inside out."_doc)
      .def_ro("two_sided", &scene::MeshReport::two_sided,
              "False if a part cannot be oriented, such as a Moebius strip; forces may point inwards there."_doc)
      .def_ro("closed", &scene::MeshReport::closed, "True without boundary, branching and inconsistent edges."_doc)
      .def_ro("volume", &scene::MeshReport::volume, "Volume of the closed parts [m^3]."_doc)
      .def_ro("lowest", &scene::MeshReport::lowest, "Lowest corner of the bounding box (3,) [m]."_doc)
      .def_ro("highest", &scene::MeshReport::highest, "Highest corner of the bounding box (3,) [m]."_doc);
}

void bind_mesh(nb::module_& m) {
  nb::class_<scene::Surface>(m, "Surface",
                             "A surface that the tool can touch: a mesh, a primitive or a distance field.")
      .def("nearest", &nearest, nb::arg("points"),
           "Nearest points of the surface for points (n, 3) [m]: (signed distance (n,) [m], unsigned for an open "
           "surface; nearest point (n, 3) [m]; outward normal (n, 3)).")
      .def_prop_ro(
          "deforms", [](const scene::Surface& self) { return self.deformable() != nullptr; },
          "True if the surface gives way to the tool as a soft body.");
  nb::class_<scene::Welded>(m, "Welded", "Triangles whose equal vertices are one: a mesh in the making.")
      .def(nb::new_(&weld), nb::arg("vertices"), nb::arg("triangles"),
           "vertices (n, 3) [m], triangles (m, 3) int32, which are not needed any more. Raises ValueError as `Mesh`.")
      .def("mesh", &build_welded, "Builds the mesh, which takes the triangles over. Raises ValueError as `Mesh`.");
  nb::class_<scene::Mesh, scene::Surface>(
      m, "Mesh", "A triangle mesh for contact: welded, with normals, adjacency and a bounding volume hierarchy.")
      .def(nb::new_(&build), nb::arg("vertices"), nb::arg("triangles"),
           "vertices (n, 3) [m], triangles (m, 3) int32. Raises ValueError, which names the defect, if they are no "
           "mesh.")
      .def_static("from_image", &from_image, nb::arg("bytes").noconvert(), nb::keep_alive<0, 1>(),
                  "The mesh of `image()`, whose arrays stay in the bytes (n,): nothing may change them afterwards. "
                  "Raises ValueError if the bytes are incomplete or damaged.")
      .def("image", &image, "The mesh and its index as bytes (n,), valid on this machine and in this version.")
      .def(
          "image_pieces", [](nb::handle self) { return image_pieces(self); },
          "The bytes of `image()` as arrays (n,) in their order, of which the long ones are those of the mesh.")
      .def_prop_ro("triangle_count", &scene::Mesh::triangle_count, "Number of triangles.")
      .def_prop_ro("report", &scene::Mesh::report, "Defects found and repaired while the mesh was built.")
      .def_prop_ro(
          "vertices", [](nb::handle self) { return view(self, nb::cast<const scene::Mesh&>(self).vertices()); },
          "Welded vertices (n, 3) [m], read-only.")
      .def_prop_ro(
          "triangles", [](nb::handle self) { return view(self, nb::cast<const scene::Mesh&>(self).triangles()); },
          "Triangles as indices of the welded vertices (m, 3), read-only.")
      .def(
          "rims",
          [](const scene::Mesh& mesh) {
            std::vector<std::int32_t> edges = mesh.rims();
            const std::size_t n = edges.size() / 2;
            return array(std::move(edges), {n, 2});
          },
          "Boundary edges (k, 2) as indices of vertices, in the winding of their triangle.")
      .def("closest", &closest, nb::arg("points"), nb::arg("max_distance") = INFINITY,
           "Closest points on the triangles for points (n, 3) [m]: (distance (n,) [m], point (n, 3) [m], normal (n, "
           "3), triangle (n,)). Beyond max_distance [m]: distance inf, triangle -1.")
      .def(
          "sweep", &scene::Mesh::sweep, nb::arg("a"), nb::arg("b"), nb::arg("radius"),
          "Distance [m] that a sphere of this radius [m] moves from a (3,) towards b (3,) until it touches a triangle.")
      .def("closest_by_kernel", &closest_by_kernel, nb::arg("points"), nb::arg("kernel"),
           nb::arg("exact_within") = INFINITY, "Distances (n,) [m] by the kernel 'avx2' or 'portable', for tests.")
      .def("contains", &contains, nb::arg("points"),
           "True for each of the points (n, 3) [m] inside the mesh (n,); False for an open mesh.");
}

void bind_material(nb::module_& m) {
  using scene::Region;
  nb::class_<Material>(m, "Material",
                       "Stiffness and damping of an object, diagonal along the axes of W, and its friction.")
      .def(
          "__init__",
          [](Material* self, const Vec3& K, const Vec3& B, double mu, double mu_static) {
            new (self) Material{K, B, mu, mu_static};
          },
          nb::arg("K") = Material{}.K, nb::arg("B") = Material{}.B, nb::arg("mu") = Material{}.mu,
          nb::arg("mu_static") = Material{}.mu_static, "K (3,) [N/m], B (3,) [N s/m], mu and mu_static [-].")
      .def_rw("K", &Material::K, "Stiffness (3,) [N/m]."_doc)
      .def_rw("B", &Material::B, "Damping (3,) [N s/m]."_doc)
      .def_rw("mu", &Material::mu, "Coulomb friction coefficient while slipping [-]."_doc)
      .def_rw("mu_static", &Material::mu_static,
              "Coulomb friction coefficient while sticking [-]; values below mu count as mu."_doc);
  nb::class_<Region>(m, "Region", "A region of an object with another material: a box with rounded edges, or a ball.")
      .def(
          "__init__",
          [](Region* self, const Vec3& centre, const Vec3& half, double radius, double blend,
             const Material& material) {
            if (!centre.allFinite() || !half.allFinite() || half.minCoeff() < 0.0 || !(radius >= 0.0) ||
                !std::isfinite(radius) || !(blend > 0.0) || !std::isfinite(blend))
              throw nb::value_error("a region needs a finite centre, half >= 0, radius >= 0 and blend > 0, in metres");
            new (self) Region{centre, half, radius, blend, material};
          },
          nb::arg("centre"), nb::arg("half") = Vec3(Vec3::Zero()), nb::arg("radius") = Region{}.radius,
          nb::arg("blend") = Region{}.blend, nb::arg("material") = Material{},
          "centre (3,), half (3,), radius, blend [m], in O. Raises ValueError if a length is negative or a value not "
          "finite.")
      .def_ro("centre", &Region::centre, "Centre in O (3,) [m]."_doc)
      .def_ro("half", &Region::half, "Half the lengths of the box (3,) [m]; zero: a ball."_doc)
      .def_ro("radius", &Region::radius, "Radius of the ball or of the rounded edges [m]."_doc)
      .def_ro("blend", &Region::blend, "Distance over which the material fades [m]."_doc)
      .def_ro("material", &Region::material, "Material inside the region."_doc)
      .def(
          "weight",
          [](const Region& r, const Vec3& p_O) {
            Vec3 slope;
            return r.weight(p_O, slope);
          },
          nb::arg("p_O"),
          "Weight of the region's material at p_O (3,) [m]: 1 inside, 0 farther away than `blend` [-].");
}

void bind_motion(nb::module_& m) {
  using scene::Motion;
  using scene::Wave;
  nb::class_<Wave>(m, "Wave", "A sinusoidal component of a Motion.")
      .def(
          "__init__",
          [](Wave* self, const Vec3& shift, const Vec3& rotation, double period, double phase) {
            if (!shift.allFinite() || !rotation.allFinite() || !(period > 0.0) || !std::isfinite(period) ||
                !std::isfinite(phase))
              throw nb::value_error("a wave needs finite amplitudes and phase, and a period above zero");
            new (self) Wave{shift, rotation, period, phase};
          },
          nb::arg("shift") = Vec3(Vec3::Zero()), nb::arg("turn") = Vec3(Vec3::Zero()), nb::arg("period") = 1.0,
          nb::arg("phase") = 0.0,
          "Amplitudes shift (3,) [m] and turn (3,), a rotation vector [rad]; period [s]; phase [rad].");
  nb::class_<Motion>(m, "Motion", "Motion of an object from its pose at rest: a constant velocity plus sinusoids.")
      .def(
          "__init__",
          [](Motion* self, const Vec3& v, const Vec3& w, std::vector<Wave> waves, const Vec3& about) {
            if (!v.allFinite() || !w.allFinite() || !about.allFinite())
              throw nb::value_error("a motion needs finite velocities and a finite centre");
            new (self) Motion{{v, w}, std::move(waves), about, 0.0};
          },
          nb::arg("v") = Vec3(Vec3::Zero()), nb::arg("w") = Vec3(Vec3::Zero()), nb::arg("waves") = std::vector<Wave>{},
          nb::arg("about") = Vec3(Vec3::Zero()),
          "Velocity v (3,) [m/s], angular velocity w (3,) [rad/s], sinusoids, and the centre of rotation about (3,) "
          "[m].")
      .def(
          "pose",
          [](const Motion& self, const Matrix4& X_WO, double t) {
            return to_matrix(self.pose(to_pose(X_WO, "X_WO"), t));
          },
          nb::arg("X_WO"), nb::arg("t"), "Pose (4, 4) [m] at t [s] of an object with the rest pose X_WO.");
}

}  // namespace

void bind_scene(nb::module_& m) {
  bind_mesh_report(m);
  bind_mesh(m);
  bind_surfaces(m);
  m.attr("CREASE_ANGLE") = scene::kCreaseAngle;
  m.def("bvh_has_avx2", &scene::bvh_has_avx2, "True if the processor supports the AVX2 kernel.");
  bind_material(m);
  bind_motion(m);
}

}  // namespace palpate::bindings
