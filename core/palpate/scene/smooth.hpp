// The smooth surface that a mesh of facets stands for: normals interpolated between the vertices, and a height over
// the facets that agrees with them. On a facet with corners v_i, normals n_i and weights b_i:
//
//   N(b) = sum b_i n_i,    surface point = sum b_i v_i + h(b) N/|N|,
//   h(b) = 1/2 sum_{i<j} b_i b_j (v_j - v_i) . (n_j - n_i)     (the sagitta: s^2 / 8R in the middle of an arc)
//
// Flat regions stay flat; creases (topology.hpp) stay sharp.
#pragma once

#include "palpate/scene/mesh_impl.hpp"

namespace palpate::scene {

struct SmoothPoint {
  bool found = false;
  SurfacePoint at;
  Vec3 foot = Vec3::Zero();    ///< point of the facet [m]
  Vec3 normal = Vec3::Zero();  ///< unit, outwards
  double height = 0.0;         ///< of the smooth surface above the facet, along the normal [m]
  double spread = 1.0;         ///< how far from a focal point p is, 0 to 1: (1 + t k1)(1 + t k2), k the curvatures
  double distance = 0.0;       ///< signed, along the normal, from the smooth surface [m]
};

/// The smooth surface above a given point of a facet; `distance` is p's along the normal there.
SmoothPoint smooth_at(const Mesh::Impl& mesh, const SurfacePoint& s, const Vec3& p) noexcept;

/// The point near `start` whose normal goes through p (p = foot + t N), by Newton's method, walking over facets.
/// Not found: p is beyond the focal surface, or the way leads over a crease or a rim.
SmoothPoint smooth_project(const Mesh::Impl& mesh, const SurfacePoint& start, const Vec3& p) noexcept;

}  // namespace palpate::scene
