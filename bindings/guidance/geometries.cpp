#include <nanobind/eigen/dense.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "convert.hpp"
#include "guidance/bindings.hpp"
#include "palpate/guidance/geometry/combine.hpp"
#include "palpate/guidance/geometry/cone.hpp"
#include "palpate/guidance/geometry/framed.hpp"
#include "palpate/guidance/geometry/line.hpp"
#include "palpate/guidance/geometry/path.hpp"
#include "palpate/guidance/geometry/point.hpp"
#include "palpate/guidance/geometry/surface.hpp"
#include "types.hpp"

namespace nb = nanobind;

namespace palpate::bindings {
namespace {

using guidance::Geometry;
using Controls = Input<double, -1, 4, 3>;
using Rotations = Input<double, -1, 3, 3>;

/// Results of n queries: one array for each field of guidance::Query.
struct Answers {
  explicit Answers(std::size_t n)
      : distance(n),
        along(n),
        normal(3 * n),
        point(3 * n),
        velocity(3 * n),
        spin(3 * n),
        basis(9 * n),
        attitude(9 * n),
        dimension(n) {}

  void put(std::size_t i, const guidance::Query& q) {
    distance[i] = q.distance;
    along[i] = q.arc_length;
    dimension[i] = q.dimension;
    Vec3::Map(&normal[3 * i]) = q.normal;
    Vec3::Map(&point[3 * i]) = q.point;
    Vec3::Map(&velocity[3 * i]) = q.velocity;
    Vec3::Map(&spin[3 * i]) = q.spin;
    RowMat3::Map(&basis[9 * i]) = q.basis;
    RowMat3::Map(&attitude[9 * i]) = q.attitude;
  }

  Fields take() {
    const std::size_t n = distance.size();
    Fields out;
    out["distance"] = array(std::move(distance), {n});
    out["normal"] = array(std::move(normal), {n, 3});
    out["point"] = array(std::move(point), {n, 3});
    out["basis"] = array(std::move(basis), {n, 3, 3});
    out["velocity"] = array(std::move(velocity), {n, 3});
    out["spin"] = array(std::move(spin), {n, 3});
    out["attitude"] = array(std::move(attitude), {n, 3, 3});
    out["along"] = array(std::move(along), {n});
    out["dimension"] = array(std::move(dimension), {n});
    return out;
  }

