// Surfaces through point clouds, and the usable points of a camera's frame.
#include <nanobind/eigen/dense.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>

#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "convert.hpp"
#include "palpate/clouds/point_frame.hpp"
#include "palpate/clouds/point_surface.hpp"
#include "tissue/bindings.hpp"
#include "types.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using clouds::PointSurface;
using Balls = Input<double, -1, 4>;

std::span<const double> span_of(const Points& points) { return {points.data(), 3 * points.shape(0)}; }

void make(PointSurface* self, const Points& points, const std::optional<Points>& normals,
          const std::optional<Vec3>& viewpoint, double voxel, double support, double bridge, double thickness,
          const PointSurface* continues) {
  const nb::gil_scoped_release release;
  const std::span<const double> n = normals ? span_of(*normals) : std::span<const double>();
  new (self) PointSurface({span_of(points), n, viewpoint}, {voxel, support, bridge, thickness}, continues);
}

/// Positions (n, 3), normals (n, 3) and weights (n,) of the averaged points.
Tuple<Array, Array, Array> averaged(const PointSurface& self) {
  const auto& points = self.grid().points();
  std::vector<double> p, n, w;
  p.reserve(3 * points.size());
  n.reserve(3 * points.size());
  w.reserve(points.size());
  for (const clouds::GridPoint& s : points) {
    for (int k = 0; k < 3; ++k) {
      p.push_back(static_cast<double>(s.p[k]) + self.grid().origin()[k]);
      n.push_back(static_cast<double>(s.n[k]));
    }
    w.push_back(static_cast<double>(s.weight));
  }
  const std::size_t count = points.size();
  return nb::make_tuple(array(std::move(p), {count, 3}), array(std::move(n), {count, 3}), array(std::move(w), {count}));
}

std::optional<Vec3> shift_to(const PointSurface& self, const Points& points, const Vec3& centre, double radius) {
  const nb::gil_scoped_release release;
  return self.shift_to(span_of(points), centre, radius);
}

template <typename Number>
Tuple<Array, Fields> usable(const Input<Number, -1, 3>& points_C, const Matrix4& X_WC, const Vec3& centre,
                            double radius, const Balls& tool) {
  const Pose X = to_pose(X_WC, "X_WC");
  std::vector<clouds::Ball> balls;
  balls.reserve(tool.shape(0));
  for (std::size_t i = 0; i < tool.shape(0); ++i) balls.push_back({Vec3(&tool(i, 0)), tool(i, 3)});
  clouds::FrameCount count;
  std::vector<double> found;
  {
    const nb::gil_scoped_release release;
    const std::span<const Number> frame(points_C.data(), 3 * points_C.shape(0));
    found = clouds::usable_points(frame, X, {centre, radius}, balls, count);
  }
  nb::dict counts;
  counts["used"] = count.used;
  counts["invalid"] = count.invalid;
  counts["outside"] = count.outside;
  counts["tool"] = count.tool;
  const std::size_t n = found.size() / 3;
  return nb::make_tuple(array(std::move(found), {n, 3}), counts);
}

}  // namespace

/// The base class Surface is bound in _core.
void bind_clouds(nb::module_& m) {
  const clouds::PointSurfaceOptions o;
  nb::class_<PointSurface, scene::Surface>(m, "PointSurface", "The surface through a point cloud (algebraic spheres).")
      .def("__init__", &make, "points"_a, "normals"_a = nb::none(), "viewpoint"_a = nb::none(), "voxel"_a = o.voxel,
           "support"_a = o.support, "bridge"_a = o.bridge, "thickness"_a = o.thickness, "continues"_a = nb::none(),
           "points (n, 3) [m]; normals (n, 3), zero where unknown; viewpoint (3,): position of the sensor, which "
           "orients "
           "unknown normals [m]; voxel, support, bridge, thickness [m]; continues: surface of the previous frame.")
      .def("averaged", &averaged, "Averaged points: positions (n, 3) [m], normals (n, 3), weights (n,).")
      .def("shift_to", &shift_to, "points"_a, "centre"_a, "radius"_a,
           "Displacement (3,) [m] by which the surface moved to pass through the points (n, 3) within radius [m] of "
           "centre (3,) [m]; None if it cannot be determined.")
      .def("translate", &PointSurface::translate, "d"_a,
           "Moves the surface by d (3,) [m]; only before it is handed to a loop.")
      .def_prop_ro("id", &PointSurface::id, "Number of the stream of surfaces.")
      .def_prop_ro(
          "rejected", [](const PointSurface& s) { return s.grid().rejected(); },
          "Number of averaged points left out as flying pixels.")
      .def("__len__", [](const PointSurface& s) { return s.grid().points().size(); }, "Number of averaged points.");
  constexpr const char* kUsable =
      "(points (n, 3) in W [m], counts) of a frame (m, 3) of float or double in the camera's frame [m]: those that are "
      "finite, within radius [m] of centre (3,) in W, and outside the balls tool (k, 4) in W, centre and radius [m]. "
      "counts: used, invalid, outside, tool.";
  m.def("usable_points", &usable<float>, "points_C"_a.noconvert(), "X_WC"_a, "centre"_a, "radius"_a, "tool"_a, kUsable);
  m.def("usable_points", &usable<double>, "points_C"_a.noconvert(), "X_WC"_a, "centre"_a, "radius"_a, "tool"_a,
        kUsable);
}

}  // namespace palpate::bindings
