#include <nanobind/eigen/dense.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>

#include <cstdint>
#include <utility>

#include "bindings.hpp"
#include "palpate/scene/cloud.hpp"
#include "palpate/scene/distance_grid.hpp"
#include "palpate/scene/implicit_surface.hpp"
#include "palpate/scene/mesh.hpp"
#include "palpate/scene/primitives.hpp"
#include "types.hpp"

namespace nb = nanobind;

namespace palpate::bindings {
namespace {

using Voxels = Input<float, -1, -1, -1>;
using Samples = nb::ndarray<float, nb::ndim<3>, nb::c_contig, nb::device::cpu>;

void make_grid(scene::DistanceGrid* self, const Vec3& origin, const Vec3& spacing, const Voxels& values) {
  const nb::gil_scoped_release release;
  new (self) scene::DistanceGrid(origin, spacing, {values.shape(0), values.shape(1), values.shape(2)},
                                 {values.data(), values.size()});
}

/// A numpy view of the values at the nodes; it keeps the grid alive.
ArrayOf<const float> values_of(nb::handle self) {
  const auto& grid = nb::cast<const scene::DistanceGrid&>(self);
  const auto& n = grid.nodes();
  const auto s = grid.strides();
  return ArrayOf<const float>(nb::cast(nb::ndarray<nb::numpy, const float>(
      grid.values(), {n[0], n[1], n[2]}, self, {static_cast<std::int64_t>(s[0]), static_cast<std::int64_t>(s[1]), 1})));
}

void sample(const scene::Mesh& mesh, const Vec3& origin, const Vec3& spacing, const Samples& values) {
  const nb::gil_scoped_release release;
  scene::sample(mesh, origin, spacing, {values.shape(0), values.shape(1), values.shape(2)},
                {values.data(), values.size()});
}

}  // namespace

/// Call it after bind_mesh, which binds the base class Surface.
void bind_surfaces(nb::module_& m) {
  nb::class_<scene::Plane, scene::Surface>(m, "Plane", "The half-space z <= 0.").def(nb::init<>());
  nb::class_<scene::Sphere, scene::Surface>(m, "Sphere", "A sphere around the origin.")
      .def(nb::init<double>(), nb::arg("radius"), "radius [m].");
  nb::class_<scene::Box, scene::Surface>(m, "Box", "A box around the origin, with its edges along the axes.")
      .def(nb::init<const Vec3&>(), nb::arg("size"), "size: lengths of the edges (3,) [m].");
  nb::class_<scene::Cylinder, scene::Surface>(
      m, "Cylinder", "A cylinder around the z axis with flat ends and its centre at the origin.")
      .def(nb::init<double, double>(), nb::arg("radius"), nb::arg("length"), "radius, length [m].");
  nb::class_<scene::Capsule, scene::Surface>(m, "Capsule", "All points within a radius of a segment of the z axis.")
      .def(nb::init<double, double>(), nb::arg("radius"), nb::arg("length"),
           "radius [m]; length of the segment [m], its centre at the origin.");
  nb::class_<scene::Cloud, scene::Surface>(m, "Cloud", "All points within a radius of a point cloud.")
      .def(
          "__init__",
          [](scene::Cloud* self, const Points& points, double radius) {
            const nb::gil_scoped_release release;
            new (self) scene::Cloud({points.data(), points.size()}, radius);
          },
          nb::arg("points"), nb::arg("radius"), "points (n, 3) [m], radius [m].");
  nb::class_<scene::ImplicitSurface, scene::Surface>(m, "ImplicitSurface",
                                                     "The implicit surface a x^m + b y^n + c z^o = level (Eq 14).")
      .def(nb::init<const Vec3&, const std::array<int, 3>&, double>(), nb::arg("coefficients"), nb::arg("exponents"),
           nb::arg("level"), "coefficients (a, b, c), exponents (m, n, o), level.")
      .def("value", &scene::ImplicitSurface::value, nb::arg("p"), "U(p) - level at p (3,) [m]; negative inside.")
      .def("gradient", &scene::ImplicitSurface::gradient, nb::arg("p"),
           "Gradient of U at p (3,) [m]: (3,) (Eq 15) [1/m].")
      .def_prop_ro("half", &scene::ImplicitSurface::half, "Half the extent along each axis (3,) [m].");
  nb::class_<scene::DistanceGrid, scene::Surface>(m, "DistanceGrid",
                                                  "A signed distance sampled on a grid and interpolated tricubically.")
      .def("__init__", &make_grid, nb::arg("origin"), nb::arg("spacing"), nb::arg("values"),
           "origin, spacing (3,) [m]; values (nx, ny, nz) float32 [m]. Raises ValueError if the values are no signed "
           "distance.")
      .def(
          "value",
          [](const scene::DistanceGrid& grid, const Vec3& p) {
            Vec3 gradient;
            const double v = grid.value(p, gradient);
            return std::make_pair(v, gradient);
          },
          nb::arg("p"), "(distance [m], gradient (3,)) of the interpolated function at p (3,) [m].")
      .def_prop_ro("values", &values_of, "Signed distances at the nodes (nx, ny, nz) float32 [m], read-only.");
  m.def("sample_distance", &sample, nb::arg("mesh"), nb::arg("origin"), nb::arg("spacing"),
        nb::arg("values").noconvert(),
        "Fills values (nx, ny, nz) float32 with the signed distance of a mesh at origin + (i, j, k) * spacing [m]; "
        "origin, spacing (3,) [m].");
}

}  // namespace palpate::bindings
