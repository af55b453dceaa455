// The smooth surface that a mesh of facets approximates, and the distance to it. On a facet with corners v_i, unit
// normals n_i and barycentric weights b_i, the normals are interpolated, and the surface is offset from the facet by a
// height h along the interpolated normal:
//
//   N(b) = sum b_i n_i,    surface point = sum b_i v_i + h(b) N/|N|,
//   h(b) = sum over edges ij of  b_i b_j (bend - lean (b_i - b_j))
//        + sum over corners k of  bump b_k b_i^2 b_j^2 / ((b_k + b_i) (b_k + b_j))
//     bend = 1/2 (v_j - v_i) . (n_j - n_i)      the sagitta: s^2 / 8R in the middle of an arc
//     lean = 1/2 (v_j - v_i) . (n_j + n_i)      makes the surface perpendicular to the normals at the corners
//     bump                                      makes the slope equal on both sides of an edge (the rational functions
//                                               of Zienkiewicz)
//
// The distance of p is t |N| - h, where foot + t N = p and the foot is a point of the facet. The force acts along the
// gradient of this distance and not along N. The spring energy 1/2 k distance^2 is therefore a potential, and closed
// paths return all energy. The height h makes this gradient continuous. Flat regions stay flat, and creases
// (topology.hpp) stay sharp.
#pragma once

#include "palpate/scene/mesh_impl.hpp"

namespace palpate::scene {

/// Point of the smooth surface, as seen from a query point p. All vectors are expressed in the surface's frame O.
struct SmoothPoint {
  bool found = false;            ///< false: the other fields are not valid
  SurfacePoint at;               ///< foot on the facet
  Vec3 point = Vec3::Zero();     ///< point of the smooth surface [m]
  bool above = true;             ///< true: p is on the outer side of the facet
  double distance = 0.0;         ///< signed distance of p along the interpolated normal [m]
  Vec3 gradient = Vec3::Zero();  ///< gradient of the distance, points outwards, nearly a unit vector [-]
  double focal_factor = 1.0;  ///< (1 + t k1)(1 + t k2) with the curvatures k: 0 at a focal point, 1 at the surface [-]
};

/// Point of the smooth surface over the facet point s, with the distance of p along the normal there.
SmoothPoint smooth_at(const Mesh::Impl& mesh, const SurfacePoint& s, const Vec3& p) noexcept;

/// Point of the smooth surface near `start` whose interpolated normal passes through p (p = foot + t N), by Newton's
/// method with a walk over the facets. Not found if p is beyond the focal surface, or if the walk meets a crease or a
/// boundary.
SmoothPoint smooth_project(const Mesh::Impl& mesh, const SurfacePoint& start, const Vec3& p) noexcept;

}  // namespace palpate::scene