  std::vector<double> distance, along, normal, point, velocity, spin, basis, attitude;
  std::vector<std::int32_t> dimension;
};

Fields query(const Geometry& geometry, const Poses& X_WT, const Times& t, double exact_within) {
  const std::size_t n = X_WT.shape(0);
  if (t.shape(0) != n)
    throw std::invalid_argument("t must have one time for each pose in X_WT; got " + std::to_string(t.shape(0)) +
                                " times and " + std::to_string(n) + " poses");
  Answers answers(n);
  {
    const nb::gil_scoped_release release;
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Map<const RowMat4> X(X_WT.data() + 16 * i);
      answers.put(i, geometry.query({X.topLeftCorner<3, 3>(), X.topRightCorner<3, 1>()}, t.data()[i], exact_within));
    }
  }
  return answers.take();
}

void make_path(guidance::Path* self, const Controls& controls, const Rotations& attitudes, bool tangential,
               bool closed) {
  std::vector<guidance::Path::Controls> pieces(controls.shape(0));
  for (std::size_t i = 0; i < pieces.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k) pieces[i][k] = Vec3(controls.data() + 12 * i + 3 * k);
  std::vector<Mat3> R(attitudes.shape(0));
  for (std::size_t i = 0; i < R.size(); ++i) R[i] = Eigen::Map<const RowMat3>(attitudes.data() + 9 * i);
  new (self) guidance::Path(std::move(pieces), R, tangential, closed);
}

guidance::Combination::Kind kind(const std::string& name) {
  using Kind = guidance::Combination::Kind;
  if (name == "union") return Kind::unite;
  if (name == "intersection") return Kind::intersect;
  if (name == "difference") return Kind::subtract;
  throw std::invalid_argument("kind must be 'union', 'intersection' or 'difference'; got '" + name + "'");
}

void bind_modifiers(nb::module_& m) {
  nb::class_<guidance::Offset, Geometry>(m, "OffsetGeometry", "All points within a margin of a geometry.")
      .def(
          "__init__",
          [](guidance::Offset* self, std::shared_ptr<Geometry> geometry, double margin) {
            new (self) guidance::Offset(std::move(geometry), margin);
          },
          nb::arg("geometry"), nb::arg("margin"), "margin [m].");
  nb::class_<guidance::Combination, Geometry>(m, "CombinedGeometry",
                                              "A union, an intersection or a difference of solids.")
      .def(
          "__init__",
          [](guidance::Combination* self, const std::string& name, const std::vector<std::shared_ptr<Geometry>>& parts,
             double blend) { new (self) guidance::Combination(kind(name), {parts.begin(), parts.end()}, blend); },
          nb::arg("kind"), nb::arg("parts"), nb::arg("blend") = 0.0,
          nb::sig("def __init__(self, kind: typing.Literal['union', 'intersection', 'difference'], parts: "
                  "collections.abc.Sequence[Geometry], blend: float = 0.0) -> None"),
          "kind: union, intersection, or difference (the first part without the others). blend: difference of two "
          "parts' distances below which the normal turns gradually from one to the other [m]; 0: it turns at once.");
}

void bind_shapes(nb::module_& m) {
  nb::class_<guidance::Point, Geometry>(m, "PointGeometry", "The point at the origin of its frame.").def(nb::init<>());
  nb::class_<guidance::Line, Geometry>(m, "LineGeometry",
                                       "A line segment from a to b (3,) [m]; endless: the whole line through them.")
      .def(nb::init<const Vec3&, const Vec3&, bool>(), nb::arg("a"), nb::arg("b"), nb::arg("endless") = false);
  nb::class_<guidance::Solid, Geometry>(m, "SurfaceGeometry", "A surface of the scene, in its own frame.")
      .def(
          "__init__",
          [](guidance::Solid* self, std::shared_ptr<scene::Surface> surface) {
            new (self) guidance::Solid(std::move(surface));
          },
          nb::arg("surface"), "surface: a Surface of the scene, such as a Mesh.");
  nb::class_<guidance::Path, Geometry>(m, "PathGeometry", "A curve of cubic Bezier pieces.")
      .def("__init__", &make_path, nb::arg("controls"), nb::arg("attitudes"), nb::arg("tangential"), nb::arg("closed"),
           "controls (n, 4, 3): control points [m]. attitudes (n + 1, 3, 3): rotations at the ends of the pieces. "
           "tangential: the z axes follow the tangent between these ends. closed: the curve ends where it starts.")
      .def_prop_ro("length", &guidance::Path::length, "Length of the curve [m].");
  nb::class_<guidance::Cone, Geometry>(m, "ConeGeometry", "An infinite cone.")
      .def(nb::init<const Vec3&, const Vec3&, double>(), nb::arg("apex"), nb::arg("axis"), nb::arg("half_angle"),
           "axis (3,): direction from the apex (3,) [m] into the cone; half_angle [rad].");
}

}  // namespace

void bind_geometries(nb::module_& m) {
  nb::class_<Geometry>(m, "Geometry", "Geometry of a fixture (core/palpate/guidance/geometry.hpp).")
      .def_prop_ro("solid", &Geometry::solid, "True if the geometry has an inside.")
      .def_prop_ro("has_axis", &Geometry::has_axis,
                   "True if the geometry has an axis; points, balls and clouds have none.")
      .def("query", &query, nb::arg("X_WT"), nb::arg("t"), nb::arg("exact_within") = double{Geometry::kEverywhere},
           "Queries for n tool poses X_WT (n, 4, 4) at times t (n,) [s]: a dict with one array of n entries for each "
           "field of guidance::Query. Beyond exact_within [m] a distance may be a lower bound.");
  bind_shapes(m);
  bind_modifiers(m);
  nb::class_<guidance::FramedGeometry, Geometry>(m, "PlacedGeometry",
                                                 "A geometry placed at X_FG (4, 4) in a frame; the default frame is W.")
      .def(
          "__init__",
          [](guidance::FramedGeometry* self, std::shared_ptr<Geometry> geometry, const Matrix4& X_FG,
             std::shared_ptr<scene::Frame> frame) {
            new (self) guidance::FramedGeometry(std::move(geometry), to_pose(X_FG, "X_FG"), std::move(frame));
          },
          nb::arg("geometry"), nb::arg("X_FG") = Matrix4(Matrix4::Identity()),
          nb::arg("frame") = std::shared_ptr<scene::Frame>(std::make_shared<scene::MotionFrame>(Pose{})));
}

}  // namespace palpate::bindings
