// The smooth surface that a mesh of facets stands for, and a distance to it. On a facet with corners v_i, unit
// normals n_i and weights b_i, the normals are interpolated, and a height stands on the facets along them:
//
//   N(b) = sum b_i n_i,    surface point = sum b_i v_i + h(b) N/|N|,
//   h(b) = sum over edges ij of  b_i b_j (bend - lean (b_i - b_j))  +  sum over corners k of  bump b_k b_i^2 b_j^2 /
//   ...
//     bend = 1/2 (v_j - v_i) . (n_j - n_i)      the sagitta: s^2 / 8R in the middle of an arc
//     lean = 1/2 (v_j - v_i) . (n_j + n_i)      turns the surface square to the normals at the corners
//     bump / ((b_k + b_i) (b_k + b_j))          makes the slope the same on both sides of an edge (Zienkiewicz's
//                                               rational functions)
//
// The distance of p is t |N| - h where foot + t N = p. Its gradient, not N, is the direction of the force: the spring
// 1/2 k distance^2 is then a potential, and closed paths give back what they took; the height is there to make this
// gradient continuous. Flat regions stay flat; creases (topology.hpp) stay sharp.
#pragma once

#include "palpate/scene/mesh_impl.hpp"

namespace palpate::scene {

struct SmoothPoint {
  bool found = false;
  SurfacePoint at;
  Vec3 point = Vec3::Zero();     ///< of the smooth surface [m]
  bool above = true;             ///< p is on the outer side of the facet
  double distance = 0.0;         ///< of p, signed, along the interpolated normal [m]
  Vec3 gradient = Vec3::Zero();  ///< of this distance: points out, nearly a unit vector
  double spread = 1.0;           ///< how far from a focal point p is, 0 to 1: (1 + t k1)(1 + t k2), k the curvatures
};

/// The smooth surface above a given point of a facet, as p sees it along the normal there.
SmoothPoint smooth_at(const Mesh::Impl& mesh, const SurfacePoint& s, const Vec3& p) noexcept;

/// The point near `start` whose normal goes through p (p = foot + t N), by Newton's method, walking over facets.
/// Not found: p is beyond the focal surface, or the way leads over a crease or a rim.
SmoothPoint smooth_project(const Mesh::Impl& mesh, const SurfacePoint& start, const Vec3& p) noexcept;

}  // namespace palpate::scene
