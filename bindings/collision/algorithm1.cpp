#include "palpate/collision/algorithm1.hpp"

#include <vector>

#include "collision/bindings.hpp"
#include "convert.hpp"
#include "palpate/collision/paper_plane.hpp"
#include "palpate/force/force.hpp"
#include "types.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

/// Runs one collision and one cycle of Algorithm 1 on the first object of a scene, and returns the value of every line.
Fields trace(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT, double radius, const Vec3& n_last) {
  collision::CoalSurface surface(radius);
  surface.prepare(scene);
  const collision::CollisionPoints points = surface.collide(scene.objects.at(0), p_WT);

  collision::algorithm1::GrownPlane plane;
  collision::algorithm1::Deflection d;
  ContactSet contacts;
  if (points.size > 0) {
    plane = collision::algorithm1::average(points, n_last, p_WT);
    d = collision::algorithm1::deflect(plane, p_WT, v_WT);
    const double depth = plane.n.dot(d.delta_x);
    contacts.contact[0] = {.object = 0,
                           .p_proxy = p_WT + d.delta_x,
                           .normal = plane.n,
                           .delta_x = d.delta_x,
                           .depth = depth,
                           .material = scene.objects.at(0).material};
    contacts.size = depth > 0.0 ? 1 : 0;
  }
  const force::ForceTerms F = force::step(contacts, {v_WT, Vec3::Zero()}, 1.0, 1.0);

  Rows3 p(points.size, 3), n(points.size, 3);
  Eigen::VectorXd depths(points.size);
  for (int i = 0; i < points.size; ++i) {
    const collision::CollisionPoint& point = points.point[static_cast<std::size_t>(i)];
    p.row(i) = point.p, n.row(i) = point.n, depths[i] = point.depth;
  }
  Fields lines;
  lines["collision"] = points.size > 0;
  lines["points"] = p;
  lines["normals"] = n;
  lines["depths"] = depths;
  lines["normal"] = plane.n;
  lines["delta_x_total"] = d.delta_x_total;
  lines["v_total"] = d.v_total;
  lines["delta_x"] = d.delta_x;
  lines["v"] = d.v;
  lines["force_spring"] = F.F_spring;
  lines["force_damping"] = F.F_damping;
  lines["force"] = F.F;
  return lines;
}

Vec3 grow_plane(const Points& points, const Vec3& n_last, double baseline) {
  std::vector<Vec3> rows;
  rows.reserve(points.shape(0));
  for (std::size_t i = 0; i < points.shape(0); ++i) rows.emplace_back(points.data() + 3 * i);
  return collision::grow_plane(rows, n_last, baseline);
}

}  // namespace

void bind_algorithm1(nb::module_& m) {
  m.def("trace_algorithm1", &trace, "snapshot"_a, "p_WT"_a, "v_WT"_a, "radius"_a, "n_last"_a,
        "Values of every line of Algorithm 1 for one tool position p_WT (3,) and velocity v_WT (3,); in W, SI units.");
  m.def("grow_plane", &grow_plane, "points"_a, "n_last"_a, "baseline"_a,
        "Unit normal (3,) of the plane that the method `paper-plane` fits to points (n, 3) [m]; zero if it rejects "
        "them.");
}

}  // namespace palpate::bindings
